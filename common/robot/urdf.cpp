#include "common/robot/urdf.h"

#include <tinyxml2.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>

#include "common/core/error.h"
#include "common/robot/names.h"

namespace periplus::robot {

namespace {

using tinyxml2::XMLElement;

constexpr std::size_t kLargestFile = 4u << 20;
constexpr std::size_t kMostLinks = 512;

[[noreturn]] void bad(const std::string& message) { throw_error(ErrorCode::bad_input, "URDF: " + message); }

std::string attribute(const XMLElement& element, const char* key, const std::string& owner) {
  const char* text = element.Attribute(key);
  if (text == nullptr || *text == 0) {
    bad(owner + ": <" + element.Name() + "> on line " + std::to_string(element.GetLineNum()) + " has no attribute '" + key +
        "'");
  }
  return text;
}

// Exactly N finite numbers.
template <std::size_t N>
std::array<double, N> numbers(const std::string& text, const XMLElement& element, const char* key,
                              const std::string& owner) {
  std::array<double, N> values{};
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto skip = [&] {
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
  };
  for (double& value : values) {
    skip();
    if (at != end && *at == '+') ++at;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) {
      bad(owner + ": attribute '" + key + "' on line " + std::to_string(element.GetLineNum()) + " is '" +
          text.substr(0, 64) + "'; give " + std::to_string(N) + " finite number" + (N > 1 ? "s" : ""));
    }
    at = next;
  }
  skip();
  if (at != end) bad(owner + ": attribute '" + key + "' on line " + std::to_string(element.GetLineNum()) + " has more than " + std::to_string(N) + " numbers");
  return values;
}

double number(const XMLElement& element, const char* key, const std::string& owner) {
  return numbers<1>(attribute(element, key, owner), element, key, owner)[0];
}

Eigen::Vector3d vector(const XMLElement& element, const char* key, const std::string& owner, const Eigen::Vector3d& absent) {
  if (element.Attribute(key) == nullptr) return absent;
  const auto v = numbers<3>(element.Attribute(key), element, key, owner);
  return {v[0], v[1], v[2]};
}

// URDF's rpy are about fixed axes x, y, z: R = Rz(yaw) Ry(pitch) Rx(roll).
Pose origin_of(const XMLElement& parent, const std::string& owner) {
  const XMLElement* origin = parent.FirstChildElement("origin");
  if (origin == nullptr) return Pose::Identity();
  const Eigen::Vector3d xyz = vector(*origin, "xyz", owner, Eigen::Vector3d::Zero());
  const Eigen::Vector3d rpy = vector(*origin, "rpy", owner, Eigen::Vector3d::Zero());
  return make_pose(xyz, rotation_from_yaw_pitch_roll(rpy.z(), rpy.y(), rpy.x()));
}

UrdfLink read_link(const XMLElement& element) {
  UrdfLink link;
  link.name = attribute(element, "name", "a link");
  const std::string owner = "link '" + link.name + "'";
  const XMLElement* inertial = element.FirstChildElement("inertial");
  if (inertial == nullptr) return link;
  const XMLElement* mass = inertial->FirstChildElement("mass");
  const XMLElement* inertia = inertial->FirstChildElement("inertia");
  if (mass == nullptr || inertia == nullptr) bad(owner + ": <inertial> needs <mass> and <inertia>");
  link.mass = number(*mass, "value", owner);
  if (link.mass < 0) bad(owner + ": its mass is negative");
  const Pose X = origin_of(*inertial, owner);
  link.center_of_mass = X.translation();
  const double xx = number(*inertia, "ixx", owner), yy = number(*inertia, "iyy", owner), zz = number(*inertia, "izz", owner);
  const auto product = [&](const char* key) { return inertia->Attribute(key) == nullptr ? 0.0 : number(*inertia, key, owner); };
  const double xy = product("ixy"), xz = product("ixz"), yz = product("iyz");
  if (xx < 0 || yy < 0 || zz < 0) bad(owner + ": its inertia has a negative moment");
  Eigen::Matrix3d I;
  I << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  link.inertia = X.linear() * I * X.linear().transpose();
  return link;
}

UrdfJoint read_joint(const XMLElement& element, const Urdf& urdf) {
  UrdfJoint joint;
  joint.name = attribute(element, "name", "a joint");
  const std::string owner = "joint '" + joint.name + "'";
  const std::string type = attribute(element, "type", owner);
  if (type == "fixed") {
    joint.type = UrdfJointType::fixed;
  } else if (type == "revolute") {
    joint.type = UrdfJointType::revolute;
  } else if (type == "continuous") {
    joint.type = UrdfJointType::continuous;
  } else if (type == "prismatic") {
    joint.type = UrdfJointType::prismatic;
  } else {
    bad(owner + ": type '" + type + "' is not supported; use fixed, revolute, continuous or prismatic");
  }
  const auto link_of = [&](const char* key) {
    const XMLElement* e = element.FirstChildElement(key);
    if (e == nullptr) bad(owner + " has no <" + key + ">");
    const std::string name = attribute(*e, "link", owner);
    const int i = urdf.find_link(name);
    if (i < 0) bad(owner + ": " + unknown_name("link", name, urdf.link_names()));
    return i;
  };
  joint.parent = link_of("parent");
  joint.child = link_of("child");
  if (joint.parent == joint.child) bad(owner + " joins link '" + urdf.links[joint.child].name + "' to itself");
  joint.X_PC = origin_of(element, owner);
  if (joint.type == UrdfJointType::fixed) return joint;
  if (const XMLElement* axis = element.FirstChildElement("axis")) {
    joint.axis = vector(*axis, "xyz", owner, joint.axis);
    if (joint.axis.norm() < 1e-9) bad(owner + ": its axis is zero");
    joint.axis.normalize();
  }
  const XMLElement* limit = element.FirstChildElement("limit");
  if (limit == nullptr) bad(owner + " has no <limit>; give lower, upper, effort and velocity");
  joint.effort = number(*limit, "effort", owner);
  joint.velocity = number(*limit, "velocity", owner);
  if (joint.effort < 0 || joint.velocity <= 0) bad(owner + ": effort must not be negative and velocity must be positive");
  if (joint.type == UrdfJointType::continuous) {
    joint.lower = -std::numbers::pi;
    joint.upper = std::numbers::pi;
  } else {
    joint.lower = number(*limit, "lower", owner);
    joint.upper = number(*limit, "upper", owner);
    if (joint.lower > joint.upper) bad(owner + ": its lower limit is above its upper one");
  }
  return joint;
}

// Exactly one root, every link reached from it once.
void connect(Urdf& urdf) {
  for (std::size_t j = 0; j < urdf.joints.size(); ++j) {
    UrdfLink& child = urdf.links[urdf.joints[j].child];
    if (child.parent_joint >= 0) bad("link '" + child.name + "' has two parents: joints '" + urdf.joints[child.parent_joint].name + "' and '" + urdf.joints[j].name + "'");
    child.parent_joint = static_cast<int>(j);
    urdf.links[urdf.joints[j].parent].child_joints.push_back(static_cast<int>(j));
  }
  for (std::size_t i = 0; i < urdf.links.size(); ++i) {
    if (urdf.links[i].parent_joint >= 0) continue;
    if (urdf.root >= 0) bad("links '" + urdf.links[urdf.root].name + "' and '" + urdf.links[i].name + "' both have no parent; join them");
    urdf.root = static_cast<int>(i);
  }
  if (urdf.root < 0) bad("its links form a loop: every link has a parent");
  if (urdf.find_link("world") >= 0) bad("link 'world' fixes the robot to the ground, where it cannot walk; remove that link and its joint");
  std::vector<int> reached{urdf.root};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    for (const int j : urdf.links[reached[i]].child_joints) reached.push_back(urdf.joints[j].child);
  }
  if (reached.size() != urdf.links.size()) bad("some links form a loop that is not joined to the root '" + urdf.links[urdf.root].name + "'");
}

}  // namespace

