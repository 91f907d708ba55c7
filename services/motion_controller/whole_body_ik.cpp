#include "services/motion_controller/whole_body_ik.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/error.h"

namespace periplus::motion {
namespace {

// Weights of the tasks: what a lower one gives up never moves a higher one by more than the square of their ratio.
constexpr double kComWeight = 0.1, kWaistWeight = 1e-3;
constexpr double kDamping = 1e-12;
constexpr double kLongestIteration = 0.3;  // of one Newton iteration [rad], [m]
constexpr double kConverged = 1e-9;

}  // namespace

Eigen::Vector3d rotation_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to * from.transpose()));
  return turn.angle() * turn.axis();
}

WholeBodyIk::WholeBodyIk(std::shared_ptr<const robot::RobotModel> model)
    : model_(std::move(model)), kinematics_(model_) {
  kinematics_.set(model_->half_sitting());
  const Eigen::MatrixXd left = kinematics_.jacobian_sole(true), right = kinematics_.jacobian_sole(false);
  int of_left = 0, of_right = 0;
  for (int j = 0; j < static_cast<int>(model_->joints().size()); ++j) {
    // Every joint on the way to a sole turns it, wherever its axis passes.
    const bool moves_left = left.col(6 + j).tail<3>().norm() > 1e-6,
               moves_right = right.col(6 + j).tail<3>().norm() > 1e-6;
    of_left += moves_left;
    of_right += moves_right;
    (moves_left || moves_right ? legs_ : upper_body_).push_back(j);
  }
  require(of_left >= 6 && of_right >= 6, ErrorCode::bad_input,
          "each foot must hang on at least six joints to be placed anywhere");
  for (int c = 0; c < 6; ++c) columns_.push_back(c);
  for (const int j : legs_) columns_.push_back(6 + j);
}

BodyTarget WholeBodyIk::measure(const Eigen::VectorXd& q) {
  kinematics_.set(q);
  return {kinematics_.center_of_mass(), kinematics_.X_WL(model_->base_link()).linear(), kinematics_.X_WS_left(),
          kinematics_.X_WS_right()};
}

IkResult WholeBodyIk::solve(Eigen::VectorXd& q, const BodyTarget& target, int iterations) {
  const auto n = static_cast<Eigen::Index>(columns_.size());
  Eigen::MatrixXd J(18, n);
  Eigen::VectorXd error(18), lower(n), upper(n), step(n);
  IkResult result;
  for (;; ++result.iterations) {
    kinematics_.set(q);
    const Pose X_left = kinematics_.X_WS_left(), X_right = kinematics_.X_WS_right();
    error << target.X_left.translation() - X_left.translation(),
        rotation_between(X_left.linear(), target.X_left.linear()), target.X_right.translation() - X_right.translation(),
        rotation_between(X_right.linear(), target.X_right.linear()), target.com - kinematics_.center_of_mass(),
        rotation_between(kinematics_.X_WL(model_->base_link()).linear(), target.R_waist);
    result.sole_error = std::max({error.segment<3>(0).norm(), error.segment<3>(3).norm(), error.segment<3>(6).norm(),
                                  error.segment<3>(9).norm()});
    result.com_error = error.segment<3>(12).norm();
    result.waist_error = error.segment<3>(15).norm();
    if (result.iterations >= iterations || error.norm() < kConverged) return result;

    const Eigen::MatrixXd of_left = kinematics_.jacobian_sole(true), of_right = kinematics_.jacobian_sole(false);
    const Eigen::MatrixXd of_com = kinematics_.jacobian_center_of_mass(),
                          of_waist = kinematics_.jacobian(model_->base_link());
    for (Eigen::Index c = 0; c < n; ++c) {
      const int column = columns_[static_cast<std::size_t>(c)];
      J.block<6, 1>(0, c) = of_left.col(column);
      J.block<6, 1>(6, c) = of_right.col(column);
      J.block<3, 1>(12, c) = kComWeight * of_com.col(column);
      J.block<3, 1>(15, c) = kWaistWeight * of_waist.col(column).tail<3>();
      if (column < 6) {
        lower(c) = -kLongestIteration;
        upper(c) = kLongestIteration;
      } else {
        const robot::Joint& joint = model_->joints()[static_cast<std::size_t>(column - 6)];
        lower(c) = std::min(joint.lower - q(column), 0.0);
        upper(c) = std::max(joint.upper - q(column), 0.0);
      }
    }
    error.segment<3>(12) *= kComWeight;
    error.segment<3>(15) *= kWaistWeight;

    // Least squares within the limits, by an active set that only grows.
    std::vector<Eigen::Index> free;
    for (Eigen::Index c = 0; c < n; ++c) free.push_back(c);
    result.at_limit.clear();
    step.setZero();
    Eigen::VectorXd left_over = error;
    while (!free.empty()) {
      const auto m = static_cast<Eigen::Index>(free.size());
      Eigen::MatrixXd A(18, m);
      for (Eigen::Index k = 0; k < m; ++k) A.col(k) = J.col(free[static_cast<std::size_t>(k)]);
      Eigen::MatrixXd normal = A.transpose() * A;
      normal.diagonal().array() += kDamping;
      const Eigen::VectorXd x = normal.ldlt().solve(A.transpose() * left_over);
      Eigen::Index worst = -1;
      double most = 1e-12;
      for (Eigen::Index k = 0; k < m; ++k) {
        const Eigen::Index c = free[static_cast<std::size_t>(k)];
        step(c) = x(k);
        const double beyond =
            columns_[static_cast<std::size_t>(c)] < 6 ? 0 : std::max(lower(c) - x(k), x(k) - upper(c));
        if (beyond > most) {
          most = beyond;
          worst = k;
        }
      }
      if (worst < 0) break;
      const Eigen::Index c = free[static_cast<std::size_t>(worst)];
      step(c) = std::clamp(step(c), lower(c), upper(c));
      left_over -= J.col(c) * step(c);
      result.at_limit.push_back(columns_[static_cast<std::size_t>(c)] - 6);
      free.erase(free.begin() + worst);
    }
    const double longest = step.cwiseAbs().maxCoeff();
    if (longest > kLongestIteration) step *= kLongestIteration / longest;
    for (Eigen::Index c = 0; c < n; ++c) q(columns_[static_cast<std::size_t>(c)]) += step(c);
  }
}

}  // namespace periplus::motion
