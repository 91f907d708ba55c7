#include "services/posture_generator/posture_generator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/robot/capsule_distance.h"
#include "services/posture_generator/static_torques.h"
#include "services/posture_generator/testing/object_on_table.h"

namespace periplus::posture {

namespace {

using Eigen::Vector3d;

// Of this process: other programs on the machine do not count.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// A table with an unknown box on it in a room with a screen, as in the demonstration.
class PostureGeneratorTest : public ::testing::Test {
 protected:
  PostureGeneratorTest() {
    robot = testing::hrp2like();
    generator = std::make_unique<PostureGenerator>(robot, settings);
  }
  Surroundings surroundings() const { return place.surroundings(); }

  // Every constraint again, by other means than the problem's.
  void verify(const Posture& posture, const Pose& X_WC) const {
    robot::Kinematics kinematics(robot);
    kinematics.set(posture.q);
    EXPECT_LT((kinematics.X_WC("left").matrix() - X_WC.matrix()).cwiseAbs().maxCoeff(), 3e-4);
    for (const Pose& sole : {kinematics.X_WS_left(), kinematics.X_WS_right()}) {
      EXPECT_NEAR(sole.translation().z(), 0, 2e-4);
      EXPECT_GT(sole.linear()(2, 2), std::cos(3e-4));
    }
    for (std::size_t j = 0; j < robot->joints().size(); ++j) {
      EXPECT_GE(posture.q[6 + static_cast<Eigen::Index>(j)], robot->joints()[j].lower) << robot->joints()[j].name;
      EXPECT_LE(posture.q[6 + static_cast<Eigen::Index>(j)], robot->joints()[j].upper) << robot->joints()[j].name;
    }
    // Stance as the walk's last step can reach it.
    const Pose2 left = compose(inverse(posture.right_foot), posture.left_foot), right = compose(inverse(posture.left_foot), posture.right_foot);
    for (const auto& [x, y] : {std::pair(left.x, left.y), std::pair(right.x, -right.y)}) {
      EXPECT_LE(std::abs(x), 0.17);
      EXPECT_GE(y, 0.14);
      EXPECT_LE(y, 0.275);
    }
    EXPECT_LE(left.yaw, 40 * std::numbers::pi / 180);
    EXPECT_GE(left.yaw, -10 * std::numbers::pi / 180);
    // Centre of mass within a sole's half width of the segment between the feet.
    const Eigen::Vector2d a(posture.left_foot.x, posture.left_foot.y), b(posture.right_foot.x, posture.right_foot.y);
    const Eigen::Vector2d com = kinematics.center_of_mass().head<2>();
    double least = 9, share = 0;
    for (int i = 0; i <= 10000; ++i) {
      const double d = (a + (b - a) * i / 1e4 - com).norm();
      if (d < least) {
        least = d;
        share = i / 1e4;
      }
    }
    EXPECT_LT(least, 0.0203);
    EXPECT_GT(share, 0.249);
    EXPECT_LT(share, 0.751);
    // Collisions, by points along the capsules.
    std::vector<std::pair<Vector3d, Vector3d>> ends(robot->capsules().size());
    for (std::size_t i = 0; i < ends.size(); ++i) {
      kinematics.capsule(static_cast<int>(i), ends[i].first, ends[i].second);
      for (int k = 0; k <= 20; ++k) {
        const Vector3d p = ends[i].first + (ends[i].second - ends[i].first) * k / 20;
        EXPECT_FALSE(place.world().contains(p, robot->capsules()[i].radius + 0.029)) << robot->capsules()[i].name;
        const Vector3d in_box = (p - Vector3d(0, 0, 0.95)).cwiseAbs() - Vector3d::Constant(0.25);
        EXPECT_GT(in_box.cwiseMax(0).norm() + std::min(0.0, in_box.maxCoeff()), robot->capsules()[i].radius) << robot->capsules()[i].name;
      }
    }
    for (const auto& [i, j] : robot->self_collision_pairs()) {
      const auto c = robot::closest_points(ends[i].first, ends[i].second, ends[j].first, ends[j].second);
      EXPECT_GT(c.distance, robot->capsules()[i].radius + robot->capsules()[j].radius - 2e-4)
          << robot->capsules()[i].name << " " << robot->capsules()[j].name;
    }
    const Eigen::VectorXd torques = static_torques(kinematics);
    for (std::size_t j = 0; j < robot->joints().size(); ++j) {
      EXPECT_LE(std::abs(torques[6 + static_cast<Eigen::Index>(j)]), 0.9 * robot->joints()[j].max_torque + 1e-9) << robot->joints()[j].name;
    }
  }

