#include "common/object_model/landmarks.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "common/core/error.h"
#include "common/object_model/object_model.h"

namespace periplus::object_model {

namespace {

// Disjoint sets of observations that know which views they were seen from.
class Groups {
 public:
  explicit Groups(const std::vector<Observation>& observations) : parent_(observations.size()), views_(observations.size()) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    for (std::size_t i = 0; i < observations.size(); ++i) views_[i] = {observations[i].view};
  }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  // The smaller index leads, so that the result does not depend on the order in which equals come.
  void join(std::size_t i, std::size_t k) {
    const std::pair<std::size_t, std::size_t> roots = std::minmax({root(i), root(k)});
    const std::size_t first = roots.first, second = roots.second;
    if (first == second) return;
    parent_[second] = first;
    std::vector<std::size_t> both;
    std::set_union(views_[first].begin(), views_[first].end(), views_[second].begin(), views_[second].end(), std::back_inserter(both));
    views_[first] = std::move(both);
    views_[second].clear();
  }
  bool share_a_view(std::size_t i, std::size_t k) {
    const auto &a = views_[root(i)], &b = views_[root(k)];
    return std::any_of(a.begin(), a.end(), [&](std::size_t view) { return std::binary_search(b.begin(), b.end(), view); });
  }

 private:
  std::vector<std::size_t> parent_;
  std::vector<std::vector<std::size_t>> views_;  // ascending, of roots
};

struct Joint {
  double distance = 0;  // of the descriptors
  std::size_t a = 0, b = 0;
};

// Centre of a group's observations, by the certainty of their depth.
Landmark mean_of(std::span<const std::shared_ptr<const View>> views, const std::vector<Observation>& seen) {
  Landmark out{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 0};
  double sum = 0;
  for (const Observation& o : seen) {
    const View& view = *views[o.view];
    const Feature& f = view.features[o.feature];
    const double z = std::clamp((view.X_WC.inverse() * f.p_W).z(), 1e-3, 1e6), weight = 1 / (z * z * z * z);
    out.p_W += weight * f.p_W;
    out.normal_W += weight * f.normal_W;
    out.size_m += weight * f.size_m;
    sum += weight;
  }
  out.p_W /= sum;
  out.size_m /= sum;
  const double length = out.normal_W.norm();
  out.normal_W = std::isfinite(length) && length > 1e-9 * sum ? Eigen::Vector3d(out.normal_W / length) : Eigen::Vector3d::Zero();
  // One alone to the last bit; and sums of what a file may claim overflow.
  if (seen.size() == 1 || !out.p_W.allFinite() || !std::isfinite(out.size_m)) {
    const Feature& f = views[seen[0].view]->features[seen[0].feature];
    out.p_W = f.p_W;
    out.size_m = f.size_m;
  }
  return out;
}

// Of kept matches, the view whose matches another view has.
class KeptViews {
 public:
  explicit KeptViews(const KeptMatches& kept) {
    for (const auto& [pair, matches] : kept.of)
      for (const auto& view : {pair.first, pair.second}) {
        views_.insert(view);
        named_.emplace(view->view_id, view);
      }
  }
  // Itself where there is none.
  const std::shared_ptr<const View>& like(const std::shared_ptr<const View>& view) const {
    if (views_.contains(view)) return view;
    const auto it = named_.find(view->view_id);
    return it != named_.end() && it->second->features == view->features ? it->second : view;
  }

 private:
  std::set<std::shared_ptr<const View>> views_;
  std::map<std::string, std::shared_ptr<const View>> named_;
};

constexpr double kFarthestVoxels = 8;  // that a landmark may lie away from its voxel

bool is_object(const voxel::OccupancyGrid& grid, const Eigen::Vector3i& v) {
  if (!grid.geometry().contains(v)) return false;
  const voxel::VoxelState s = grid.state(v);
  return s == voxel::VoxelState::known || s == voxel::VoxelState::unknown;
}

}  // namespace

void LandmarkSettings::check() const {
  matching.check();
  require(reach_m > 0 && std::isfinite(reach_m), ErrorCode::bad_input, "landmarks: reach_m must be positive");
  require(most_turn >= 0 && most_turn <= 4, ErrorCode::bad_input, "landmarks: most_turn must lie in 0..4");
}

