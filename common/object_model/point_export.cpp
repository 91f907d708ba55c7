#include <algorithm>
#include <bit>
#include <cmath>

#include "common/core/error.h"
#include "common/object_model/model_export.h"

namespace periplus::object_model {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

template <class T>
void append_binary(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Distance's rise along an axis [m/voxel], from the neighbours that were seen; NaN where there is none.
double rise(const ModelState& s, const Eigen::Vector3i& v, int axis) {
  const voxel::GridGeometry& g = s.grid.geometry();
  double difference = 0;
  int steps = 0;
  const float here = s.tsdf.at(v).distance;
  for (const int side : {-1, 1}) {
    Eigen::Vector3i w = v;
    w[axis] += side;
    if (!g.contains(w)) continue;
    const TsdfSample sample = s.tsdf.at(w);
    if (sample.weight <= 0) continue;
    difference += side * (static_cast<double>(sample.distance) - here);
    ++steps;
  }
  return steps ? difference / steps : std::nan("");
}

Eigen::Vector3d towards_empty(const voxel::OccupancyGrid& grid, const Eigen::Vector3i& v) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int n = 0; n < 27; ++n) {
    const Eigen::Vector3i step(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
    if (grid.geometry().contains(v + step) && grid.state(v + step) == voxel::VoxelState::empty) sum += step.cast<double>();
  }
  return sum;
}

}  // namespace

SurfacePoints surface_points(const ObjectModel& model) {
  // A point this close to its voxel's border stays inside when it is rounded to single precision [voxels].
  constexpr double kReach = 0.49;
  const ModelState& s = model.state();
  const voxel::GridGeometry& g = s.grid.geometry();
  SurfacePoints out;
  for (int x = 0; x < g.size.x(); ++x)
    for (int y = 0; y < g.size.y(); ++y)
      for (int z = 0; z < g.size.z(); ++z) {
        const Eigen::Vector3i v(x, y, z);
        if (s.grid.state(v) != voxel::VoxelState::known) continue;
        const TsdfSample sample = s.tsdf.at(v);
        Eigen::Vector3d center = v.cast<double>().array() + 0.5, normal = Eigen::Vector3d::Zero(), point = center;
        if (sample.weight > 0) {
          const Eigen::Vector3d gradient(rise(s, v, 0), rise(s, v, 1), rise(s, v, 2));
          if (gradient.allFinite() && gradient.norm() > 0.1 * g.voxel_size) {
            normal = gradient.normalized();
            point -= (gradient * (sample.distance / gradient.squaredNorm())).cwiseMax(-kReach).cwiseMin(kReach);
          }
        }
        if (normal.isZero()) {
          const Eigen::Vector3d sum = towards_empty(s.grid, v);
          if (sum.norm() > 1e-9) normal = sum.normalized();
        }
        out.points.push_back((g.X_WG * Eigen::Vector3d(point * g.voxel_size)).cast<float>());
        out.normals.push_back((g.X_WG.linear() * normal).cast<float>());
        std::array<std::uint8_t, 3> rgb{128, 128, 128};
        if (sample.color_weight > 0) {
          const float mean[3] = {sample.r, sample.g, sample.b};
          for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint8_t>(std::clamp(mean[c] + 0.5f, 0.0f, 255.0f));
        }
        out.colors.push_back(rgb);
      }
  return out;
}

std::string to_ply(const SurfacePoints& cloud) {
  std::string out = "ply\nformat binary_little_endian 1.0\ncomment metres, world frame, z up\nelement vertex " + std::to_string(cloud.points.size()) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) out += std::string("property float ") + name + "\n";
  out += "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    for (const Eigen::Vector3f& vector : {cloud.points[i], cloud.normals[i]})
      for (int n = 0; n < 3; ++n) append_binary(out, vector[n]);
    for (const std::uint8_t c : cloud.colors[i]) append_binary(out, c);
  }
  return out;
}

std::string to_pcd(const SurfacePoints& cloud) {
  const std::string count = std::to_string(cloud.points.size());
  // PCL packs 0x00rrggbb into the bits of a float.
  std::string out =
      "# .PCD v0.7 - Point Cloud Data file format\n# metres, world frame, z up\nVERSION 0.7\nFIELDS x y z rgb normal_x normal_y normal_z\n"
      "SIZE 4 4 4 4 4 4 4\nTYPE F F F F F F F\nCOUNT 1 1 1 1 1 1 1\nWIDTH " +
      count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    for (int n = 0; n < 3; ++n) append_binary(out, cloud.points[i][n]);
    const auto& rgb = cloud.colors[i];
    append_binary(out, std::uint32_t{rgb[0]} << 16 | std::uint32_t{rgb[1]} << 8 | rgb[2]);
    for (int n = 0; n < 3; ++n) append_binary(out, cloud.normals[i][n]);
  }
  return out;
}

}  // namespace periplus::object_model
