#include "services/motion_controller/walk_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::motion {
namespace {

class WalkMotionTest : public ::testing::Test {
 protected:
  static Pose2 sole(const Pose2& body, int foot, double half_width = 0.095) {
    return compose(body, {0, foot == 0 ? half_width : -half_width, 0});
  }

  // Forward, in a curve, sideways, in place, backwards; the last stance wide, shifted and turned out as a posture's.
  std::vector<Step> errand(const Pose2& from) {
    std::vector<Step> steps;
    Pose2 body = from;
    int foot = 0;
    const auto go = [&](const Pose2& by, int count) {
      for (int i = 0; i < count; ++i, foot = 1 - foot) {
        body = compose(body, by);
        steps.push_back({foot, sole(body, foot)});
      }
    };
    go({0.18, 0, 0}, 5);
    go({0.12, 0, 0.12}, 4);
    go({0, 0, 0}, 1);
    for (int i = 0; i < 4; ++i) go({0, foot == 1 ? -0.06 : 0, 0}, 1);
    for (int i = 0; i < 4; ++i) go({0, 0, foot == 0 ? 0.28 : 0}, 1);
    go({-0.12, 0, 0}, 3);
    steps.push_back({foot, compose(body, {0.06, foot == 0 ? 0.12 : -0.12, foot == 0 ? 0.25 : -0.25})});
    foot = 1 - foot;
    steps.push_back({foot, compose(body, {-0.06, foot == 0 ? 0.12 : -0.12, foot == 0 ? 0.25 : -0.25})});
    return steps;
  }

  // Ahead in long steps, the feet wide apart.
  std::vector<Step> wide_walk(int count) {
    const BodyTarget standing = ik.measure(start);
    const Pose2 l = to_pose2(standing.X_left), r = to_pose2(standing.X_right);
    Pose2 body{0.5 * (l.x + r.x), 0.5 * (l.y + r.y), place.yaw};
    std::vector<Step> steps;
    for (int i = 0; i < count; ++i) {
      body = compose(body, {0.1, 0, 0.06});
      steps.push_back({i % 2, sole(body, i % 2, 0.125)});
    }
    return steps;
  }

  // Bent forward on half-sitting's feet.
  Eigen::VectorXd posture() {
    BodyTarget low = ik.measure(start);
    low.com += Eigen::Vector3d(0.02, 0.02, -0.15);
    low.R_waist = rotation_from_yaw_pitch_roll(0.2, 0.3, 0) * low.R_waist;
    Eigen::VectorXd q = start;
    q(6 + model->joint_index("HEAD_JOINT1")) = 0.4;
    EXPECT_LT(ik.solve(q, low, 50).sole_error, 1e-8);
    return q;
  }