  Settings settings;
  std::shared_ptr<const robot::RobotModel> robot;
  std::unique_ptr<PostureGenerator> generator;
  const testing::ObjectOnTable place = testing::demonstration(settings);
};

}  // namespace

TEST_F(PostureGeneratorTest, FiftyViewsOfTheObjectAreReached) {
  Random random(7);
  std::vector<double> milliseconds;
  int iterations = 0;
  for (int i = 0; i < 50; ++i) {
    const Pose X_WC = testing::view_of_object(random);
    const double begin = cpu_seconds();
    const Posture posture = generator->generate(X_WC, surroundings());
    milliseconds.push_back(1000 * (cpu_seconds() - begin));
    iterations += posture.iterations;
    SCOPED_TRACE("view " + std::to_string(i));
    ASSERT_TRUE(posture.feasible) << posture.failed_constraint << " " << posture.violation << " height " << X_WC.translation().z() << " pitch "
                                  << camera_yaw_pitch_roll(X_WC).y();
    EXPECT_LT(posture.camera_error, 2e-4);
    verify(posture, X_WC);
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  EXPECT_LT(milliseconds[25], 120);  // 30 ms measured; slower machines run it as well
  std::printf("50 views: median %.1f ms, p95 %.1f ms, %.1f iterations\n", milliseconds[25], milliseconds[47], iterations / 50.0);
}

TEST_F(PostureGeneratorTest, WholeRangeOfViewLimits) {
  Random random(8);
  int reached = 0;
  for (int i = 0; i < 100; ++i) {
    const Pose X_WC = look_along({random.uniform(-2, 2), random.uniform(1.6, 2.6), random.uniform(1.0, 1.35)}, random.uniform(-3, 3),
                                 random.uniform(-25, 60) * std::numbers::pi / 180);
    const Posture posture = generator->generate(X_WC, {});
    if (posture.feasible) {
      ++reached;
    } else {
      std::printf("height %.2f pitch %.0f: %s\n", X_WC.translation().z(), camera_yaw_pitch_roll(X_WC).y() * 180 / std::numbers::pi,
                  posture.failed_constraint.c_str());
    }
  }
  EXPECT_GE(reached, 97);
}

TEST_F(PostureGeneratorTest, SameQuestionSameAnswer) {
  Random random(9);
  const Pose X_WC = testing::view_of_object(random);
  const Posture first = generator->generate(X_WC, surroundings());
  generator->generate(testing::view_of_object(random), surroundings());
  const Posture second = PostureGenerator(robot, settings).generate(X_WC, surroundings());
  ASSERT_EQ(first.q.size(), second.q.size());
  EXPECT_EQ(first.q, second.q);
  EXPECT_EQ(first.iterations, second.iterations);
}

TEST_F(PostureGeneratorTest, StartsFromAGivenConfiguration) {
  Random random(10);
  const Pose X_WC = testing::view_of_object(random);
  const Posture first = generator->generate(X_WC, surroundings());
  ASSERT_TRUE(first.feasible);
  const Posture again = generator->generate(X_WC, surroundings(), first.q);
  ASSERT_TRUE(again.feasible);
  verify(again, X_WC);
}

TEST_F(PostureGeneratorTest, EyeInAWallIsRefusedByName) {
  const Posture wall = generator->generate(look_along({1.1, 0.2, 1.3}, 0, 0.1), surroundings());
  EXPECT_FALSE(wall.feasible);
  EXPECT_EQ(wall.failed_constraint, "scene_collision:screen");
  const Posture room = generator->generate(look_along({2.99, 0, 1.3}, 0, 0.1), surroundings());
  EXPECT_EQ(room.failed_constraint, "scene_collision:room");
  const Posture inside = generator->generate(look_along({0, 0, 1.1}, 0, 0.1), surroundings());
  EXPECT_EQ(inside.failed_constraint, "object_collision");
}

TEST_F(PostureGeneratorTest, HopelessViewsAreGivenUpSoonWithTheirReason) {
  for (const auto& [X_WC, reason] : testing::hopeless_views()) {
    const double begin = cpu_seconds();
    const Posture posture = generator->generate(X_WC, surroundings());
    const double seconds = cpu_seconds() - begin;
    EXPECT_FALSE(posture.feasible);
    EXPECT_FALSE(posture.failed_constraint.empty());
    if (!reason.empty()) {
      EXPECT_EQ(posture.failed_constraint, reason);
    }
    std::printf("hopeless: %s, %d iterations, %.2f s\n", posture.failed_constraint.c_str(), posture.iterations, seconds);
    EXPECT_LT(seconds, 0.6);  // 0.2 s measured; slower machines run it as well
    EXPECT_LE(posture.iterations, 130);  // of the 240 allowed: three starts given up in time
  }
}

TEST_F(PostureGeneratorTest, RefusesWhatIsNoPoseAndNoConfiguration) {
  const auto code = [&](const Pose& X, const std::optional<Eigen::VectorXd>& start = {}) {
    try {
      generator->generate(X, surroundings(), start);
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::ok;
  };
  const Pose good = look_along({-1.5, 0, 1.2}, 0, 0);
  Pose bad = good;
  bad.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code(bad), ErrorCode::not_finite);
  bad = good;
  bad.linear() *= 2;
  EXPECT_EQ(code(bad), ErrorCode::bad_input);
  bad = good;
  bad.translation().x() = 1e7;
  EXPECT_EQ(code(bad), ErrorCode::bad_input);
  EXPECT_EQ(code(good, Eigen::VectorXd::Zero(7)), ErrorCode::bad_size);
  Eigen::VectorXd start = robot->half_sitting();
  start[9] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(code(good, start), ErrorCode::not_finite);
}

}  // namespace periplus::posture
