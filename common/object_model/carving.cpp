#include "common/object_model/carving.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "common/core/error.h"
#include "common/object_model/carving_kernel.h"
#include "common/object_model/image_minimum.h"
#include "common/scene/scene.h"

namespace periplus::object_model {

namespace {

void in_range(double value, double minimum, double maximum, const char* name) {
  require(std::isfinite(value) && value >= minimum && value <= maximum, ErrorCode::bad_input,
          std::string(name) + " must lie between " + std::to_string(minimum) + " and " + std::to_string(maximum));
}

constexpr double kNearestCorner = 1e-3;   // what is nearer to the camera's plane is not seen through [m]
constexpr double kDepthRounding = 1e-5;   // of depths in single precision [m]
constexpr int kGreatestLevel = 6;         // squares of 64 pixels

// Nearest value along one direction within `reach` pixels; 0 if there is none.
float next_value(const ImageF& limit, int x, int y, int dx, int dy, int reach) {
  for (int n = 1; n <= reach; ++n) {
    const int u = x + dx * n, v = y + dy * n;
    if (u < 0 || v < 0 || u >= limit.width || v >= limit.height) return 0;
    if (limit.at(u, v) > 0) return limit.at(u, v);
  }
  return 0;
}

// Gaps of at most `gap_px` take the least of the four neighbours, if all four are near enough.
void close_gaps(ImageF& limit, int gap_px) {
  const ImageF measured = limit;
  for (int y = 0; y < limit.height; ++y)
    for (int x = 0; x < limit.width; ++x) {
      if (measured.at(x, y) > 0) continue;
      const float left = next_value(measured, x, y, -1, 0, gap_px);
      if (left <= 0) continue;
      const float right = next_value(measured, x, y, 1, 0, gap_px);
      if (right <= 0) continue;
      const float up = next_value(measured, x, y, 0, -1, gap_px);
      const float down = next_value(measured, x, y, 0, 1, gap_px);
      if (up > 0 && down > 0) limit.at(x, y) = std::min({left, right, up, down});
    }
}

// The floor is seen from further away than a table's top, so what counts as lying on it grows with the depth's uncertainty.
bool belongs_to_surroundings(const scene::CollisionWorld& known, const Eigen::Vector3d& p_W, double tolerance, double sigma) {
  return p_W.z() <= std::max(tolerance, 2 * sigma) || known.contains(p_W, tolerance);
}

}  // namespace

void CarvingSettings::check() const {
  in_range(margin_voxels, 0.5, 10, "margin_voxels");
  in_range(gap_px, 0, 64, "gap_px");
  in_range(cautious_share, 0, 1, "cautious_share");
  in_range(cautious_votes, 1, 100, "cautious_votes");
  in_range(solid_extra_voxels, 0, 10, "solid_extra_voxels");
  in_range(solid_tolerance_m, 0, 0.1, "solid_tolerance_m");
  in_range(known_points, 1, 10000, "known_points");
  in_range(seen_points, 1, 10000, "seen_points");
  in_range(truncation_voxels, 1, 20, "truncation_voxels");
}

PixelLimits pixel_limits(const DepthMap& map, const voxel::GridGeometry& geometry, const CarvingSettings& settings, bool cautious,
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
  const Pose X_GC = geometry.X_WG.inverse() * map.X_WC;
  // Only points near the box decide about voxels; further ones are free space whatever they belong to.
  const Eigen::Vector3d lower = Eigen::Vector3d::Constant(-4 * h);
  const Eigen::Vector3d upper = (geometry.size.cast<double>().array() + 4) * h;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float z = map.depth.at(x, y), least = map.depth_minimum.at(x, y);
      if (!(z > 0) || !(least > 0) || !std::isfinite(z)) continue;
      float limit = std::min(z, least);
      PixelKind kind = PixelKind::surface;
      if (known) {
        const Eigen::Vector3d p_C = map.camera.back_project(x, y, z);
        const Eigen::Vector3d p_G = X_GC * p_C;
        if ((p_G.array() >= lower.array()).all() && (p_G.array() <= upper.array()).all() &&
            belongs_to_surroundings(*known, map.X_WC * p_C, settings.solid_tolerance_m, has_sigma ? map.depth_sigma.at(x, y) : 0)) {
          kind = PixelKind::known_solid;
          // Where the footprint holds something much nearer, that is not the solid and must not be carved into.
          if (z - limit <= extra) limit += extra;
        }
      }
      out.limit.at(x, y) = limit;
      out.kind.at(x, y) = kind;
    }
  if (!cautious && settings.gap_px > 0) close_gaps(out.limit, settings.gap_px);
  return out;
}

