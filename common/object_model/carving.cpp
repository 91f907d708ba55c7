#include "common/object_model/carving.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <string>
#include <utility>

#include "common/core/error.h"
#include "common/object_model/carving_kernel.h"
#include "common/object_model/grid_projection.h"
#include "common/object_model/image_minimum.h"
#include "common/scene/scene.h"

namespace periplus::object_model {

namespace {

void in_range(double value, double minimum, double maximum, const char* name) {
  require(std::isfinite(value) && value >= minimum && value <= maximum, ErrorCode::bad_input,
          std::string(name) + " must lie between " + std::to_string(minimum) + " and " + std::to_string(maximum));
}

constexpr double kDepthRounding = 1e-5;   // of depths in single precision [m]

// Gaps of at most `gap_px` take the least of the four neighbours, if all four are near enough.
void close_gaps(ImageF& limit, int gap_px) {
  const int width = limit.width, height = limit.height;
  ImageF least(width, height);  // of the neighbours to the left, to the right and above; 0 where one is missing
  std::vector<int> above(static_cast<std::size_t>(width), -1 - gap_px), below(static_cast<std::size_t>(width), height + gap_px);  // rows with a value
  for (int y = 0; y < height; ++y) {
    const float* row = &limit.at(0, y);
    for (int x = 0; x < width;) {
      if (row[x] > 0) {
        above[static_cast<std::size_t>(x++)] = y;
        continue;
      }
      const int begin = x;
      while (x < width && !(row[x] > 0)) ++x;
      if (begin == 0 || x == width) continue;
      const float beside = std::min(row[begin - 1], row[x]);
      for (int u = std::max(begin, x - gap_px); u < std::min(x, begin + gap_px); ++u) {
        const int up = above[static_cast<std::size_t>(u)];
        if (y - up <= gap_px) least.at(u, y) = std::min(beside, limit.at(u, up));
      }
    }
  }
  // Upwards: what is filled lies below all that is still to be looked at, and is no neighbour to it.
  for (int y = height - 1; y >= 0; --y) {
    float* row = &limit.at(0, y);
    for (int x = 0; x < width; ++x) {
      int& down = below[static_cast<std::size_t>(x)];
      if (row[x] > 0)
        down = y;
      else if (least.at(x, y) > 0 && down - y <= gap_px)
        row[x] = std::min(least.at(x, y), limit.at(x, down));
    }
  }
}

// Marks the pixels of row y whose point lies within -below .. upper of the grid frame [m], in single precision; false if there is none.
bool near_box(const DepthMap& map, const Pose& X_GC, int y, double below, const Eigen::Array3d& upper, std::vector<std::uint8_t>& near) {
  const Eigen::Vector3f along = (X_GC.linear().col(0) / map.camera.fx).cast<float>(), first = (X_GC.linear() * map.camera.back_project(0, y, 1)).cast<float>();
  const Eigen::Vector3f origin = X_GC.translation().cast<float>(), top = upper.matrix().cast<float>();
  const float bottom = static_cast<float>(-below);
  const float* row = &map.depth.at(0, y);
  std::uint8_t any = 0;
  for (int x = 0; x < map.camera.width; ++x) {
    const float z = row[x], u = static_cast<float>(x);
    const float px = origin.x() + z * (first.x() + along.x() * u), py = origin.y() + z * (first.y() + along.y() * u), pz = origin.z() + z * (first.z() + along.z() * u);
    const bool in = (px >= bottom) & (py >= bottom) & (pz >= bottom) & (px <= top.x()) & (py <= top.y()) & (pz <= top.z());
    any |= near[static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(in);
  }
  return any != 0;
}

// The floor is seen from further away than a table's top, so what may be the floor's grows with the uncertainty of its height, but never far
// into what stands there.
constexpr double kFloorSigmas = 3, kMostFloorVoxels = 2;

}  // namespace

void CarvingSettings::check() const {
  in_range(margin_voxels, 0.5, 10, "margin_voxels");
  in_range(gap_px, 0, 64, "gap_px");
  in_range(cautious_share, 0, 1, "cautious_share");
  in_range(cautious_votes, 1, 100, "cautious_votes");
  in_range(uncertain_pose_m, 0, 1, "uncertain_pose_m");
  in_range(uncertain_pose_voxels, 0, 10, "uncertain_pose_voxels");
  in_range(uncertain_margin_voxels, margin_voxels, 10, "uncertain_margin_voxels");
  in_range(solid_extra_voxels, 0, 10, "solid_extra_voxels");
  in_range(solid_tolerance_m, 0, 0.1, "solid_tolerance_m");
  in_range(known_points, 1, 10000, "known_points");
  in_range(seen_points, 1, 10000, "seen_points");
  in_range(truncation_voxels, 1, 20, "truncation_voxels");
  in_range(log_odds.hit, 0.01, 5, "log_odds.hit");
  in_range(log_odds.miss, -5, -0.01, "log_odds.miss");
  in_range(log_odds.least, -20, -0.01, "log_odds.least");
  in_range(log_odds.most, 0.01, 20, "log_odds.most");
  in_range(log_odds.empty_below, log_odds.least, 0, "log_odds.empty_below");
  in_range(log_odds.known_above, 0, log_odds.most, "log_odds.known_above");
  in_range(log_odds.disparity_sigma_px, 0.01, 10, "log_odds.disparity_sigma_px");
  in_range(log_odds.support_share, 0, 1, "log_odds.support_share");
  in_range(log_odds.support_voxels, 0.01, 100, "log_odds.support_voxels");
}

double point_sigma(const Eigen::Matrix<double, 6, 6>& pose_covariance, double distance) {
  const auto greatest = [](const Eigen::Matrix3d& m) {
    return std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues()[2]);
  };
  return std::sqrt(greatest(pose_covariance.topLeftCorner<3, 3>()) + distance * distance * greatest(pose_covariance.bottomRightCorner<3, 3>()));
}

CarvingRule carving_rule(double silhouette_valid_share, double pose_sigma_m, double voxel_size, const CarvingSettings& settings) {
  const bool uncertain = !(pose_sigma_m < std::max(settings.uncertain_pose_m, settings.uncertain_pose_voxels * voxel_size));
  const bool cautious = uncertain || silhouette_valid_share < settings.cautious_share;
  return {uncertain ? settings.uncertain_margin_voxels : settings.margin_voxels, !cautious, cautious ? settings.cautious_votes : 1, pose_sigma_m};
}

PixelLimits pixel_limits(const DepthMap& map, const voxel::GridGeometry& geometry, const CarvingSettings& settings, bool closes_gaps,
                         const scene::CollisionWorld* known) {
  const int width = map.camera.width, height = map.camera.height;
  for (const ImageF* image : {&map.depth, &map.depth_minimum})
    require(image->width == width && image->height == height && image->channels == 1 &&
                image->data.size() == static_cast<std::size_t>(width) * height,
            ErrorCode::bad_size, "depth and least depth must have the size of the camera's image");
  PixelLimits out{ImageF(width, height), Image<PixelKind>(width, height, 1, PixelKind::none)};
  const double h = geometry.voxel_size;
  const float extra = static_cast<float>(settings.solid_extra_voxels * h);
  const bool has_sigma = map.depth_sigma.width == width && map.depth_sigma.height == height;
  static_assert(sizeof(PixelKind) == 1 && static_cast<int>(PixelKind::none) == 0 && static_cast<int>(PixelKind::surface) == 1);
  const bool gaps = !measured_limits(map.depth.data.data(), map.depth_minimum.data.data(), width * height, out.limit.data.data(),
                                     reinterpret_cast<std::uint8_t*>(out.kind.data.data()), voxel::Simd::best);
  if (known) {
    // Only points near the box decide about voxels; further ones are free space whatever they belong to.
    const Pose X_GC = geometry.X_WG.inverse() * map.X_WC;
    const Eigen::Vector3d upper = (geometry.size.cast<double>().array() + 4) * h;
    std::vector<std::uint8_t> near(static_cast<std::size_t>(width));
    for (int y = 0; y < height; ++y) {
      if (!near_box(map, X_GC, y, 5 * h, upper.array() + h, near)) continue;
      for (int x = 0; x < width; ++x) {
        if (!near[static_cast<std::size_t>(x)] || out.kind.at(x, y) == PixelKind::none) continue;
        const float z = map.depth.at(x, y);
        const Eigen::Vector3d p_C = map.camera.back_project(x, y, z), p_G = X_GC * p_C;
        if ((p_G.array() < -4 * h).any() || (p_G.array() > upper.array()).any()) continue;
        const Eigen::Vector3d p_W = map.X_WC * p_C;
        const bool is_solid = p_W.z() <= settings.solid_tolerance_m || known->contains(p_W, settings.solid_tolerance_m);
        const double sigma = has_sigma ? map.depth_sigma.at(x, y) * std::abs(p_W.z() - map.X_WC.translation().z()) / z : 0;  // of its height
        if (!is_solid && p_W.z() > std::min(kFloorSigmas * sigma, kMostFloorVoxels * h)) continue;
        out.kind.at(x, y) = PixelKind::known_solid;
        // What may as well stand on the floor must not be carved into, nor, where the footprint holds something much nearer, that.
        float& limit = out.limit.at(x, y);
        if (is_solid && z - limit <= extra) limit += extra;
      }
    }
  }
  if (gaps && closes_gaps && settings.gap_px > 0) close_gaps(out.limit, settings.gap_px);
  return out;
}

struct SeenThrough::Impl {
  Impl(const voxel::OccupancyGrid& g, const Pinhole& camera, const Pose& X_WC, const ImageF& limit, double margin_voxels, voxel::Simd instructions)
      : grid(g), projection(camera, X_WC, g.geometry()), blocks(limit), squares(limit), margin(margin_voxels * g.geometry().voxel_size), simd(instructions) {}

