#include "services/nbv_planner/reachability_table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {

void check_axis(const std::vector<double>& axis, const char* what) {
  require(!axis.empty(), ErrorCode::bad_input, std::string("a reachability needs at least one of its ") + what);
  for (const double v : axis) require(std::isfinite(v), ErrorCode::not_finite, std::string("a reachability's ") + what + " must be finite");
  require(std::adjacent_find(axis.begin(), axis.end(), std::greater_equal<>()) == axis.end(), ErrorCode::bad_input,
          std::string("a reachability's ") + what + " must rise");
}

// Place of v on a rising axis: the index below, and the share of the way to the next.
std::pair<std::size_t, double> place(const std::vector<double>& axis, double v) {
  if (axis.size() == 1 || v <= axis.front()) return {0, 0};
  if (v >= axis.back()) return {axis.size() - 2, 1};
  const auto above = static_cast<std::size_t>(std::upper_bound(axis.begin(), axis.end(), v) - axis.begin());
  return {above - 1, (v - axis[above - 1]) / (axis[above] - axis[above - 1])};
}

}  // namespace

ReachabilityTable::ReachabilityTable(std::vector<double> heights, std::vector<double> pitches, std::vector<double> shares)
    : heights_(std::move(heights)), pitches_(std::move(pitches)), shares_(std::move(shares)) {
  check_axis(heights_, "heights");
  check_axis(pitches_, "pitches");
  require(shares_.size() == heights_.size() * pitches_.size(), ErrorCode::bad_size,
          "a reachability of " + std::to_string(heights_.size()) + " heights and " + std::to_string(pitches_.size()) + " pitches needs " +
              std::to_string(heights_.size() * pitches_.size()) + " shares, got " + std::to_string(shares_.size()));
  for (const double s : shares_) require(s >= 0 && s <= 1, ErrorCode::bad_input, "a reachability's shares must lie in 0..1");
}

double ReachabilityTable::of(const Pose& X_WC) const {
  const auto [i, up] = place(heights_, X_WC.translation().z());
  const auto [j, down] = place(pitches_, camera_yaw_pitch_roll(X_WC).y());
  const std::size_t next_i = std::min(i + 1, heights_.size() - 1), next_j = std::min(j + 1, pitches_.size() - 1), n = pitches_.size();
  return (1 - up) * ((1 - down) * shares_[i * n + j] + down * shares_[i * n + next_j]) +
         up * ((1 - down) * shares_[next_i * n + j] + down * shares_[next_i * n + next_j]);
}

}  // namespace periplus::nbv