  // Standing soles never slide, joints keep their limits and speeds.
  void expect_sound(const WalkMotion& motion, const Eigen::VectorXd& before, double greatest_speed = 1.0) {
    BodyTarget anchored = ik.measure(before);
    for (std::size_t k = 0; k < motion.commands().size(); ++k) {
      const Command& c = motion.commands()[k];
      const BodyTarget now = ik.measure(c.q);
      for (int f = 0; f < 2; ++f) {
        const Pose &X = f == 0 ? now.X_left : now.X_right, &was = f == 0 ? anchored.X_left : anchored.X_right;
        if (c.support == 2 || c.support == f) {
          EXPECT_LT((X.translation() - was.translation()).norm(), 1e-6) << "command " << k << " foot " << f;
          EXPECT_LT(angle_between(X, was), 1e-6);
          EXPECT_LT(std::abs(X.translation().z()), 1e-5);
        } else {
          EXPECT_GT(X.translation().z(), -1e-6);
          (f == 0 ? anchored.X_left : anchored.X_right) = X;
        }
      }
      for (std::size_t j = 0; j < model->joints().size(); ++j) {
        EXPECT_GE(c.q(static_cast<Eigen::Index>(6 + j)), model->joints()[j].lower - 1e-9);
        EXPECT_LE(c.q(static_cast<Eigen::Index>(6 + j)), model->joints()[j].upper + 1e-9);
      }
    }
    std::string joint;
    EXPECT_LE(greatest_speed_ratio(*model, before, motion.commands(), 0, 0.005, joint), greatest_speed) << joint;
  }

  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  std::shared_ptr<const robot::RobotModel> model =
      robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
  WholeBodyIk ik{model};
  Pose2 place{0.5, -1, 0.8};
  Eigen::VectorXd start = model->half_sitting(place);
};

TEST_F(WalkMotionTest, WalksWithoutSliding) {
  const BodyTarget standing = ik.measure(start);
  const Pose2 l = to_pose2(standing.X_left), r = to_pose2(standing.X_right);
  const std::vector<Step> steps = errand({0.5 * (l.x + r.x), 0.5 * (l.y + r.y), place.yaw});
  const WalkMotion motion(model, start, steps);
  expect_sound(motion, start);

  const Eigen::VectorXd& end = motion.commands().back().q;
  const BodyTarget arrived = ik.measure(end);
  for (std::size_t i = steps.size() - 2; i < steps.size(); ++i) {
    const Pose2 X = to_pose2(steps[i].foot == 0 ? arrived.X_left : arrived.X_right);
    EXPECT_NEAR(X.x, steps[i].sole.x, 1e-6);
    EXPECT_NEAR(X.y, steps[i].sole.y, 1e-6);
    EXPECT_NEAR(wrap_angle(X.yaw - steps[i].sole.yaw), 0, 1e-6);
  }
  const Eigen::VectorXd half = model->half_sitting();
  for (const int j : ik.upper_body()) EXPECT_NEAR(end(6 + j), half(6 + j), 1e-9);
  EXPECT_NEAR(arrived.com.z(), ik.measure(half).com.z(), 1e-6);
  EXPECT_EQ(motion.fraction(motion.commands().size()), 1);
  EXPECT_EQ(motion.fraction(0), 0);

  // The robot's own centre of mass, by differences, keeps the zero-moment point near that of the pattern.
  const double period = 0.005, height = arrived.com.z();
  double worst = 0;
  Eigen::Vector3d before = ik.measure(motion.commands()[motion.lead()].q).com,
                  here = ik.measure(motion.commands()[motion.lead() + 1].q).com;
  for (std::size_t k = motion.lead() + 2; k < motion.commands().size(); ++k) {
    const Eigen::Vector3d next = ik.measure(motion.commands()[k].q).com;
    const Eigen::Vector2d acceleration = (next - 2 * here + before).head<2>() / (period * period);
    const Eigen::Vector2d zmp = here.head<2>() - height / 9.81 * acceleration;
    worst = std::max(worst, (zmp - motion.pattern().ticks()[k - motion.lead()].zmp).norm());
    before = here;
    here = next;
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_LT((here - before).norm() / period, 1e-3);  // at rest
}

TEST_F(WalkMotionTest, BeginsFromAPosture) {
  const Eigen::VectorXd low = posture();
  const BodyTarget standing = ik.measure(low);
  const Pose2 l = to_pose2(standing.X_left), r = to_pose2(standing.X_right);
  const WalkMotion motion(model, low, errand({0.5 * (l.x + r.x), 0.5 * (l.y + r.y), place.yaw}));
  EXPECT_GT(motion.lead(), 200u);
  expect_sound(motion, low);
}

TEST_F(WalkMotionTest, WithoutStepsItOnlyStandsUp) {
  const WalkMotion motion(model, start, {});
  EXPECT_LT(motion.commands().size(), 400u);
  expect_sound(motion, start);
  EXPECT_EQ(motion.fraction(motion.commands().size()), 1);
}

TEST_F(WalkMotionTest, HaltsStanding) {
  const BodyTarget standing = ik.measure(start);
  const Pose2 l = to_pose2(standing.X_left), r = to_pose2(standing.X_right);
  const std::vector<Step> steps = errand({0.5 * (l.x + r.x), 0.5 * (l.y + r.y), place.yaw});
  const WalkMotion whole(model, start, steps);
  for (const std::size_t executed : {std::size_t{0}, std::size_t{50}, std::size_t{700}, std::size_t{1333},
                                     std::size_t{2000}, whole.commands().size() - 30}) {
    WalkMotion motion(model, start, steps);
    motion.halt(executed);
    ASSERT_GE(motion.commands().size(), executed);
    EXPECT_LE(motion.commands().size(), whole.commands().size());
    for (std::size_t k = 0; k < executed; ++k) ASSERT_EQ(motion.commands()[k].q, whole.commands()[k].q);
    expect_sound(motion, start);
    if (motion.commands().empty()) continue;
    EXPECT_EQ(motion.commands().back().support, 2);
    const BodyTarget end = ik.measure(motion.commands().back().q);
    EXPECT_LT(std::abs(end.X_left.translation().z()) + std::abs(end.X_right.translation().z()), 1e-5);
  }
}

// Whole or halted after any command, on the way out of a posture too; over wide stances with long steps, where the
// joints turn most for each millimetre of the centre of mass.
TEST_F(WalkMotionTest, EndsAtRest) {
  const Eigen::VectorXd low = posture();
  const std::vector<Step> steps = wide_walk(6);
  const std::size_t whole = WalkMotion(model, low, steps).commands().size();
  for (std::size_t executed = 2; executed < whole + 61; executed += 61) {
    WalkMotion motion(model, low, steps);
    motion.halt(executed);
    const std::vector<Command>& commands = motion.commands();
    ASSERT_GE(commands.size(), 2u);
    const Eigen::VectorXd last = (commands.back().q - commands[commands.size() - 2].q) / 0.005;
    EXPECT_LT(last.cwiseAbs().maxCoeff(), 1e-5) << "[rad/s], halted after command " << executed << " of " << whole;
  }
}

// Longest and widest steps of the planner: not each of them can be a walk's last, since the centre of mass is then farther
// behind when the foot lands.
TEST_F(WalkMotionTest, HaltsWhereALegWouldNotReach) {
  std::vector<Step> steps;
  Pose2 stands = to_pose2(ik.measure(start).X_right);
  for (int i = 0; i < 8; ++i) {
    const double out = i % 2 == 0 ? 1 : -1;
    stands = compose(stands, i % 2 == 0 ? Pose2{0.2, out * 0.26, out * 0.314} : Pose2{0.2, out * 0.16, -out * 0.17});
    steps.push_back({i % 2, stands});
  }
  const WalkMotion whole(model, start, steps);
  std::size_t shorter = 0;
  for (std::size_t executed = 0; executed < whole.commands().size(); executed += 130) {
    WalkMotion motion(model, start, steps);
    ASSERT_NO_THROW(motion.halt(executed)) << "after command " << executed;
    for (std::size_t k = 0; k < executed; ++k) ASSERT_EQ(motion.commands()[k].q, whole.commands()[k].q);
    expect_sound(motion, start, 1.1);
    EXPECT_LE(motion.commands().size(), whole.commands().size());
    shorter += motion.commands().size() < whole.commands().size();
    if (!motion.commands().empty()) {
      EXPECT_EQ(motion.commands().back().support, 2);
    }
  }
  EXPECT_GT(shorter, 10u);
}

TEST_F(WalkMotionTest, HaltsSoonInLongSteps) {
  std::vector<Step> steps;
  Pose2 body = place;
  for (int i = 0; i < 12; ++i) {
    body = compose(body, {0.2, 0, 0});
    steps.push_back({i % 2, sole(body, i % 2)});
  }
  const std::size_t whole = WalkMotion(model, start, steps).commands().size();
  for (std::size_t executed = 600; executed + 800 < whole; executed += 210) {
    WalkMotion motion(model, start, steps);
    motion.halt(executed);
    EXPECT_LT(motion.commands().size(), executed + 700);  // this step, perhaps the next one, and standing still
    expect_sound(motion, start, 1.1);
  }
}

TEST_F(WalkMotionTest, SameInputSameBytes) {
  const std::vector<Step> steps = errand(place);
  const WalkMotion a(model, start, steps), b(model, start, steps);
  ASSERT_EQ(a.commands().size(), b.commands().size());
  for (std::size_t k = 0; k < a.commands().size(); ++k) ASSERT_EQ(a.commands()[k].q, b.commands()[k].q);
}

TEST_F(WalkMotionTest, RefusesWhatCannotBeWalked) {
  const auto refusal = [this](const std::vector<Step>& steps) {
    try {
      WalkMotion(model, start, steps);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  EXPECT_EQ(refusal({{0, {3, 3, 0}}}), ErrorCode::bad_input);
  const Pose2 left = to_pose2(ik.measure(start).X_left);
  EXPECT_EQ(refusal({{0, compose(left, {0.55, 0, 0})}}), ErrorCode::motion_joint_limit);
  EXPECT_EQ(refusal({{0, left}, {0, left}}), ErrorCode::bad_input);
}

}  // namespace
}  // namespace periplus::motion
