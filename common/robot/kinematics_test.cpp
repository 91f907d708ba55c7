#include <gtest/gtest.h>

#include <limits>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/robot/robot_model.h"

namespace periplus::robot {

namespace {

class KinematicsTest : public ::testing::Test {
 protected:
  KinematicsTest() : model(RobotModel::load_files(folder() + "hrp2like.urdf", folder() + "hrp2like.yaml")), kinematics(model) {
    Random random(11);
    q = model->half_sitting({0.3, -0.2, 0.5});
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] += random.uniform(-0.3, 0.3);
  }
  static std::string folder() { return std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/"; }

  // Central differences of a pose: linear, then angular velocity in world axes.
  template <class F>
  Eigen::MatrixXd differences(const F& pose) {
    constexpr double h = 1e-6;
    Eigen::MatrixXd J(6, q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      Eigen::VectorXd above = q, below = q;
      above[i] += h;
      below[i] -= h;
      kinematics.set(above);
      const Pose a = pose();
      kinematics.set(below);
      const Pose b = pose();
      J.col(i).head<3>() = (a.translation() - b.translation()) / (2 * h);
      const Eigen::AngleAxisd turn(a.linear() * b.linear().transpose());
      J.col(i).tail<3>() = turn.axis() * turn.angle() / (2 * h);
    }
    kinematics.set(q);
    return J;
  }

  std::shared_ptr<const RobotModel> model;
  Kinematics kinematics;
  Eigen::VectorXd q;
};

}  // namespace

TEST_F(KinematicsTest, JacobiansAgreeWithFiniteDifferences) {
  const Eigen::MatrixXd camera = differences([&] { return kinematics.X_WC("left"); });
  EXPECT_LT((camera - kinematics.jacobian_camera("left")).cwiseAbs().maxCoeff(), 1e-7);
  const Eigen::MatrixXd left = differences([&] { return kinematics.X_WS_left(); });
  EXPECT_LT((left - kinematics.jacobian_sole(true)).cwiseAbs().maxCoeff(), 1e-7);
  const Eigen::MatrixXd right = differences([&] { return kinematics.X_WS_right(); });
  EXPECT_LT((right - kinematics.jacobian_sole(false)).cwiseAbs().maxCoeff(), 1e-7);
  const Eigen::Vector3d p(0.1, -0.2, 0.3);
  const Eigen::MatrixXd hand = differences([&] {
    return kinematics.X_WL("RARM_LINK5") * make_pose(p, Eigen::Matrix3d::Identity());
  });
  EXPECT_LT((hand - kinematics.jacobian("RARM_LINK5", p)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST_F(KinematicsTest, CenterOfMassJacobianAndGravityAgreeWithPotentialEnergy) {
  const Eigen::MatrixXd J = differences([&] { return make_pose(kinematics.center_of_mass(), Eigen::Matrix3d::Identity()); }).topRows(3);
  EXPECT_LT((J - kinematics.jacobian_center_of_mass()).cwiseAbs().maxCoeff(), 1e-7);
  const Eigen::VectorXd expected = model->mass() * 9.81 * J.row(2).transpose();
  EXPECT_LT((kinematics.gravity() - expected).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_NEAR(kinematics.gravity()[2], 58 * 9.81, 1e-3);
}

TEST_F(KinematicsTest, BaseAnglesAreYawPitchRoll) {
  Eigen::VectorXd c = model->half_sitting();
  c.head<6>() << 1, 2, 3, 0.4, 0.5, 0.6;
  kinematics.set(c);
  const Pose X = kinematics.X_WL(model->base_link());
  EXPECT_LT((X.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((X.linear() - rotation_from_yaw_pitch_roll(0.4, 0.5, 0.6)).norm(), 1e-12);
}

TEST_F(KinematicsTest, CapsulesFollowTheirLinks) {
  kinematics.set(q);
  for (std::size_t i = 0; i < model->capsules().size(); ++i) {
    Eigen::Vector3d a, b;
    kinematics.capsule(static_cast<int>(i), a, b);
    const Capsule& c = model->capsules()[i];
    EXPECT_LT((a - kinematics.X_WL(c.link) * c.a).norm(), 1e-12);
    EXPECT_NEAR((a - b).norm(), (c.a - c.b).norm(), 1e-12);
  }
}

TEST_F(KinematicsTest, RefusesWrongSizesAndNotANumber) {
  try {
    kinematics.set(Eigen::VectorXd::Zero(35));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_size);
  }
  q[7] = std::numeric_limits<double>::quiet_NaN();
  try {
    kinematics.set(q);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::not_finite);
  }
}

}  // namespace periplus::robot
