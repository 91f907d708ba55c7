// Convex bodies given by points, of whose hull they are.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace periplus::voxel {

using Points = std::vector<Eigen::Vector3d>;

// The part of the hull of `points` where value >= 0, as points: those inside, and where segments between an inner and
// an outer one cross (their hull is the section).
template <class Value>
Points clip(const Points& points, Value value) {
  Points kept, outside;
  for (const auto& p : points) (value(p) >= 0 ? kept : outside).push_back(p);
  if (kept.empty() || outside.empty()) return kept;
  const std::size_t inner = kept.size();
  for (std::size_t i = 0; i < inner; ++i) {
    const double a = value(kept[i]);
    for (const auto& q : outside) {
      const double b = value(q);
      kept.push_back(kept[i] + (q - kept[i]) * (a / (a - b)));
    }
  }
  return kept;
}

// Corners of the hull, counter-clockwise.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);

}  // namespace periplus::voxel
