#include "integration-tests/eyes_benchmark/voxel_truth.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/object_model/evidence.h"

namespace periplus::eyes_benchmark {
namespace {

// A column of voxel centres that runs through an edge of the mesh would count it twice or not at all [voxels].
constexpr double kAside[2] = {1.0e-7, 1.3e-7};

// Adds 1 to each voxel whose centre has an odd number of crossings before it along `axis`. `corners` in voxels.
void add_parity(const std::vector<std::array<Eigen::Vector3d, 3>>& corners, const voxel::GridGeometry& g, int axis, std::vector<std::uint8_t>& votes) {
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  std::vector<std::vector<double>> columns(static_cast<std::size_t>(g.size[b]) * static_cast<std::size_t>(g.size[c]));
  const auto column = [&](int i, int j) -> std::vector<double>& { return columns[static_cast<std::size_t>(i) * static_cast<std::size_t>(g.size[c]) + static_cast<std::size_t>(j)]; };
  for (const auto& t : corners) {
    Eigen::Vector2d q[3];
    for (int k = 0; k < 3; ++k) q[k] = {t[static_cast<std::size_t>(k)][b] - 0.5 + kAside[0], t[static_cast<std::size_t>(k)][c] - 0.5 + kAside[1]};
    const Eigen::Vector2d e = q[1] - q[0], f = q[2] - q[0];
    const double area = e.x() * f.y() - e.y() * f.x();
    if (std::abs(area) < 1e-15) continue;
    const auto first = [&](int k) { return std::max(0, static_cast<int>(std::ceil(std::min({q[0][k], q[1][k], q[2][k]})))); };
    const auto last = [&](int k, int n) { return std::min(n - 1, static_cast<int>(std::floor(std::max({q[0][k], q[1][k], q[2][k]})))); };
    for (int i = first(0); i <= last(0, g.size[b]); ++i)
      for (int j = first(1); j <= last(1, g.size[c]); ++j) {
        double w[3];
        for (int k = 0; k < 3; ++k) {
          const Eigen::Vector2d &p = q[(k + 1) % 3], &r = q[(k + 2) % 3];
          w[k] = ((p.x() - i) * (r.y() - j) - (p.y() - j) * (r.x() - i)) / area;
        }
        if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
        column(i, j).push_back(w[0] * t[0][axis] + w[1] * t[1][axis] + w[2] * t[2][axis]);
      }
  }
  for (int i = 0; i < g.size[b]; ++i)
    for (int j = 0; j < g.size[c]; ++j)
      for (int k = 0; k < g.size[axis]; ++k) {
        const auto beyond = std::count_if(column(i, j).begin(), column(i, j).end(), [&](double at) { return at > k + 0.5; });
        Eigen::Vector3i v;
        v[axis] = k;
        v[b] = i;
        v[c] = j;
        votes[voxel::voxel_index(g, v)] += static_cast<std::uint8_t>(beyond % 2);
      }
}

}  // namespace

VoxelTruth voxel_truth(const mesh::TriangleMesh& mesh_W, const voxel::GridGeometry& g, std::size_t samples, std::uint64_t seed) {
  const auto n = static_cast<std::size_t>(g.size.x()) * static_cast<std::size_t>(g.size.y()) * static_cast<std::size_t>(g.size.z());
  VoxelTruth truth{std::vector<std::uint8_t>(n, 0), std::vector<std::uint8_t>(n, 0)};
  const Pose X_GW = g.X_WG.inverse();
  std::vector<std::array<Eigen::Vector3d, 3>> corners;
  for (const Eigen::Vector3i& t : mesh_W.triangles) {
    std::array<Eigen::Vector3d, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = X_GW * mesh_W.vertices[static_cast<std::size_t>(t[static_cast<int>(k)])] / g.voxel_size;
    corners.push_back(c);
  }
  for (int axis = 0; axis < 3; ++axis) add_parity(corners, g, axis, truth.inside);
  for (std::uint8_t& votes : truth.inside) votes = votes >= 2;
  for (const mesh::SurfaceSample& s : mesh::sample_surface(mesh_W, samples, seed)) {
    const Eigen::Vector3i v = g.voxel_of(s.point);
    if (g.contains(v)) truth.touching[voxel::voxel_index(g, v)] = 1;
  }
  return truth;
}

}  // namespace periplus::eyes_benchmark
