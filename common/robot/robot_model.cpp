#include "common/robot/robot_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/robot/capsule_distance.h"
#include "common/robot/names.h"
#include "common/robot/robot_impl.h"
#include "common/robot/urdf.h"

namespace periplus::robot {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

[[noreturn]] void bad(const config::Node& at, const std::string& message) { throw_error(ErrorCode::bad_input, at.where() + ": " + message); }

// `stem`_rad or `stem`_deg, in radians.
bool read_angle(const config::Node& node, const std::string& stem, double& value) {
  double degrees = 0;
  if (!node.read(stem + "_deg", degrees)) return node.read(stem + "_rad", value);
  if (node.has(stem + "_rad")) bad(node, "give " + stem + "_deg or " + stem + "_rad, not both");
  value = degrees * kDegree;
  return true;
}

std::string link_name(const config::Node& node, const Urdf& urdf) {
  const auto name = node.get<std::string>("link");
  if (urdf.find_link(name) < 0) bad(node, unknown_name("link", name, urdf.link_names()));
  return name;
}

void append_joints(const Urdf& urdf, int link, std::vector<Joint>& joints) {
  for (const int j : urdf.links[link].child_joints) {
    const UrdfJoint& joint = urdf.joints[j];
    if (joint.type != UrdfJointType::fixed) {
      joints.push_back({.name = joint.name, .lower = joint.lower, .upper = joint.upper, .max_speed = joint.velocity, .max_torque = joint.effort,
                        .posture_lower = joint.lower, .posture_upper = joint.upper});
    }
    append_joints(urdf, joint.child, joints);
  }
}

// Names of the moving joints between the root and `link`.
std::set<std::string> chain(const Urdf& urdf, const std::string& link) {
  std::set<std::string> names;
  for (int l = urdf.find_link(link); urdf.links[l].parent_joint >= 0; l = urdf.joints[urdf.links[l].parent_joint].parent) {
    names.insert(urdf.joints[urdf.links[l].parent_joint].name);
  }
  return names;
}

void read_joints(const config::Node& root, const Urdf& urdf, RobotModel::Impl& impl) {
  append_joints(urdf, urdf.root, impl.joints);
  double margin = 0;
  read_angle(root, "posture_leg_margin", margin);
  if (margin < 0) bad(root, "posture_leg_margin must not be negative");
  for (const Foot* foot : {&impl.left_foot, &impl.right_foot}) {
    const auto leg = chain(urdf, foot->link);
    for (Joint& joint : impl.joints) {
      if (!leg.contains(joint.name)) continue;
      joint.posture_lower = joint.lower + margin;
      joint.posture_upper = joint.upper - margin;
    }
  }
  std::vector<std::string> names;
  for (const Joint& joint : impl.joints) names.push_back(joint.name);
  const config::Node section = root.child("joints");
  for (const std::string& name : section.keys()) {
    const auto it = std::find_if(impl.joints.begin(), impl.joints.end(), [&](const Joint& joint) { return joint.name == name; });
    if (it == impl.joints.end()) bad(section, unknown_name("joint", name, names));
    const config::Node node = section.child(name);
    read_angle(node, "half_sitting", it->half_sitting);
    read_angle(node, "posture_lower", it->posture_lower);
    read_angle(node, "posture_upper", it->posture_upper);
  }
  for (Joint& joint : impl.joints) {
    if (joint.half_sitting < joint.lower || joint.half_sitting > joint.upper) {
      bad(section, "joint '" + joint.name + "' stands outside its URDF limits in half-sitting");
    }
    joint.posture_lower = std::max(joint.posture_lower, joint.lower);
    joint.posture_upper = std::min(joint.posture_upper, joint.upper);
    // Half-sitting is always a posture.
    joint.posture_lower = std::min(joint.posture_lower, joint.half_sitting);
    joint.posture_upper = std::max(joint.posture_upper, joint.half_sitting);
  }
}

Foot read_foot(const config::Node& feet, const char* side, const Urdf& urdf) {
  if (!feet.has(side)) bad(feet, std::string("the ") + side + " foot is missing");
  const config::Node node = feet.child(side);
  Foot foot;
  foot.link = link_name(node, urdf);
  foot.X_LS = make_pose(node.get<Eigen::Vector3d>("sole_m"), Eigen::Matrix3d::Identity());
  foot.x_min = node.get<double>("x_min_m");
  foot.x_max = node.get<double>("x_max_m");
  foot.y_min = node.get<double>("y_min_m");
  foot.y_max = node.get<double>("y_max_m");
  if (foot.x_min >= foot.x_max || foot.y_min >= foot.y_max) bad(node, "the sole is empty: minima must be below maxima");
  return foot;
}

Camera read_camera(const config::Node& node, const Urdf& urdf) {
  Camera camera;
  camera.name = node.get<std::string>("name");
  camera.link = link_name(node, urdf);
  double yaw = 0, pitch = 0, roll = 0, fovy = 0;
  read_angle(node, "yaw", yaw);
  read_angle(node, "pitch", pitch);
  read_angle(node, "roll", roll);
  camera.X_LC = look_along(node.get<Eigen::Vector3d>("position_m"), yaw, pitch, roll);
  int width = 0, height = 0;
  node.read("width_px", width, {.minimum = 1, .maximum = 8192});
  node.read("height_px", height, {.minimum = 1, .maximum = 8192});
  read_angle(node, "vertical_field_of_view", fovy);
  if (width == 0 || height == 0) bad(node, "give width_px and height_px");
  if (!(fovy > 0.01 && fovy < 3.0)) bad(node, "vertical_field_of_view_deg must be between 1 and 170");
  camera.pinhole = Pinhole::from_vertical_fov(width, height, fovy);
  return camera;
}

void read_capsules(const config::Node& root, const Urdf& urdf, std::vector<Capsule>& capsules) {
  std::set<std::string> seen;
  for (const config::Node& node : root.children("capsules")) {
    Capsule capsule;
    capsule.name = node.get<std::string>("name");
    capsule.link = link_name(node, urdf);
    capsule.a = node.get<Eigen::Vector3d>("a_m");
    capsule.b = node.get<Eigen::Vector3d>("b_m");
    capsule.radius = node.get<double>("radius_m");
    if (capsule.radius <= 0) bad(node, "radius_m must be positive");
    if (!seen.insert(capsule.name).second) bad(node, "two capsules are named '" + capsule.name + "'");
    capsules.push_back(capsule);
  }
  if (capsules.empty()) bad(root, "there are no capsules: without them the robot collides with nothing");
  if (capsules.size() > 256) bad(root, "more than 256 capsules");
}

// Links from `link` up to the root.
std::vector<int> ancestors(const Urdf& urdf, int link) {
  std::vector<int> path{link};
  while (urdf.links[path.back()].parent_joint >= 0) path.push_back(urdf.joints[urdf.links[path.back()].parent_joint].parent);
  return path;
}

// True if no link strictly between the two carries a capsule.
bool neighbours(const Urdf& urdf, const std::vector<char>& has_capsule, int first, int second) {
  std::vector<int> up = ancestors(urdf, first), other = ancestors(urdf, second);
  int meeting = -1;
  while (!up.empty() && !other.empty() && up.back() == other.back()) {
    meeting = up.back();
    up.pop_back();
    other.pop_back();
  }
  const auto blocked = [&](const std::vector<int>& path) {
    return std::any_of(path.begin(), path.end(), [&](int l) { return l != first && l != second && has_capsule[l] != 0; });
  };
  return !blocked(up) && !blocked(other) && (meeting == first || meeting == second || has_capsule[meeting] == 0);
}

void find_pairs(const config::Node& root, const Urdf& urdf, RobotModel::Impl& impl) {
  std::vector<std::string> names;
  std::vector<char> has_capsule(urdf.links.size(), 0);
  for (const Capsule& c : impl.capsules) {
    names.push_back(c.name);
    has_capsule[urdf.find_link(c.link)] = 1;
  }
  std::set<std::pair<int, int>> ignored;
  for (const config::Node& node : root.children("ignored_self_collisions")) {
    const auto index = [&](const char* key) {
      const auto name = node.get<std::string>(key);
      const auto it = std::find(names.begin(), names.end(), name);
      if (it == names.end()) bad(node, unknown_name("capsule", name, names));
      return static_cast<int>(it - names.begin());
    };
    ignored.insert(std::minmax({index("first"), index("second")}));
  }
  for (int i = 0; i < static_cast<int>(impl.capsules.size()); ++i) {
    for (int j = i + 1; j < static_cast<int>(impl.capsules.size()); ++j) {
      const int a = urdf.find_link(impl.capsules[i].link), b = urdf.find_link(impl.capsules[j].link);
      if (a != b && !ignored.contains({i, j}) && !neighbours(urdf, has_capsule, a, b)) impl.self_collision_pairs.emplace_back(i, j);
    }
  }
}

void read_limits(const config::Node& root, RobotModel::Impl& impl) {
  const config::Node view = root.child("view_limits");
  ViewLimits& limits = impl.view_limits;
  view.read("height_min_m", limits.height_min, {.minimum = 0});
  view.read("height_max_m", limits.height_max, {.minimum = 0});
  read_angle(view, "pitch_min", limits.pitch_min);
  read_angle(view, "pitch_max", limits.pitch_max);
  read_angle(view, "roll_max", limits.roll_max);
  view.read("distance_min_m", limits.distance_min, {.minimum = 0});
  view.read("distance_max_m", limits.distance_max, {.minimum = 0});
  if (limits.height_min > limits.height_max || limits.pitch_min > limits.pitch_max || limits.distance_min > limits.distance_max || limits.roll_max < 0) {
    bad(view, "a minimum is above its maximum");
  }
  const config::Node box = root.child("body_box");
  box.read("lower_m", impl.body_box.lower);
  box.read("upper_m", impl.body_box.upper);
  if (!(impl.body_box.lower.array() < impl.body_box.upper.array()).all()) bad(box, "lower_m must be below upper_m");
}

// Where the base stands in half-sitting; refuses a half-sitting posture that is none.
void settle(const std::string& where, const std::shared_ptr<RobotModel>& model, RobotModel::Impl& impl) {
  const auto refuse = [&](const std::string& what) { throw_error(ErrorCode::bad_input, where + ": in half-sitting " + what); };
  Kinematics kinematics(model);
  const Pose left = kinematics.X_WS_left(), right = kinematics.X_WS_right();
  const auto flat = [](const Pose& X) { return std::abs(X.linear()(2, 0)) < 0.005 && std::abs(X.linear()(2, 1)) < 0.005; };
  if (!flat(left) || !flat(right)) refuse("the soles are not level; correct the angles of the legs");
  if (std::abs(left.translation().z() - right.translation().z()) > 0.002) refuse("the soles do not stand at one height");
  const Pose2 l = to_pose2(left), r = to_pose2(right);
  if (std::abs(wrap_angle(l.yaw - r.yaw)) > 0.01) refuse("the soles are not parallel");
  impl.base_height = -0.5 * (left.translation().z() + right.translation().z());
  impl.sole_middle = {0.5 * (l.x + r.x), 0.5 * (l.y + r.y), l.yaw};
  for (const auto& [i, j] : impl.self_collision_pairs) {
    Eigen::Vector3d a1, b1, a2, b2;
    kinematics.capsule(i, a1, b1);
    kinematics.capsule(j, a2, b2);
    const Capsule &first = impl.capsules[i], &second = impl.capsules[j];
    if (closest_points(a1, b1, a2, b2).distance < first.radius + second.radius) {
      refuse("capsules '" + first.name + "' and '" + second.name + "' overlap; make them smaller or name the pair in ignored_self_collisions");
    }
  }
}

}  // namespace

