#include "services/motion_controller/preview_control.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "common/core/error.h"

namespace periplus::motion {
namespace {
constexpr double kGravity = 9.81;  // [m/s2]
constexpr int kRiccatiIterations = 20000;
constexpr double kRiccatiTolerance = 1e-13;
}  // namespace

PreviewControl::PreviewControl(double com_height, const PreviewSettings& s)
    : period_(s.period), height_over_g_(com_height / kGravity) {
  require(com_height > 0 && s.period > 0 && s.preview > s.period && s.error_weight > 0 && s.jerk_weight > 0,
          ErrorCode::bad_input, "preview control needs a positive height, period, preview and weights");
  const double dt = s.period;
  Eigen::Matrix3d A;
  A << 1, dt, 0.5 * dt * dt, 0, 1, dt, 0, 0, 1;
  const Eigen::Vector3d B(dt * dt * dt / 6, 0.5 * dt * dt, dt);
  const Eigen::RowVector3d C(1, 0, -height_over_g_);
  // Augmented by the sum of the ZMP error.
  Eigen::Matrix4d Aa = Eigen::Matrix4d::Zero(), Q = Eigen::Matrix4d::Zero();
  Aa(0, 0) = 1;
  Aa.block<1, 3>(0, 1) = C * A;
  Aa.block<3, 3>(1, 1) = A;
  Eigen::Vector4d Ba;
  Ba << C * B, B;
  Q(0, 0) = s.error_weight;
  Eigen::Matrix4d K = Q;
  for (int i = 0; i < kRiccatiIterations; ++i) {
    const Eigen::RowVector4d BK = Ba.transpose() * K;
    const Eigen::Matrix4d next =
        Aa.transpose() * K * Aa - (Aa.transpose() * K * Ba) * (1 / (s.jerk_weight + BK * Ba)) * (BK * Aa) + Q;
    const double change = (next - K).norm() / next.norm();
    K = next;
    if (change < kRiccatiTolerance) break;
  }
  const double scale = 1 / (s.jerk_weight + Ba.dot(K * Ba));
  const Eigen::RowVector4d gain = scale * (Ba.transpose() * K * Aa);
  error_gain_ = gain(0);
  state_gain_ = gain.tail<3>();
  const Eigen::Matrix4d closed = Aa - Ba * gain;
  Eigen::Vector4d X = -closed.transpose() * K * Eigen::Vector4d(1, 0, 0, 0);
  preview_gain_.resize(static_cast<std::size_t>(std::lround(s.preview / dt)));
  preview_gain_[0] = -error_gain_;
  for (std::size_t i = 1; i < preview_gain_.size(); ++i) {
    preview_gain_[i] = scale * Ba.dot(X);
    X = closed.transpose() * X;
  }
}

double PreviewControl::zmp(const PreviewState& state) const { return state.com(0) - height_over_g_ * state.com(2); }

void PreviewControl::advance(PreviewState& state, std::span<const double> reference) const {
  PERIPLUS_ASSERT(!reference.empty());
  const auto at = [&reference](std::size_t k) { return reference[std::min(k, reference.size() - 1)]; };
  double change = -error_gain_ * (zmp(state) - reference[0]) - state_gain_ * (state.com - state.last_com);
  for (std::size_t i = 0; i < preview_gain_.size(); ++i) change -= preview_gain_[i] * (at(i + 1) - at(i));
  state.jerk += change;
  state.last_com = state.com;
  const double jerk = state.jerk;
  const double dt = period_;
  Eigen::Vector3d& c = state.com;
  c = Eigen::Vector3d(c(0) + dt * c(1) + 0.5 * dt * dt * c(2) + dt * dt * dt / 6 * jerk,
                      c(1) + dt * c(2) + 0.5 * dt * dt * jerk, c(2) + dt * jerk);
}

}  // namespace periplus::motion