  // The bricks of one bx.
  void slab(int bx, std::uint64_t* plane);

  const voxel::OccupancyGrid& grid;
  const GridProjection projection;
  const BlockRange blocks;
  SquareMinimum squares;
  const double margin;  // [m]
  const voxel::Simd simd;
  std::atomic<int> next_slab{0};
};

void SeenThrough::Impl::slab(int bx, std::uint64_t* plane) {
  const Eigen::Vector3i nb = grid.geometry().bricks();
  LayerRectangles rectangles;
  PlaneCorners corners[2];  // of planes x and x + 1, by their parity
  std::size_t word = static_cast<std::size_t>(bx) * nb.y() * nb.z() * 8;
  for (int by = 0; by < nb.y(); ++by) {
    for (int bz = 0; bz < nb.z(); ++bz, word += 8) {
      std::uint64_t candidates[8], any = 0;
      for (int x = 0; x < 8; ++x) any |= candidates[x] = grid.occupied()[word + x] & ~grid.environment()[word + x];
      if (any == 0) continue;
      // All of the brick at once: nothing of it, or all, may be seen through.
      const BrickView view(projection, bx, by, bz);
      if (view.out_of_view) continue;
      if (view.in_front) {
        float least, greatest;
        blocks.range(view.x0, view.y0, view.x1, view.y1, least, greatest);
        // Its voxels' centres lie half a voxel from its nearest and farthest corner.
        if (greatest <= view.near + projection.half + margin) continue;
        if (view.inside && least > view.far - projection.half + margin + kDepthRounding) {
          std::copy_n(candidates, 8, &plane[word]);
          continue;
        }
      }
      int plane_known = -1;
      for (int x = 0; x < 8; ++x) {
        if (candidates[x] == 0) continue;
        if (plane_known != x) plane_corners(projection.camera, 8 * bx + x, 8 * by, 8 * bz, corners[x & 1], simd);
        plane_known = x + 1;
        plane_corners(projection.camera, 8 * bx + x + 1, 8 * by, 8 * bz, corners[plane_known & 1], simd);
        layer_rectangles(projection.camera, 8 * bx + x, 8 * by, 8 * bz, corners[x & 1], corners[plane_known & 1], rectangles, simd);
        if (rectangles.shortest == 0) continue;
        const std::size_t size = SquareMinimum::index_of(rectangles.shortest);
        plane[word + x] = candidates[x] & layer_seen_through(rectangles, squares.least(size), projection.camera.width, SquareMinimum::kSides[size], static_cast<float>(margin), simd);
      }
    }
  }
}

SeenThrough::SeenThrough(const voxel::OccupancyGrid& grid, const Pinhole& camera, const Pose& X_WC, const ImageF& limit, double margin_voxels,
                         voxel::Simd simd) {
  require(limit.width == camera.width && limit.height == camera.height && limit.channels == 1, ErrorCode::bad_size,
          "the limits of pixels must have the size of the camera's image");
  plane.assign(grid.occupied().size(), 0);
  impl_ = std::make_unique<Impl>(grid, camera, X_WC, limit, margin_voxels, voxel::resolve(simd));
}

SeenThrough::~SeenThrough() = default;

void SeenThrough::work() {
  const int slabs = impl_->grid.geometry().bricks().x();
  for (int bx = impl_->next_slab++; bx < slabs; bx = impl_->next_slab++) impl_->slab(bx, plane.data());
}

std::vector<std::uint64_t> seen_through(const voxel::OccupancyGrid& grid, const Pinhole& camera, const Pose& X_WC, const ImageF& limit,
                                        double margin_voxels, voxel::Simd simd) {
  SeenThrough carving(grid, camera, X_WC, limit, margin_voxels, simd);
  carving.work();
  return std::move(carving.plane);
}

}  // namespace periplus::object_model
