#include "common/robot/urdf.h"

#include <gtest/gtest.h>

#include <numbers>

#include "common/core/error.h"

namespace periplus::robot {

namespace {

std::string robot(const std::string& body) { return "<?xml version='1.0'?><robot name='r'>" + body + "</robot>"; }

std::string refusal(const std::string& text) {
  try {
    parse_urdf(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    return error.what();
  }
  return "accepted";
}

const char* const kTwoLinks = "<link name='a'/><link name='b'/>";
const char* const kHinge =
    "<joint name='j' type='revolute'><parent link='a'/><child link='b'/><origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/>"
    "<axis xyz='0 0 2'/><limit lower='-1' upper='2' effort='5' velocity='3'/></joint>";

}  // namespace

TEST(Urdf, ReadsTreeAndNumbers) {
  const Urdf urdf = parse_urdf(robot(std::string(kTwoLinks) + kHinge));
  EXPECT_EQ(urdf.links[urdf.root].name, "a");
  ASSERT_EQ(urdf.joints.size(), 1u);
  const UrdfJoint& joint = urdf.joints[0];
  EXPECT_EQ(joint.type, UrdfJointType::revolute);
  EXPECT_LT((joint.X_PC.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((joint.X_PC.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((joint.axis - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(joint.upper, 2);
  EXPECT_EQ(joint.effort, 5);
  EXPECT_EQ(joint.velocity, 3);
}

TEST(Urdf, TurnsInertiaIntoLinkAxes) {
  const Urdf urdf = parse_urdf(robot(
      "<link name='a'><inertial><origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/><mass value='2'/>"
      "<inertia ixx='1' iyy='2' izz='3' ixy='0.5' ixz='0' iyz='0'/></inertial></link>"));
  EXPECT_NEAR(urdf.links[0].inertia(0, 0), 2, 1e-12);
  EXPECT_NEAR(urdf.links[0].inertia(1, 1), 1, 1e-12);
  EXPECT_NEAR(urdf.links[0].inertia(0, 1), -0.5, 1e-12);
  EXPECT_EQ(urdf.links[0].mass, 2);
}

TEST(Urdf, RefusesBrokenFiles) {
  const auto says = [](const std::string& text, const std::string& words) {
    EXPECT_NE(refusal(text).find(words), std::string::npos) << refusal(text);
  };
  const std::string two = kTwoLinks, hinge = kHinge;
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = hinge;
    return robot(two + text.replace(text.find(from), from.size(), to));
  };
  says("nonsense", "not XML");
  says("<robot>", "not XML");
  says("<model/>", "<robot> is missing");
  says(robot(""), "no <link>");
  says(robot(two), "both have no parent");
  says(robot("<link name='a'/><link name='a'/>"), "two links are named 'a'");
  says(robot(two + hinge + hinge), "two joints are named 'j'");
  says(with("<child link='b'/>", "<child link='bb'/>"), "did you mean 'b'");
  says(with("<child link='b'/>", "<child link='a'/>"), "to itself");
  says(with("<parent link='a'/>", ""), "has no <parent>");
  says(with("upper='2'", "upper='nan'"), "finite number");
  says(with("upper='2'", "upper='-3'"), "above its upper");
  says(with("upper='2'", ""), "no attribute 'upper'");
  says(with("0 0 2", "0 0 0"), "axis is zero");
  says(with("0 0 2", "0 0"), "3 finite numbers");
  says(with("1 2 3", "1 2 3 4"), "more than 3");
  says(with("revolute", "floating"), "not supported");
  says(with("velocity='3'", "velocity='0'"), "velocity must be positive");
  says(robot("<link name='a'><inertial><mass value='-1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"), "negative");
  says(robot("<link name='world'/>"), "fixes the robot to the ground");
  // Two links hold each other in a loop beside the root.
  const std::string loop = "<link name='c'/><link name='d'/><link name='e'/>"
      "<joint name='x' type='fixed'><parent link='d'/><child link='e'/></joint>"
      "<joint name='y' type='fixed'><parent link='e'/><child link='d'/></joint>";
  says(robot(loop), "loop");
  EXPECT_EQ(refusal(robot(two + hinge)), "accepted");
}

}  // namespace periplus::robot
