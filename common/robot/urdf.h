// The part of a URDF that the robot model needs: the tree of links with their masses, and the joints with their limits
// (http://wiki.ros.org/urdf/XML). Geometry is left out: collision volumes stand in the robot YAML.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/pose.h"

namespace periplus::robot {

struct UrdfLink {
  std::string name;
  double mass = 0;                                           // [kg]
  Eigen::Vector3d center_of_mass = Eigen::Vector3d::Zero();  // in the link's frame [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();         // about the centre of mass, link's axes [kg m2]
  int parent_joint = -1;                                     // -1: the root
  std::vector<int> child_joints;                             // in file order
};

enum class UrdfJointType { fixed, revolute, continuous, prismatic };

struct UrdfJoint {
  std::string name;
  UrdfJointType type = UrdfJointType::fixed;
  int parent = -1, child = -1;      // links
  Pose X_PC = Pose::Identity();     // child's frame in the parent's at zero
  Eigen::Vector3d axis{1, 0, 0};    // unit, child's frame
  double lower = 0, upper = 0;      // [rad] or [m]; of a continuous joint -pi and pi
  double effort = 0, velocity = 0;  // [Nm, rad/s] or [N, m/s]
};

struct Urdf {
  std::string name;
  int root = -1;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;

  int find_link(std::string_view name) const;   // -1 if there is none
  std::vector<std::string> link_names() const;
};

// Throws Error(bad_input) that names the link or joint and what is wrong with it: not XML, no root or two, a loop, an
// unknown link, a missing or senseless limit, a negative mass, a number that is none.
Urdf parse_urdf(std::string_view xml);

}  // namespace periplus::robot
