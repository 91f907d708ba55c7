#include "services/motion_controller/posture_motion.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::motion {
namespace {

class PostureMotionTest : public ::testing::Test {
 protected:
  // A posture over the same feet: lower, shifted, leaning, looking elsewhere.
  Eigen::VectorXd posture(Random& random, const Eigen::VectorXd& from) {
    for (;;) {
      BodyTarget target = ik.measure(from);
      target.com += Eigen::Vector3d(random.uniform(-0.04, 0.04), random.uniform(-0.05, 0.05), random.uniform(-0.2, 0));
      target.R_waist = rotation_from_yaw_pitch_roll(random.uniform(-0.25, 0.25), random.uniform(-0.1, 0.4),
                                                    random.uniform(-0.1, 0.1)) *
                       target.R_waist;
      Eigen::VectorXd q = from;
      for (const int j : ik.upper_body()) {
        const robot::Joint& joint = model->joints()[static_cast<std::size_t>(j)];
        q(6 + j) = std::clamp(q(6 + j) + random.uniform(-0.3, 0.3), joint.lower, joint.upper);
      }
      const IkResult result = ik.solve(q, target, 60);
      if (result.sole_error < 1e-8 && result.com_error < 1e-8 && result.waist_error < 1e-6) return q;
    }
  }

  void expect_sound(const PostureMotion& motion, const Eigen::VectorXd& start) {
    const BodyTarget feet = ik.measure(start);
    for (const Command& c : motion.commands()) {
      EXPECT_EQ(c.support, 2);
      const BodyTarget now = ik.measure(c.q);
      EXPECT_LT((now.X_left.translation() - feet.X_left.translation()).norm(), 1e-6);
      EXPECT_LT((now.X_right.translation() - feet.X_right.translation()).norm(), 1e-6);
      EXPECT_LT(angle_between(now.X_left, feet.X_left), 1e-6);
      EXPECT_LT(angle_between(now.X_right, feet.X_right), 1e-6);
      for (std::size_t j = 0; j < model->joints().size(); ++j) {
        EXPECT_GE(c.q(static_cast<Eigen::Index>(6 + j)), model->joints()[j].lower - 1e-9);
        EXPECT_LE(c.q(static_cast<Eigen::Index>(6 + j)), model->joints()[j].upper + 1e-9);
      }
    }
    std::string joint;
    EXPECT_LE(greatest_speed_ratio(*model, start, motion.commands(), 0, 0.005, joint), 1.0) << joint;
  }

  ErrorCode refusal(const Eigen::VectorXd& start, const Eigen::VectorXd& goal) {
    try {
      PostureMotion(model, start, goal);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  }

  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  std::shared_ptr<const robot::RobotModel> model =
      robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
  WholeBodyIk ik{model};
  Eigen::VectorXd standing = model->half_sitting({0.4, -0.3, 2.0});
};

TEST_F(PostureMotionTest, EndsInThePostureWithTheFeetWhereTheyStood) {
  Random random(41);
  for (int n = 0; n < 12; ++n) {
    const Eigen::VectorXd goal = posture(random, standing);
    const PostureMotion there(model, standing, goal);
    expect_sound(there, standing);
    EXPECT_LT((there.commands().back().q - goal).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_GE(there.duration(), 1.5);
    EXPECT_LE((goal - standing).tail(30).cwiseAbs().maxCoeff() / there.duration(), 0.5 + 1e-9);
    // And back.
    const PostureMotion back(model, there.commands().back().q, standing);
    expect_sound(back, there.commands().back().q);
    EXPECT_LT((back.commands().back().q - standing).cwiseAbs().maxCoeff(), 1e-6);
  }
}

TEST_F(PostureMotionTest, TheGoalsBaseIsOnlyAHint) {
  Random random(43);
  const Eigen::VectorXd here = posture(random, standing);
  Eigen::VectorXd elsewhere = here;
  const Pose2 moved = compose({-2, 1, -1.1}, {here(0), here(1), here(3)});
  elsewhere(0) = moved.x;
  elsewhere(1) = moved.y;
  elsewhere(3) = moved.yaw;
  const PostureMotion motion(model, standing, elsewhere);
  EXPECT_LT((motion.commands().back().q - here).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_F(PostureMotionTest, HaltsGently) {
  Random random(47);
  const Eigen::VectorXd goal = posture(random, standing);
  const PostureMotion whole(model, standing, goal);
  for (std::size_t executed = 0; executed < whole.commands().size(); executed += 43) {
    PostureMotion motion(model, standing, goal);
    motion.halt(executed);
    ASSERT_GE(motion.commands().size(), executed);
    EXPECT_LE(motion.commands().size(), executed + 101);
    expect_sound(motion, standing);
    if (motion.commands().size() < 2) continue;
    const std::size_t n = motion.commands().size();
    const double last = (motion.commands()[n - 1].q - motion.commands()[n - 2].q).cwiseAbs().maxCoeff();
    EXPECT_LT(last / 0.005, 1e-5);  // at rest
  }
}

TEST_F(PostureMotionTest, RefusesWhatCannotBe) {
  Eigen::VectorXd wide = standing;
  wide(6 + model->joint_index("LLEG_JOINT1")) += 0.2;
  EXPECT_EQ(refusal(standing, wide), ErrorCode::bad_input);
  Eigen::VectorXd beyond = standing;
  beyond(6 + model->joint_index("HEAD_JOINT0")) = 2;
  EXPECT_EQ(refusal(standing, beyond), ErrorCode::motion_joint_limit);
  Eigen::VectorXd nan = standing;
  nan(3) = std::nan("");
  EXPECT_EQ(refusal(standing, nan), ErrorCode::not_finite);
  EXPECT_EQ(refusal(standing, standing.head(10)), ErrorCode::bad_size);
  Eigen::VectorXd in_the_air = standing;
  in_the_air(2) += 0.2;
  EXPECT_EQ(refusal(in_the_air, standing), ErrorCode::motion_robot_fault);
}

TEST_F(PostureMotionTest, NamesTheJointThatStopsIt) {
  // Feet far apart in height of the body: no leg is that long.
  WholeBodyIk solver(model);
  try {
    standing_configuration(solver, standing, {standing(0), standing(1)}, 1.3, 2.0, {});
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::motion_joint_limit);
  }
}

}  // namespace
}  // namespace periplus::motion
