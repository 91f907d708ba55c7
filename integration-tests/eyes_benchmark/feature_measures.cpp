#include "integration-tests/eyes_benchmark/feature_measures.h"

#include <algorithm>
#include <limits>

#include "common/core/error.h"

namespace periplus::eyes_benchmark {
namespace {

constexpr double kLikeSize = 1.5;

bool same_spot(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return (a - b).norm() <= kSameSpot; }  // false of what is not finite

}  // namespace

std::vector<Eigen::Vector3d> true_places(std::span<const object_model::Feature> features, const Pinhole& camera, const Pose& X_WC, const mesh::TriangleTree& tree) {
  std::vector<Eigen::Vector3d> out;
  for (const object_model::Feature& f : features) {
    const Eigen::Vector3d ray = X_WC.linear() * camera.back_project(f.u, f.v, 1);
    const auto hit = tree.ray(X_WC.translation(), ray);
    out.push_back(hit ? Eigen::Vector3d(X_WC.translation() + hit->t * ray) : Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return out;
}

MatchQuality match_quality(std::span<const object_model::Feature> a, std::span<const Eigen::Vector3d> true_a, std::span<const object_model::Feature> b,
                           std::span<const Eigen::Vector3d> true_b, std::span<const object_model::FeatureMatch> matches) {
  require(a.size() == true_a.size() && b.size() == true_b.size(), ErrorCode::bad_size, "each feature needs its true place");
  MatchQuality q;
  q.matches = matches.size();
  for (const object_model::FeatureMatch& m : matches) q.right += same_spot(true_a[static_cast<std::size_t>(m.a)], true_b[static_cast<std::size_t>(m.b)]);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      if (same_spot(true_a[i], true_b[j]) && std::max(a[i].size_m, b[j].size_m) <= kLikeSize * std::min(a[i].size_m, b[j].size_m)) {
        ++q.possible;
        break;
      }
  return q;
}

LandmarkQuality landmark_quality(std::span<const object_model::SeenLandmark> landmarks, const std::vector<std::vector<Eigen::Vector3d>>& truth) {
  LandmarkQuality q;
  q.landmarks = landmarks.size();
  for (const object_model::SeenLandmark& l : landmarks) {
    if (l.seen.front().view == l.seen.back().view) continue;
    ++q.joined;
    q.observations += l.seen.size();
    const auto at = [&](const object_model::Observation& o) { return truth.at(o.view).at(o.feature); };
    q.pure += std::all_of(l.seen.begin(), l.seen.end(), [&](const object_model::Observation& o) { return same_spot(at(l.seen.front()), at(o)); });
  }
  return q;
}

}  // namespace periplus::eyes_benchmark
