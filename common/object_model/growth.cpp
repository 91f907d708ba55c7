#include "common/object_model/growth.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "common/core/error.h"
#include "common/core/fault_point.h"
#include "common/scene/scene.h"

namespace periplus::object_model {

namespace {

using Views = std::vector<std::shared_ptr<const View>>;

constexpr int kLongestSide = 512;    // voxels of a grid along an axis
constexpr double kSigmas = 3;        // of a depth within which a point may be a known solid's

std::uint64_t key(const Eigen::Vector3i& v) {
  const auto part = [](int n) { return static_cast<std::uint64_t>(n + kLongestSide); };
  return (part(v.x()) << 22 | part(v.y())) << 22 | part(v.z());
}

}  // namespace

// What depth maps show outside a grid, by voxel; indices go on beyond the grid's faces.
class PointsOutside {
 public:
  PointsOutside(const voxel::GridGeometry& geometry, const CarvingSettings& carving) : geometry_(geometry), carving_(carving) {}

  // True if those added already are the first of `views`, seen from the same grid by the same rules.
  bool goes_on(const voxel::GridGeometry& geometry, const CarvingSettings& carving, const Views& views) const {
    return views_.size() <= views.size() && std::equal(views_.begin(), views_.end(), views.begin()) && geometry_.size == geometry.size &&
           geometry_.voxel_size == geometry.voxel_size && geometry_.X_WG.matrix() == geometry.X_WG.matrix() && carving_ == carving;
  }
  // The rest of them.
  void add(const Views& views) {
    for (std::size_t n = views_.size(); n < views.size(); ++n) add(*views[n]);
    views_ = views;
  }

  bool belongs_to_object(const Eigen::Vector3i& v, const Surroundings& surroundings, double least_area) const {
    const auto it = cells_.find(key(v));
    if (it == cells_.end()) return false;
    const Cell& cell = it->second;
    if (cell.points < carving_.known_points || cell.area < least_area) return false;
    const Eigen::Vector3d p_W = geometry_.X_WG * Eigen::Vector3d(cell.sum_G / cell.points);
    const double tolerance = geometry_.voxel_size + std::max(carving_.solid_tolerance_m, kSigmas * cell.sigma);
    return !surroundings.collision || !surroundings.collision->contains_or_floor(p_W, tolerance);
  }

 private:
  struct Cell {
    int points = 0;
    double area = 0, sigma = 0;  // [faces of a voxel], [m]
    Eigen::Vector3d sum_G = Eigen::Vector3d::Zero();
  };
  void add(const View& view) {
    fault_point("growth.view");
    if (view.silhouette_valid_share < carving_.cautious_share) return;
    const double pose_sigma = point_sigma(view.covariance, (view.X_WC.inverse() * geometry_.X_WG * (0.5 * geometry_.voxel_size * geometry_.size.cast<double>())).norm());
    const double focal_baseline = view.rig.camera.fx * view.rig.baseline;
    for (const StoredDepth& stored : view.depth) {
      const DepthMap map = restore_depth(stored, view.X_WC);
      const double sigma_per_z2 = std::max(carving_.log_odds.disparity_sigma_px / focal_baseline, stored.sigma_per_z2);
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
          cell.sigma = std::max(cell.sigma, std::hypot(pose_sigma, z * z * sigma_per_z2));
        }
    }
  }
  const voxel::GridGeometry geometry_;
  const CarvingSettings carving_;
  Views views_;
  std::unordered_map<std::uint64_t, Cell> cells_;
};

namespace {

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

// Voxels that belong to the object outside the grid, and are known in the `larger` one, which begins `offset` below; null: whatever it says.
Leak leak_of(const ObjectModel& model, const std::vector<Eigen::Vector3i>& faces, const PointsOutside& points, const Surroundings& surroundings,
             const GrowthSettings& settings, const voxel::OccupancyGrid* larger = nullptr, const Eigen::Vector3i& offset = Eigen::Vector3i::Zero()) {
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
      if (!seen.insert(key(v)).second || !points.belongs_to_object(v, surroundings, settings.least_area)) return;
      if (larger && larger->state(v + offset) != voxel::VoxelState::known) return;
      ++out.voxels;
      least = least.cwiseMin(v);
      most = most.cwiseMax(v);
      open.push_back(v);
    });
  }
  const auto whole_bricks = [&](int voxels) { return voxels > 0 ? (voxels + settings.margin_voxels + 7) / 8 * 8 : 0; };
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

// Larger boxes of a model, carved by all its views: anew, or from where they were left when they were refuted.
class CarvedBoxes {
 public:
  CarvedBoxes(const Surroundings& surroundings, const CarvingSettings& carving, RefutedBoxes* kept) : surroundings_(surroundings), carving_(carving), kept_(kept) {}
  ~CarvedBoxes() {
    constexpr std::ptrdiff_t kMost = 2;
    if (!kept_ || used_.empty()) return;
    used_.erase(used_.begin(), used_.end() - std::min<std::ptrdiff_t>(kMost, std::ssize(used_)));
    kept_->boxes = std::move(used_);
  }
  CarvedBoxes(const CarvedBoxes&) = delete;
  CarvedBoxes& operator=(const CarvedBoxes&) = delete;

