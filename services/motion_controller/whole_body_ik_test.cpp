#include "services/motion_controller/whole_body_ik.h"

#include <gtest/gtest.h>

#include "common/core/random.h"

namespace periplus::motion {
namespace {

class WholeBodyIkTest : public ::testing::Test {
 protected:
  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  std::shared_ptr<const robot::RobotModel> model =
      robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
  WholeBodyIk ik{model};
};

TEST_F(WholeBodyIkTest, KnowsTheLegs) {
  EXPECT_EQ(ik.legs().size(), 12u);
  EXPECT_EQ(ik.upper_body().size(), model->joints().size() - 12);
  for (const int j : ik.legs())
    EXPECT_NE(model->joints()[static_cast<std::size_t>(j)].name.find("LEG"), std::string::npos);
}

TEST_F(WholeBodyIkTest, ReachesWhatSomeConfigurationReaches) {
  Random random(31);
  for (int n = 0; n < 100; ++n) {
    Eigen::VectorXd wanted = model->half_sitting({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-3, 3)});
    Eigen::VectorXd q = wanted;
    for (const int j : ik.legs()) wanted(6 + j) += random.uniform(-0.12, 0.12);
    wanted.head<3>() += 0.05 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 0));
    wanted(4) += random.uniform(-0.2, 0.2);
    const BodyTarget target = ik.measure(wanted);
    const IkResult result = ik.solve(q, target);
    EXPECT_LT(result.sole_error, 1e-8);
    EXPECT_LT(result.com_error, 1e-8);
    EXPECT_LT(result.waist_error, 1e-6);
    EXPECT_LT((q - wanted).cwiseAbs().maxCoeff(), 1e-5);
    EXPECT_TRUE(result.at_limit.empty());
  }
}

TEST_F(WholeBodyIkTest, AtALimitTheWaistGivesWayAndTheSolesStay) {
  const Eigen::VectorXd start = model->half_sitting();
  BodyTarget target = ik.measure(start);
  // A waist turned further than the hips can: the feet must not follow it.
  target.R_waist = rotation_from_yaw_pitch_roll(1.2, 0, 0);
  Eigen::VectorXd q = start;
  const IkResult result = ik.solve(q, target, 40);
  EXPECT_LT(result.sole_error, 1e-6);
  EXPECT_LT(result.com_error, 1e-4);
  EXPECT_GT(result.waist_error, 0.1);
  EXPECT_FALSE(result.at_limit.empty());
  for (std::size_t j = 0; j < model->joints().size(); ++j) {
    EXPECT_GE(q(static_cast<Eigen::Index>(6 + j)), model->joints()[j].lower - 1e-12);
    EXPECT_LE(q(static_cast<Eigen::Index>(6 + j)), model->joints()[j].upper + 1e-12);
  }
}

TEST_F(WholeBodyIkTest, SaysWhenTheLegsDoNotReach) {
  BodyTarget target = ik.measure(model->half_sitting());
  target.com.z() += 0.3;
  Eigen::VectorXd q = model->half_sitting();
  const IkResult result = ik.solve(q, target, 30);
  EXPECT_GT(result.com_error, 0.1);
}

TEST(RotationBetween, TurnsOneIntoTheOther) {
  const Eigen::Matrix3d a = rotation_from_yaw_pitch_roll(0.3, -0.2, 0.1),
                        b = rotation_from_yaw_pitch_roll(-2, 0.4, 0.2);
  const Eigen::Vector3d v = rotation_between(a, b);
  EXPECT_TRUE((Eigen::AngleAxisd(v.norm(), v.normalized()).toRotationMatrix() * a).isApprox(b, 1e-12));
  EXPECT_EQ(rotation_between(a, a).norm() < 1e-7, true);
}

}  // namespace
}  // namespace periplus::motion