std::vector<SeenLandmark> merge_landmarks(std::span<const std::shared_ptr<const View>> views, const LandmarkSettings& settings, KeptMatches* kept) {
  settings.check();
  KeptMatches old{.settings = settings.matching, .of = {}}, matches = old;
  if (kept && kept->settings == settings.matching) old.of.swap(kept->of);
  std::vector<Observation> all;
  std::vector<std::size_t> first(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    first[v] = all.size();
    for (std::size_t f = 0; f < views[v]->features.size(); ++f) all.push_back({v, f});
  }
  Groups groups(all);
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::map<std::tuple<float, float, float>, std::size_t> at;
    for (std::size_t f = 0; f < views[v]->features.size(); ++f) {
      const Feature& x = views[v]->features[f];
      const auto [it, fresh] = at.try_emplace({x.u, x.v, x.size}, first[v] + f);
      if (!fresh && views[v]->features[it->second - first[v]].p_W == x.p_W) groups.join(it->second, first[v] + f);
    }
  }
  const KeptViews old_views(old);
  std::vector<std::shared_ptr<const View>> as_kept;
  for (const auto& view : views) as_kept.push_back(old_views.like(view));
  std::vector<Joint> joints;
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t w = v + 1; w < views.size(); ++w) {
      const auto &a = views[v]->features, &b = views[w]->features;
      if (views[v]->X_WC.linear().col(2).dot(views[w]->X_WC.linear().col(2)) < std::cos(std::min(settings.most_turn, std::numbers::pi))) continue;
      const std::pair pair(views[v], views[w]);
      auto known = old.of.extract({as_kept[v], as_kept[w]});
      if (known) known.key() = pair;
      const auto at = known ? matches.of.insert(std::move(known)).position : matches.of.try_emplace(pair, match_views(a, b, settings.matching)).first;
      for (const FeatureMatch& m : at->second)
        if ((a[static_cast<std::size_t>(m.a)].p_W - b[static_cast<std::size_t>(m.b)].p_W).norm() <= settings.reach_m)
          joints.push_back({m.distance, first[v] + static_cast<std::size_t>(m.a), first[w] + static_cast<std::size_t>(m.b)});
    }
  if (kept) *kept = std::move(matches);
  std::sort(joints.begin(), joints.end(), [](const Joint& x, const Joint& y) { return std::tie(x.distance, x.a, x.b) < std::tie(y.distance, y.a, y.b); });
  for (const Joint& j : joints)
    if (groups.root(j.a) != groups.root(j.b) && !groups.share_a_view(j.a, j.b)) groups.join(j.a, j.b);

  std::vector<SeenLandmark> out;
  std::vector<std::size_t> place(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t r = groups.root(i);
    if (r == i) {
      place[i] = out.size();
      out.emplace_back();
    }
    out[place[r]].seen.push_back(all[i]);
  }
  for (SeenLandmark& l : out) l.place = mean_of(views, l.seen);
  return out;
}

std::optional<Eigen::Vector3i> landmark_voxel(const Landmark& landmark, const voxel::OccupancyGrid& grid) {
  const voxel::GridGeometry& g = grid.geometry();
  const Eigen::Vector3i own = g.voxel_of(landmark.p_W);
  if (is_object(grid, own)) return own;
  const double reach = landmark.size_m / 2 + g.voxel_size * std::sqrt(3.0) / 2;
  const int voxels = static_cast<int>(std::clamp(std::ceil(reach / g.voxel_size), 0.0, kFarthestVoxels));
  const Eigen::Vector3d p = (g.X_WG.inverse() * landmark.p_W) / g.voxel_size;
  std::optional<Eigen::Vector3i> best;
  double least = reach / g.voxel_size;
  for (int x = -voxels; x <= voxels; ++x)
    for (int y = -voxels; y <= voxels; ++y)
      for (int z = -voxels; z <= voxels; ++z) {
        const Eigen::Vector3i v = own + Eigen::Vector3i(x, y, z);
        const double distance = (v.cast<double>() + Eigen::Vector3d::Constant(0.5) - p).norm();
        if (distance > least || (best && distance == least) || !is_object(grid, v)) continue;
        least = distance;
        best = v;
      }
  return best;
}

}  // namespace periplus::object_model
