#include "common/object_model/growth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "common/core/error.h"
#include "common/scene/scene.h"

namespace periplus::object_model {

namespace {

using Views = std::vector<std::shared_ptr<const View>>;

constexpr int kLongestSide = 512;       // voxels of a grid along an axis
constexpr double kSigmas = 3;        // of a depth within which a point may be a known solid's

std::uint64_t key(const Eigen::Vector3i& v) {
  const auto part = [](int n) { return static_cast<std::uint64_t>(n + kLongestSide); };
  return (part(v.x()) << 22 | part(v.y())) << 22 | part(v.z());
}

// What depth maps show outside a grid, by voxel; indices go on beyond the grid's faces.
class PointsOutside {
 public:
  PointsOutside(const voxel::GridGeometry& geometry, const Surroundings& surroundings, const CarvingSettings& carving, double least_area)
      : geometry_(geometry), surroundings_(surroundings), carving_(carving), least_area_(least_area) {}

  void add(const View& view) {
    if (view.silhouette_valid_share < carving_.cautious_share) return;
    const double pose_sigma = point_sigma(view.covariance, (view.X_WC.inverse() * geometry_.X_WG * (0.5 * geometry_.voxel_size * geometry_.size.cast<double>())).norm());
    const double focal_baseline = view.rig.camera.fx * view.rig.baseline;
    for (const StoredDepth& stored : view.depth) {
      const DepthMap map = restore_depth(stored, view.X_WC);
      const Pose X_GC = geometry_.X_WG.inverse() * map.X_WC;
      for (int y = 0; y < map.camera.height; ++y)
        for (int x = 0; x < map.camera.width; ++x) {
          const float z = map.depth.at(x, y);
          if (!(z > 0 && map.depth_minimum.at(x, y) > 0)) continue;
          const Eigen::Vector3d p_G = X_GC * map.camera.back_project(x, y, z);
          const Eigen::Array3d index = (p_G.array() / geometry_.voxel_size).floor();
          if ((index < -kLongestSide).any() || (index >= 2 * kLongestSide).any()) continue;
          const Eigen::Vector3i v = index.matrix().cast<int>();
          if (geometry_.contains(v)) continue;
          Cell& cell = cells_[key(v)];
          ++cell.points;
          cell.sum_G += p_G;
          cell.area += std::pow(z / (map.camera.fx * geometry_.voxel_size), 2);
          cell.sigma = std::max(cell.sigma, std::hypot(pose_sigma, z * z * carving_.log_odds.disparity_sigma_px / focal_baseline));
        }
    }
  }

  bool belongs_to_object(const Eigen::Vector3i& v) const {
    const auto it = cells_.find(key(v));
    if (it == cells_.end()) return false;
    const Cell& cell = it->second;
    if (cell.points < carving_.known_points || cell.area < least_area_) return false;
    const Eigen::Vector3d p_W = geometry_.X_WG * Eigen::Vector3d(cell.sum_G / cell.points);
    const double tolerance = geometry_.voxel_size + std::max(carving_.solid_tolerance_m, kSigmas * cell.sigma);
    return !surroundings_.collision || !surroundings_.collision->contains_or_floor(p_W, tolerance);
  }