RobotModel::RobotModel(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RobotModel::~RobotModel() = default;

std::shared_ptr<const RobotModel> RobotModel::create(const std::string& urdf_text, const std::string& yaml_text, const std::string& yaml_name) {
  const Urdf urdf = parse_urdf(urdf_text);
  const config::Node root = config::parse(yaml_text, yaml_name);
  std::string schema;
  root.read_choice("schema", schema, {"periplus-robot-1"});

  const std::shared_ptr<RobotModel> model(new RobotModel(std::make_unique<Impl>()));
  Impl& impl = *model->impl_;
  impl.urdf_text = urdf_text;
  impl.yaml_text = yaml_text;
  impl.name = urdf.name;
  root.read("name", impl.name);
  impl.base_link = urdf.links[urdf.root].name;
  std::string base = impl.base_link;
  root.read("base_link", base);
  if (base != impl.base_link) bad(root, "base_link is '" + base + "', but the URDF's root link is '" + impl.base_link + "'; name that one");
  const config::Node feet = root.child("feet");
  impl.left_foot = read_foot(feet, "left", urdf);
  impl.right_foot = read_foot(feet, "right", urdf);
  read_joints(root, urdf, impl);
  for (const config::Node& node : root.children("cameras")) impl.cameras.push_back(read_camera(node, urdf));
  read_capsules(root, urdf, impl.capsules);
  find_pairs(root, urdf, impl);
  read_limits(root, impl);
  root.finish();

  impl.mjcf = write_mjcf(urdf, impl.capsules, impl.cameras);
  impl.mj = compile_mjcf(impl.mjcf, {}, ErrorCode::bad_input);
  PERIPLUS_ASSERT(impl.mj->nq == 6 + static_cast<int>(impl.joints.size()) && impl.mj->nq == impl.mj->nv);
  impl.mass = mj_getTotalmass(impl.mj.get());
  for (const UrdfLink& link : urdf.links) impl.bodies[link.name] = mj_name2id(impl.mj.get(), mjOBJ_BODY, link.name.c_str());
  settle(yaml_name, model, impl);
  return model;
}

std::shared_ptr<const RobotModel> RobotModel::load(const std::string& urdf_text, const std::string& yaml_text) {
  return create(urdf_text, yaml_text, "robot.yaml");
}

std::shared_ptr<const RobotModel> RobotModel::load_files(const std::string& urdf_path, const std::string& yaml_path) {
  return create(read_file(urdf_path), read_file(yaml_path), yaml_path);
}

const std::string& RobotModel::name() const { return impl_->name; }
const std::vector<Joint>& RobotModel::joints() const { return impl_->joints; }
const std::vector<Capsule>& RobotModel::capsules() const { return impl_->capsules; }
const std::vector<std::pair<int, int>>& RobotModel::self_collision_pairs() const { return impl_->self_collision_pairs; }
const Foot& RobotModel::left_foot() const { return impl_->left_foot; }
const Foot& RobotModel::right_foot() const { return impl_->right_foot; }
const std::string& RobotModel::base_link() const { return impl_->base_link; }
const ViewLimits& RobotModel::view_limits() const { return impl_->view_limits; }
const BodyBox& RobotModel::body_box() const { return impl_->body_box; }
double RobotModel::mass() const { return impl_->mass; }
const std::string& RobotModel::mjcf() const { return impl_->mjcf; }
const std::string& RobotModel::urdf_text() const { return impl_->urdf_text; }
const std::string& RobotModel::yaml_text() const { return impl_->yaml_text; }

int RobotModel::joint_index(const std::string& wanted) const {
  std::vector<std::string> names;
  for (const Joint& joint : impl_->joints) {
    if (joint.name == wanted) return static_cast<int>(names.size());
    names.push_back(joint.name);
  }
  throw_error(ErrorCode::bad_input, "robot '" + name() + "': " + unknown_name("joint", wanted, names));
}

const Camera& RobotModel::camera(const std::string& wanted) const {
  std::vector<std::string> names;
  for (const Camera& camera : impl_->cameras) {
    if (camera.name == wanted) return camera;
    names.push_back(camera.name);
  }
  throw_error(ErrorCode::bad_input, "robot '" + name() + "': " + unknown_name("camera", wanted, names));
}

StereoRig RobotModel::stereo_rig() const {
  const Camera &left = camera("left"), &right = camera("right");
  const Pose X_LR = left.X_LC.inverse() * right.X_LC;
  const Pinhole &a = left.pinhole, &b = right.pinhole;
  const bool alike = a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
  const bool beside = left.link == right.link && X_LR.translation().x() > 0 && X_LR.translation().tail<2>().norm() < 1e-6 &&
                      (X_LR.linear() - Eigen::Matrix3d::Identity()).norm() < 1e-6;
  require(alike && beside, ErrorCode::bad_input,
          "robot '" + name() + "': cameras 'left' and 'right' are not a rectified pair; give them one link, one direction and one "
          "size, the right one shifted along the left one's image rows");
  return {left.pinhole, X_LR.translation().x()};
}

Eigen::VectorXd RobotModel::half_sitting(const Pose2& floor) const {
  const Pose2 base = compose(floor, inverse(impl_->sole_middle));
  Eigen::VectorXd q = Eigen::VectorXd::Zero(dof());
  q[0] = base.x;
  q[1] = base.y;
  q[2] = impl_->base_height;
  q[3] = base.yaw;
  for (std::size_t i = 0; i < impl_->joints.size(); ++i) q[6 + static_cast<Eigen::Index>(i)] = impl_->joints[i].half_sitting;
  return q;
}

}  // namespace periplus::robot
