#include "common/object_model/carving.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "common/core/error.h"
#include "common/scene/scene.h"

namespace periplus::object_model {

namespace {

void in_range(double value, double minimum, double maximum, const char* name) {
  require(std::isfinite(value) && value >= minimum && value <= maximum, ErrorCode::bad_input,
          std::string(name) + " must lie between " + std::to_string(minimum) + " and " + std::to_string(maximum));
}

// Least value of any rectangle of an image in a few look-ups: level k holds the minimum over squares of 2^k pixels.
class RectangleMinimum {
 public:
  explicit RectangleMinimum(const ImageF& image) : width_(image.width), height_(image.height) {
    levels_.push_back(image.data);
    for (int side = 1; side * 2 <= std::min({width_, height_, kLargestSquare}); side *= 2) {
      const std::vector<float>& from = levels_.back();
      std::vector<float> to(from.size(), 0);
      for (int y = 0; y + 2 * side <= height_; ++y) {
        const float* a = &from[static_cast<std::size_t>(y) * width_];
        const float* b = &from[static_cast<std::size_t>(y + side) * width_];
        float* out = &to[static_cast<std::size_t>(y) * width_];
        for (int x = 0; x + 2 * side <= width_; ++x) out[x] = std::min(std::min(a[x], a[x + side]), std::min(b[x], b[x + side]));
      }
      levels_.push_back(std::move(to));
    }
  }

  // Over x0..x1, y0..y1, both ends included and inside the image.
  float operator()(int x0, int y0, int x1, int y1) const {
    const int shorter = std::min(x1 - x0, y1 - y0) + 1;
    const int level = std::min(static_cast<int>(std::bit_width(static_cast<unsigned>(shorter))) - 1, static_cast<int>(levels_.size()) - 1);
    const int side = 1 << level;
    const std::vector<float>& values = levels_[static_cast<std::size_t>(level)];
    float least = std::numeric_limits<float>::infinity();
    for (int y = y0;; y += side) {
      const int row = std::min(y, y1 - side + 1);
      for (int x = x0;; x += side) {
        const int column = std::min(x, x1 - side + 1);
        least = std::min(least, values[static_cast<std::size_t>(row) * width_ + column]);
        if (column + side > x1) break;
      }
      if (row + side > y1) break;
    }
    return least;
  }

 private:
  static constexpr int kLargestSquare = 64;
  int width_, height_;
  std::vector<std::vector<float>> levels_;
};

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
                                        double margin_voxels) {
  const voxel::GridGeometry& g = grid.geometry();
  const double h = g.voxel_size;
  const RectangleMinimum least(limit);
  std::vector<std::uint64_t> plane(grid.occupied().size(), 0);

  // Homogeneous pixel coordinates are affine in the voxel's index: one column per axis, corners by adding columns.
  const Pose X_CG = X_WC.inverse() * g.X_WG;
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  const Eigen::Matrix3d M = K * X_CG.linear() * h;
  const Eigen::Vector3d origin = K * X_CG.translation();
  Eigen::Vector3d corner[8];
  for (int c = 0; c < 8; ++c) corner[c] = M * Eigen::Vector3d(c & 1, (c >> 1) & 1, c >> 2);
  const double half_depth = 0.5 * (M(2, 0) + M(2, 1) + M(2, 2));

  const Eigen::Vector3i nb = g.bricks();
  std::size_t word = 0;
  for (int bx = 0; bx < nb.x(); ++bx)
    for (int by = 0; by < nb.y(); ++by)
      for (int bz = 0; bz < nb.z(); ++bz)
        for (int wx = 0; wx < 8; ++wx, ++word) {
          std::uint64_t candidates = grid.occupied()[word] & ~grid.environment()[word];
          while (candidates) {
            const int bit = std::countr_zero(candidates);
            candidates &= candidates - 1;
            const Eigen::Vector3d base =
                origin + M * Eigen::Vector3d(bx * 8 + wx, by * 8 + (bit >> 3), bz * 8 + (bit & 7));
            double u0 = 1e9, u1 = -1e9, v0 = 1e9, v1 = -1e9, nearest = 1e9;
            for (const Eigen::Vector3d& offset : corner) {
              const Eigen::Vector3d q = base + offset;
              nearest = std::min(nearest, q.z());
              const double inverse = 1 / q.z(), u = q.x() * inverse, v = q.y() * inverse;
              u0 = std::min(u0, u);
              u1 = std::max(u1, u);
              v0 = std::min(v0, v);
              v1 = std::max(v1, v);
            }
            // Behind the camera, or partly outside the image: nothing is known about all of it.
            if (!(nearest > 1e-3) || !(u0 >= -0.5 && v0 >= -0.5 && u1 < camera.width - 0.5 && v1 < camera.height - 0.5)) continue;
            const float found = least(static_cast<int>(u0 + 0.5), static_cast<int>(v0 + 0.5), static_cast<int>(u1 + 0.5),
                                      static_cast<int>(v1 + 0.5));
            if (found > base.z() + half_depth + margin_voxels * h) plane[word] |= 1ull << bit;
          }
        }
  return plane;
}

}  // namespace periplus::object_model
