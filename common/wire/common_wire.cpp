#include "common/wire/common_wire.h"

#include <cmath>

#include "common/core/error.h"
#include "common/geometry/checks.h"

namespace periplus::wire {

Eigen::Vector3d from_wire(const msg::Vec3& v) {
  return {require_finite(v.x(), "x"), require_finite(v.y(), "y"), require_finite(v.z(), "z")};
}

Pose from_wire(const msg::Pose& X) {
  Eigen::Quaterniond q(require_finite(X.qw(), "qw"), require_finite(X.qx(), "qx"), require_finite(X.qy(), "qy"), require_finite(X.qz(), "qz"));
  require(std::abs(q.norm() - 1) < 1e-3, ErrorCode::bad_input,
          "a pose's quaternion must have length 1, this one has " + std::to_string(q.norm()));
  q.normalize();
  return make_pose(from_wire(X.position()), q.toRotationMatrix());
}

Pose2 from_wire(const msg::Pose2& X) { return {require_finite(X.x(), "x"), require_finite(X.y(), "y"), require_finite(X.yaw(), "yaw")}; }

Pinhole from_wire(const msg::Pinhole& c) {
  require(c.width() <= 8192 && c.height() <= 8192, ErrorCode::bad_input, "camera image size must lie in 1..8192 pixels");
  Pinhole p;
  p.width = static_cast<int>(c.width());
  p.height = static_cast<int>(c.height());
  p.fx = require_finite(c.fx(), "fx");
  p.fy = require_finite(c.fy(), "fy");
  p.cx = require_finite(c.cx(), "cx");
  p.cy = require_finite(c.cy(), "cy");
  p.check();
  return p;
}

StereoRig from_wire(const msg::StereoRig& r) {
  StereoRig rig{from_wire(r.camera()), require_finite(r.baseline(), "baseline")};
  rig.check();
  return rig;
}

object_model::ObjectBox from_wire(const msg::Box& b) {
  object_model::ObjectBox box{from_wire(b.pose_world_box()), from_wire(b.size())};
  require((box.size.array() > 0).all() && (box.size.array() <= 20).all(), ErrorCode::bad_input,
          "an object box needs side lengths in (0, 20] m");
  return box;
}

msg::Vec3 to_wire(const Eigen::Vector3d& v) {
  msg::Vec3 m;
  m.x(v.x());
  m.y(v.y());
  m.z(v.z());
  return m;
}

msg::Pose to_wire(const Pose& X) {
  const Eigen::Quaterniond q(X.linear());
  msg::Pose m;
  m.position(to_wire(Eigen::Vector3d(X.translation())));
  m.qx(q.x());
  m.qy(q.y());
  m.qz(q.z());
  m.qw(q.w());
  return m;
}

msg::Pose2 to_wire(const Pose2& X) {
  msg::Pose2 m;
  m.x(X.x);
  m.y(X.y);
  m.yaw(X.yaw);
  return m;
}

msg::Pinhole to_wire(const Pinhole& c) {
  msg::Pinhole m;
  m.width(static_cast<std::uint32_t>(c.width));
  m.height(static_cast<std::uint32_t>(c.height));
  m.fx(c.fx);
  m.fy(c.fy);
  m.cx(c.cx);
  m.cy(c.cy);
  return m;
}

msg::StereoRig to_wire(const StereoRig& r) {
  msg::StereoRig m;
  m.camera(to_wire(r.camera));
  m.baseline(r.baseline);
  return m;
}

msg::Box to_wire(const object_model::ObjectBox& b) {
  msg::Box m;
  m.pose_world_box(to_wire(b.X_WB));
  m.size(to_wire(b.size));
  return m;
}

msg::NamedNumber named(std::string_view name, double value) {
  msg::NamedNumber n;
  n.name(std::string(name));
  n.value(value);
  return n;
}

void check_id(std::string_view id, const char* what) {
  bool good = !id.empty() && id.size() <= 64;
  for (char c : id)
    good = good && ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' || c == '-');
  require(good && id != "." && id != "..", ErrorCode::bad_input,
          std::string(what) + " must be 1 to 64 of the characters A-Z a-z 0-9 _ . -");
}

std::string id_from_wire(const msg::Id& id, const char* what, bool optional) {
  std::string text = id.to_string();
  if (!(optional && text.empty())) check_id(text, what);
  return text;
}

std::string text_from_wire(const std::vector<std::uint8_t>& octets) { return {octets.begin(), octets.end()}; }
std::vector<std::uint8_t> text_to_wire(std::string_view text) { return {text.begin(), text.end()}; }

Eigen::VectorXd vector_from_wire(const std::vector<double>& v, const char* what, int size) {
  require(size < 0 || static_cast<int>(v.size()) == size, ErrorCode::bad_size,
          std::string(what) + " needs " + std::to_string(size) + " numbers, got " + std::to_string(v.size()));
  Eigen::VectorXd r(static_cast<Eigen::Index>(v.size()));
  for (std::size_t i = 0; i < v.size(); ++i) r[static_cast<Eigen::Index>(i)] = require_finite(v[i], what);
  return r;
}

std::vector<double> vector_to_wire(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

}  // namespace periplus::wire
