#include "common/robot/mjcf.h"

#include <array>
#include <cstdio>
#include <numbers>

namespace periplus::robot {

namespace {

std::string text_of(double value) {
  std::array<char, 40> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.17g", value);
  return buffer.data();
}

std::string text_of(const Eigen::Vector3d& v) { return text_of(v.x()) + " " + text_of(v.y()) + " " + text_of(v.z()); }

std::string quaternion_of(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return text_of(q.w()) + " " + text_of(q.x()) + " " + text_of(q.y()) + " " + text_of(q.z());
}

std::string quoted(const std::string& name) {
  std::string out = "\"";
  for (const char c : name) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += c;
    }
  }
  return out + "\"";
}

class Writer {
 public:
  Writer(const Urdf& urdf, const std::vector<Capsule>& capsules, const std::vector<Camera>& cameras)
      : urdf_(urdf), capsules_(capsules), cameras_(cameras) {}

  std::string write() {
    out_ = "<mujoco model=" + quoted(urdf_.name) + ">\n";
    // Inertias of other people's URDF files often break the triangle inequality; massless links are common too.
    out_ += "<compiler angle=\"radian\" balanceinertia=\"true\" boundmass=\"1e-9\" boundinertia=\"1e-12\"/>\n";
    out_ += "<default><geom contype=\"0\" conaffinity=\"0\"/></default>\n<worldbody>\n";
    body(urdf_.root);
    return out_ + "</worldbody>\n</mujoco>\n";
  }

 private:
  void body(int link_index) {
    const UrdfLink& link = urdf_.links[link_index];
    out_ += "<body name=" + quoted(link.name);
    if (link.parent_joint < 0) {
      out_ += ">\n";
      constexpr std::array<const char*, 6> axes{"1 0 0", "0 1 0", "0 0 1", "0 0 1", "0 1 0", "1 0 0"};
      for (int i = 0; i < 6; ++i) {
        out_ += std::string("<joint name=\"") + kBaseJoints[i] + "\" type=\"" + (i < 3 ? "slide" : "hinge") + "\" axis=\"" + axes[i] + "\"/>\n";
      }
    } else {
      const UrdfJoint& joint = urdf_.joints[link.parent_joint];
      out_ += " pos=\"" + text_of(joint.X_PC.translation()) + "\" quat=\"" + quaternion_of(joint.X_PC.linear()) + "\">\n";
      if (joint.type != UrdfJointType::fixed) {
        out_ += "<joint name=" + quoted(joint.name) + " type=\"" + (joint.type == UrdfJointType::prismatic ? "slide" : "hinge") + "\" axis=\"" +
                text_of(joint.axis) + "\"";
        if (joint.type != UrdfJointType::continuous && joint.lower < joint.upper) {
          out_ += " limited=\"true\" range=\"" + text_of(joint.lower) + " " + text_of(joint.upper) + "\"";
        }
        out_ += "/>\n";
      }
    }
    if (link.mass > 0) {
      const Eigen::Matrix3d& I = link.inertia;
      out_ += "<inertial pos=\"" + text_of(link.center_of_mass) + "\" mass=\"" + text_of(link.mass) + "\" fullinertia=\"" + text_of(I(0, 0)) + " " +
              text_of(I(1, 1)) + " " + text_of(I(2, 2)) + " " + text_of(I(0, 1)) + " " + text_of(I(0, 2)) + " " + text_of(I(1, 2)) + "\"/>\n";
    } else {
      out_ += "<inertial pos=\"0 0 0\" mass=\"1e-9\" diaginertia=\"1e-12 1e-12 1e-12\"/>\n";
    }
    for (const Capsule& c : capsules_) {
      if (c.link != link.name) continue;
      const bool ball = (c.b - c.a).norm() < 1e-6;
      out_ += "<geom name=" + quoted(c.name) + (ball ? " type=\"sphere\" pos=\"" + text_of(c.a) : " type=\"capsule\" fromto=\"" + text_of(c.a) + " " + text_of(c.b)) +
              "\" size=\"" + text_of(c.radius) + "\" mass=\"0\" group=\"1\" rgba=\"0.75 0.75 0.8 1\"/>\n";
    }
    for (const Camera& c : cameras_) {
      if (c.link != link.name) continue;
      const Eigen::Matrix3d R = c.X_LC.linear() * Eigen::Vector3d(1, -1, -1).asDiagonal();
      out_ += "<camera name=" + quoted(c.name) + " pos=\"" + text_of(c.X_LC.translation()) + "\" quat=\"" + quaternion_of(R) + "\" fovy=\"" +
              text_of(c.pinhole.vertical_fov() * 180.0 / std::numbers::pi) + "\"/>\n";
    }
    for (const int j : link.child_joints) body(urdf_.joints[j].child);
    out_ += "</body>\n";
  }

  const Urdf& urdf_;
  const std::vector<Capsule>& capsules_;
  const std::vector<Camera>& cameras_;
  std::string out_;
};

}  // namespace

std::string write_mjcf(const Urdf& urdf, const std::vector<Capsule>& capsules, const std::vector<Camera>& cameras) {
  return Writer(urdf, capsules, cameras).write();
}

}  // namespace periplus::robot