int Urdf::find_link(std::string_view wanted) const {
  for (std::size_t i = 0; i < links.size(); ++i) {
    if (links[i].name == wanted) return static_cast<int>(i);
  }
  return -1;
}

std::vector<std::string> Urdf::link_names() const {
  std::vector<std::string> names;
  for (const UrdfLink& link : links) names.push_back(link.name);
  return names;
}

Urdf parse_urdf(std::string_view xml) {
  if (xml.size() > kLargestFile) bad("the file is larger than 4 MiB");
  tinyxml2::XMLDocument document;
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS) {
    bad("not XML, line " + std::to_string(document.ErrorLineNum()) + ": " + document.ErrorName());
  }
  const XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) bad("the root element <robot> is missing");
  Urdf urdf;
  if (robot->Attribute("name") != nullptr) urdf.name = robot->Attribute("name");
  std::set<std::string> seen;
  for (const XMLElement* e = robot->FirstChildElement("link"); e != nullptr; e = e->NextSiblingElement("link")) {
    if (urdf.links.size() == kMostLinks) bad("more than 512 links");
    urdf.links.push_back(read_link(*e));
    if (!seen.insert(urdf.links.back().name).second) bad("two links are named '" + urdf.links.back().name + "'");
  }
  if (urdf.links.empty()) bad("there is no <link>");
  seen.clear();
  for (const XMLElement* e = robot->FirstChildElement("joint"); e != nullptr; e = e->NextSiblingElement("joint")) {
    if (urdf.joints.size() == kMostLinks) bad("more than 512 joints");
    urdf.joints.push_back(read_joint(*e, urdf));
    if (!seen.insert(urdf.joints.back().name).second) bad("two joints are named '" + urdf.joints.back().name + "'");
  }
  connect(urdf);
  return urdf;
}

}  // namespace periplus::robot