 private:
  struct Cell {
    int points = 0;
    double area = 0, sigma = 0;  // [faces of a voxel], [m]
    Eigen::Vector3d sum_G = Eigen::Vector3d::Zero();
  };
  const voxel::GridGeometry& geometry_;
  const Surroundings& surroundings_;
  const CarvingSettings& carving_;
  const double least_area_;
  std::unordered_map<std::uint64_t, Cell> cells_;
};

template <class Visit>
void for_each_neighbour(const Eigen::Vector3i& v, Visit&& visit) {
  for (int n = 0; n < 27; ++n)
    if (n != 13) visit(Eigen::Vector3i(v + Eigen::Vector3i(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1)));
}

// Measured voxels at the faces of the grid.
std::vector<Eigen::Vector3i> measured_at_faces(const ObjectModel& model, const CarvingSettings& carving) {
  const Eigen::Vector3i size = model.grid().geometry().size;
  std::vector<Eigen::Vector3i> out;
  for (int x = 0; x < size.x(); ++x)
    for (int y = 0; y < size.y(); ++y) {
      const bool at_face = x == 0 || y == 0 || x == size.x() - 1 || y == size.y() - 1;
      for (int z = 0; z < size.z(); z += at_face ? 1 : std::max(1, size.z() - 1))
        if (const Eigen::Vector3i v(x, y, z); model.is_measured(v, carving)) out.push_back(v);
    }
  return out;
}

// Voxels on each side by which a grid is to grow, and how many of the object's lie there.
struct Leak {
  Eigen::Vector3i below = Eigen::Vector3i::Zero(), above = Eigen::Vector3i::Zero();
  int voxels = 0;
  bool same_sides(const Leak& other) const { return below == other.below && above == other.above; }
  // On no side more than there.
  void keep_within(const Leak& other) {
    below = below.cwiseMin(other.below);
    above = above.cwiseMin(other.above);
  }
};

// Voxels that belong to the object outside the grid. `stands` says whether a voxel outside still stands; null: all do.
Leak leak_of(const ObjectModel& model, const std::vector<Eigen::Vector3i>& faces, const PointsOutside& points, int margin,
             const voxel::OccupancyGrid* larger, const Eigen::Vector3i& offset) {
  const Eigen::Vector3i size = model.grid().geometry().size;
  Eigen::Vector3i least = Eigen::Vector3i::Zero(), most = size - Eigen::Vector3i::Ones();
  std::vector<Eigen::Vector3i> open = faces;
  std::unordered_set<std::uint64_t> seen;
  Leak out;
  while (!open.empty()) {
    const Eigen::Vector3i from = open.back();
    open.pop_back();
    for_each_neighbour(from, [&](const Eigen::Vector3i& v) {
      if ((v.array() < -kLongestSide).any() || (v.array() >= 2 * kLongestSide).any() || model.grid().geometry().contains(v)) return;
      if (!seen.insert(key(v)).second || !points.belongs_to_object(v)) return;
      if (larger && larger->state(v + offset) != voxel::VoxelState::known) return;
      ++out.voxels;
      least = least.cwiseMin(v);
      most = most.cwiseMax(v);
      open.push_back(v);
    });
  }
  const auto whole_bricks = [&](int voxels) { return voxels > 0 ? (voxels + margin + 7) / 8 * 8 : 0; };
  out.below = (-least).unaryExpr(whole_bricks);
  out.above = (most - size + Eigen::Vector3i::Ones()).unaryExpr(whole_bricks);
  return out;
}

// Throws Error(bad_input) if that makes no grid.
ObjectBox grown_box(const voxel::GridGeometry& g, const Leak& leak) {
  const Eigen::Vector3i size = g.size + leak.below + leak.above;
  require((size.array() <= kLongestSide).all(), ErrorCode::bad_input,
          "the object leaves its box and would need a grid of " + std::to_string(size.x()) + " x " + std::to_string(size.y()) + " x " +
              std::to_string(size.z()) + " voxels, at most 512 along a side are possible; begin it anew with larger voxels");
  ObjectBox box;
  box.size = g.voxel_size * size.cast<double>();
  box.X_WB = g.X_WG;
  box.X_WB.translation() = g.X_WG * Eigen::Vector3d(0.5 * box.size - g.voxel_size * leak.below.cast<double>());
  return box;
}

Leak leak_of_views(const ObjectModel& model, const std::vector<Eigen::Vector3i>& faces, const Views& views, const Surroundings& surroundings,
                   const CarvingSettings& carving, const GrowthSettings& settings, std::optional<ObjectModel>* larger) {
  PointsOutside points(model.grid().geometry(), surroundings, carving, settings.least_area);
  for (const auto& view : views) points.add(*view);
  Leak leak = leak_of(model, faces, points, settings.margin_voxels, nullptr, Eigen::Vector3i::Zero());
  while (larger && leak.voxels >= settings.least_voxels) {
    larger->emplace(model.within(grown_box(model.grid().geometry(), leak), surroundings, carving));
    // What stands depends on the box a little, by the distance from its middle to the views: never back to a larger one, or this has no end.
    Leak standing = leak_of(model, faces, points, settings.margin_voxels, &(*larger)->grid(), leak.below);
    standing.keep_within(leak);
    const bool fits = standing.same_sides(leak);
    leak = standing;
    if (fits) break;
  }
  return leak;
}

}  // namespace

void GrowthSettings::check() const {
  require(least_voxels >= 1 && least_voxels <= 1000000, ErrorCode::bad_input, "growth: least_voxels must lie between 1 and 1000000");
  require(margin_voxels >= 0 && margin_voxels <= 64, ErrorCode::bad_input, "growth: margin_voxels must lie between 0 and 64");
  require(least_area >= 0 && least_area <= 100, ErrorCode::bad_input, "growth: least_area must lie between 0 and 100");
}

Growth grow(const ObjectModel& model, const Surroundings& surroundings, const CarvingSettings& carving, const GrowthSettings& settings) {
  settings.check();
  Growth out;
  const Views& views = model.state().views;
  if (!settings.enabled || views.empty()) return out;
  const auto faces = measured_at_faces(model, carving);
  if (faces.empty() || leak_of_views(model, faces, {views.back()}, surroundings, carving, settings, nullptr).voxels < settings.least_voxels) return out;
  if (!model.can_be_revised()) {
    out.refused = "the object leaves its box, but its grid was imported or was begun by a version that kept too little depth to carve again";
    return out;
  }
  try {
    for (const ObjectModel* now = &model;; now = &*out.model) {
      std::optional<ObjectModel> larger;
      const Leak leak = leak_of_views(*now, measured_at_faces(*now, carving), now->state().views, surroundings, carving, settings, &larger);
      if (leak.voxels < settings.least_voxels) return out;
      out.model = std::move(larger);
    }
  } catch (const Error& e) {
    if (e.code() != ErrorCode::bad_input && e.code() != ErrorCode::model_object_differs) throw;
    out.refused = e.what();
  }
  return out;
}

}  // namespace periplus::object_model