  // Until the next call. Throws as ObjectModel::within.
  const voxel::OccupancyGrid& carve(const ObjectModel& model, const ObjectBox& box) {
    put_away();
    box_ = box;
    views_ = model.state().views;
    if (kept_)
      for (RefutedBoxes::Box& old : kept_->boxes) {
        if (!goes_on(old, model, box)) continue;
        RefutedBoxes::Box on = std::exchange(old, {});
        for (std::size_t n = on.views.size(); n < views_.size(); ++n) object_model::carve(*views_[n], surroundings_, carving_, false, on.carved);
        on.views = views_;
        used_.push_back(std::move(on));
        return used_.back().carved.grid;
      }
    whole_.emplace(model.within(box, surroundings_, carving_));
    return whole_->grid();
  }
  // The model in the last box.
  ObjectModel take(const ObjectModel& model) {
    if (!whole_) {
      used_.pop_back();
      return model.within(box_, surroundings_, carving_);
    }
    ObjectModel out = std::move(*whole_);
    whole_.reset();
    return out;
  }
  // It was refuted.
  void put_away() {
    if (kept_ && whole_) {
      ModelState state = whole_->state();
      state.views.clear();
      state.tsdf = {};
      used_.push_back({views_, surroundings_.collision, carving_, std::move(state)});
    }
    whole_.reset();
  }

 private:
  bool goes_on(const RefutedBoxes::Box& old, const ObjectModel& model, const ObjectBox& box) const {
    return !old.views.empty() && old.views.size() <= views_.size() && std::equal(old.views.begin(), old.views.end(), views_.begin()) &&
           old.carved.box.X_WB.matrix() == box.X_WB.matrix() && old.carved.box.size == box.size &&
           old.carved.grid.geometry().voxel_size == model.grid().geometry().voxel_size && old.carving == carving_ &&
           old.collision == surroundings_.collision && old.carved.environment_revision == surroundings_.revision;
  }

  const Surroundings& surroundings_;
  const CarvingSettings& carving_;
  RefutedBoxes* kept_;
  std::vector<RefutedBoxes::Box> used_;
  ObjectBox box_;
  Views views_;
  std::optional<ObjectModel> whole_;  // of box_; nothing where the last one of used_ is
};

// The model in a box that holds the object as far as its views agree; nothing if that is its own.
std::optional<ObjectModel> grown_once(const ObjectModel& model, const Surroundings& surroundings, const CarvingSettings& carving,
                                      const GrowthSettings& settings, CarvedBoxes& boxes, RefutedBoxes* kept) {
  const voxel::GridGeometry& g = model.grid().geometry();
  const auto faces = measured_at_faces(model, carving);
  std::shared_ptr<PointsOutside> points = kept ? std::exchange(kept->points, nullptr) : nullptr;
  if (!points || !points->goes_on(g, carving, model.state().views)) points = std::make_shared<PointsOutside>(g, carving);
  points->add(model.state().views);
  if (kept) kept->points = points;
  Leak leak = leak_of(model, faces, *points, surroundings, settings);
  while (leak.voxels >= settings.least_voxels) {
    const voxel::OccupancyGrid& larger = boxes.carve(model, grown_box(g, leak));
    // What stands depends on the box a little, by the distance from its middle to the views: never back to a larger one, or this has no end.
    Leak standing = leak_of(model, faces, *points, surroundings, settings, &larger, leak.below);
    standing.keep_within(leak);
    if (standing.same_sides(leak) && standing.voxels >= settings.least_voxels) return boxes.take(model);
    if (standing.same_sides(leak)) break;
    leak = standing;
  }
  boxes.put_away();
  return {};
}

}  // namespace

void GrowthSettings::check() const {
  require(least_voxels >= 1 && least_voxels <= 1000000, ErrorCode::bad_input, "growth: least_voxels must lie between 1 and 1000000");
  require(margin_voxels >= 0 && margin_voxels <= 64, ErrorCode::bad_input, "growth: margin_voxels must lie between 0 and 64");
  require(least_area >= 0 && least_area <= 100, ErrorCode::bad_input, "growth: least_area must lie between 0 and 100");
}

Growth grow(const ObjectModel& model, const Surroundings& surroundings, const CarvingSettings& carving, const GrowthSettings& settings,
            RefutedBoxes* kept) {
  settings.check();
  Growth out;
  const Views& views = model.state().views;
  if (!settings.enabled || views.empty()) return out;
  const auto faces = measured_at_faces(model, carving);
  if (faces.empty()) return out;
  PointsOutside newest(model.grid().geometry(), carving);
  newest.add(Views{views.back()});
  if (leak_of(model, faces, newest, surroundings, settings).voxels < settings.least_voxels) return out;
  if (!model.can_be_revised()) {
    out.refused = "the object leaves its box, but its grid was imported or was begun by a version that kept too little depth to carve again";
    return out;
  }
  try {
    CarvedBoxes boxes(surroundings, carving, kept);
    while (auto larger = grown_once(out.model ? *out.model : model, surroundings, carving, settings, boxes, kept)) out.model = std::move(larger);
    if (kept && out.model) kept->points = nullptr;
  } catch (const Error& e) {
    if (e.code() != ErrorCode::bad_input && e.code() != ErrorCode::model_object_differs) throw;
    out.refused = e.what();
  }
  return out;
}

}  // namespace periplus::object_model
