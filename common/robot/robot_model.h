// The robot: kinematics, masses, limits and collision volumes, from a URDF and a robot YAML. MuJoCo stands behind it.
//
// Configuration q: x y z yaw pitch roll of the base link in the world (R = Rz Ry Rx), then one value a joint in the
// model's order; size dof() = 6 + joints(). Jacobians are with respect to q (6 rows: linear, then angular velocity, world axes).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"

namespace periplus::robot {

struct Joint {
  std::string name;
  double lower = 0, upper = 0;        // [rad]
  double max_speed = 0;               // [rad/s]
  double max_torque = 0;              // [Nm]
  double half_sitting = 0;            // [rad]
  // Where computed postures keep it: room for the stabiliser, knees neither straight nor saturated [rad].
  double posture_lower = 0, posture_upper = 0;
};

// A capsule fixed to a link: segment a-b in the link's frame and radius [m].
struct Capsule {
  std::string link;
  Eigen::Vector3d a, b;
  double radius = 0;
  std::string name;
};

// A camera fixed to a link.
struct Camera {
  std::string name;                   // left | right | wide
  std::string link;
  Pose X_LC;                          // optical frame in the link's frame
  Pinhole pinhole;
};

// Sole rectangle in the sole frame (x forward, z up, on the floor): [m].
struct Foot {
  std::string link;
  Pose X_LS;                          // sole frame in the link's frame
  double x_min = 0, x_max = 0, y_min = 0, y_max = 0;
};

// How far the head may go when a view is chosen (constraints 3.1-3.4) and what the robot needs on the floor.
struct ViewLimits {
  double height_min = 1.0, height_max = 1.35;    // of the left eye [m]
  double pitch_min = -0.436, pitch_max = 1.047;  // of the optical axis, positive down [rad]
  double roll_max = 0.0;
  double yaw_min = -3.14159265358979323846, yaw_max = 3.14159265358979323846;  // of the optical axis in the world; all by default [rad]
  double distance_min = 0.6, distance_max = 2.5; // to the nearest occupied voxel [m]
};

// Bounding box of the half-sitting robot in the floor frame in the middle between its soles (x forward) [m].
struct BodyBox {
  Eigen::Vector3d lower{-0.25, -0.35, 0}, upper{0.25, 0.35, 1.55};
};

class RobotModel {
 public:
  // Throws Error(bad_input) naming what is missing: a link, a joint, a limit, a camera.
  static std::shared_ptr<const RobotModel> load(const std::string& urdf_text, const std::string& yaml_text);
  static std::shared_ptr<const RobotModel> load_files(const std::string& urdf_path, const std::string& yaml_path);
  ~RobotModel();

  const std::string& name() const;
  int dof() const { return 6 + static_cast<int>(joints().size()); }
  const std::vector<Joint>& joints() const;
  int joint_index(const std::string& name) const;         // in joints(); throws Error(bad_input) with the nearest name
  const std::vector<Capsule>& capsules() const;
  // Pairs of capsules() that may touch and must not (neighbouring links left out).
  const std::vector<std::pair<int, int>>& self_collision_pairs() const;
  const Camera& camera(const std::string& name) const;
  StereoRig stereo_rig() const;                           // from cameras left and right
  const Foot& left_foot() const;
  const Foot& right_foot() const;
  const std::string& base_link() const;
  const ViewLimits& view_limits() const;
  const BodyBox& body_box() const;
  double mass() const;                                    // [kg]

  // Half-sitting: the middle between the soles stands at `floor`, the soles are parallel at half-sitting distance at z = 0,
  // the base is upright above them (its own origin stands where the legs put it, a centimetre behind for an HRP-2).
  Eigen::VectorXd half_sitting(const Pose2& floor = {}) const;

  // The robot as MuJoCo's XML: six scalar base joints, then bodies and joints as in the URDF, capsules as geoms, cameras.
  const std::string& mjcf() const;
  const std::string& urdf_text() const;
  const std::string& yaml_text() const;

  struct Impl;                                            // MuJoCo's model, for common/robot and common/render only
  const Impl& impl() const { return *impl_; }

 private:
  explicit RobotModel(std::unique_ptr<Impl> impl);
  static std::shared_ptr<const RobotModel> create(const std::string& urdf_text, const std::string& yaml_text, const std::string& yaml_name);
  std::unique_ptr<Impl> impl_;
};

// The model at one configuration. Not shared between threads: each makes its own.
class Kinematics {
 public:
  explicit Kinematics(std::shared_ptr<const RobotModel> model);
  ~Kinematics();
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  const RobotModel& model() const;
  // dof() numbers, finite; otherwise Error(bad_size) or Error(not_finite).
  void set(const Eigen::VectorXd& q);
  const Eigen::VectorXd& q() const;

  Pose X_WL(const std::string& link) const;
  Pose X_WC(const std::string& camera) const;             // optical frame
  Pose X_WS_left() const;                                 // sole frames
  Pose X_WS_right() const;
  // Of the point p_L fixed to the link: 6 x dof().
  Eigen::MatrixXd jacobian(const std::string& link, const Eigen::Vector3d& p_L = Eigen::Vector3d::Zero()) const;
  Eigen::MatrixXd jacobian_camera(const std::string& camera) const;
  Eigen::MatrixXd jacobian_sole(bool left) const;
  Eigen::Vector3d center_of_mass() const;
  Eigen::MatrixXd jacobian_center_of_mass() const;        // 3 x dof()
  // g(q) of M(q) q'' + c(q, q') + g(q) = tau: what balances gravity; its third number is +weight. dof() numbers [N, Nm].
  Eigen::VectorXd gravity() const;
  // Ends of capsules()[i] in the world.
  void capsule(int i, Eigen::Vector3d& a, Eigen::Vector3d& b) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace periplus::robot