std::vector<std::uint64_t> seen_through(const voxel::OccupancyGrid& grid, const Pinhole& camera, const Pose& X_WC, const ImageF& limit,
                                        double margin_voxels, voxel::Simd simd) {
  require(limit.width == camera.width && limit.height == camera.height && limit.channels == 1, ErrorCode::bad_size,
          "the limits of pixels must have the size of the camera's image");
  const voxel::GridGeometry& g = grid.geometry();
  const double h = g.voxel_size, margin = margin_voxels * h;
  std::vector<std::uint64_t> plane(grid.occupied().size(), 0);
  const Pose X_CG = X_WC.inverse() * g.X_WG;
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  Eigen::Matrix<double, 3, 4> m;
  m.leftCols<3>() = K * X_CG.linear() * h;
  m.col(3) = K * X_CG.translation();
  GridCamera projection;
  projection.width = camera.width;
  projection.height = camera.height;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 4; ++c) projection.m[r][c] = static_cast<float>(m(r, c));
  }
  const BlockRange blocks(limit);
  SquareMinimum squares(limit);
  const double half = 0.5 * m.row(2).head<3>().cwiseAbs().sum();  // from a voxel's centre to its nearest corner, in depth
  const Eigen::Vector3i nb = g.bricks();
  LayerRectangles rectangles;
  std::size_t word = 0;
  for (int bx = 0; bx < nb.x(); ++bx) {
    for (int by = 0; by < nb.y(); ++by) {
      for (int bz = 0; bz < nb.z(); ++bz, word += 8) {
        std::uint64_t candidates[8], any = 0;
        for (int x = 0; x < 8; ++x) any |= candidates[x] = grid.occupied()[word + x] & ~grid.environment()[word + x];
        if (any == 0) continue;
        // All of the brick at once: nothing of it, or all, may be seen through.
        double u0 = 1e9, u1 = -1e9, v0 = 1e9, v1 = -1e9, near = 1e9, far = -1e9;
        for (int c = 0; c < 8; ++c) {
          const Eigen::Vector3d q = m * Eigen::Vector4d(8 * (bx + (c & 1)), 8 * (by + (c >> 1 & 1)), 8 * (bz + (c >> 2)), 1);
          near = std::min(near, q.z());
          far = std::max(far, q.z());
          u0 = std::min(u0, q.x() / q.z());
          u1 = std::max(u1, q.x() / q.z());
          v0 = std::min(v0, q.y() / q.z());
          v1 = std::max(v1, q.y() / q.z());
        }
        if (far < kNearestCorner) continue;
        if (near > kNearestCorner) {
          if (u1 < 0 || v1 < 0 || u0 > camera.width - 1 || v0 > camera.height - 1) continue;
          const bool inside = u0 >= 0 && v0 >= 0 && u1 <= camera.width - 1 && v1 <= camera.height - 1;
          float least, greatest;
          blocks.range(std::max(0, static_cast<int>(u0)), std::max(0, static_cast<int>(v0)), std::min(camera.width - 1, static_cast<int>(u1) + 1),
                       std::min(camera.height - 1, static_cast<int>(v1) + 1), least, greatest);
          // Its voxels' centres lie half a voxel from its nearest and farthest corner.
          if (greatest <= near + half + margin) continue;
          if (inside && least > far - half + margin + kDepthRounding) {
            std::copy_n(candidates, 8, &plane[word]);
            continue;
          }
        }
        for (int x = 0; x < 8; ++x) {
          if (candidates[x] == 0) continue;
          layer_rectangles(projection, 8 * bx + x, 8 * by, 8 * bz, rectangles, simd);
          if (rectangles.shortest == 0) continue;
          const int level = std::min(static_cast<int>(std::bit_width(static_cast<unsigned>(rectangles.shortest))) - 1, kGreatestLevel);
          plane[word + x] = candidates[x] & layer_seen_through(rectangles, squares.level(level).data(), camera.width, 1 << level, static_cast<float>(margin), simd);
        }
      }
    }
  }
  return plane;
}

}  // namespace periplus::object_model
