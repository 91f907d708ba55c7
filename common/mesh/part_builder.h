// Puts a mesh together from closed parts, each painted with one material of a picture whose horizontal bands are materials
// (common/render/texture.h: "materials:<seed>"). Parts may reach into one another; each is closed and faces outwards.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/mesh/triangle_mesh.h"

namespace periplus::mesh {

// Band of the picture, from its lower edge up.
enum class Material { dark_wood, planks, canvas, leaves, stone, bark, paint, bronze };
inline constexpr int kMaterials = 8;

class PartBuilder {
 public:
  // Metres that the picture covers along u and, all its bands together, along v; it repeats itself along u.
  explicit PartBuilder(double picture_m) : picture_(picture_m) {}

  // A skin over rings of equally many points, each counter-clockwise seen from the ring after it; both ends are closed, over rings that
  // shrink towards their means (so the end rings must be star-shaped about those), or the last ring meets the first if `joined`.
  // The grain of the material runs from ring to ring.
  void loft(const std::vector<std::vector<Eigen::Vector3d>>& rings, Material material, bool joined = false);
  // Rings of `sides` points around a line of points, with a radius at each.
  void tube(const std::vector<Eigen::Vector3d>& line, const std::vector<double>& radii, int sides, Material material, bool joined = false);
  void tube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_from, double radius_to, int sides, Material material);
  // Full side lengths, cut into pieces of at most `piece`; the grain runs along x.
  void box(const Pose& X_MB, const Eigen::Vector3d& size, double piece, Material material);
  // front[i][j]: a grid of points; the sheet extends from it by `thickness` against its normal (rows x columns, right-handed).
  void sheet(const std::vector<std::vector<Eigen::Vector3d>>& front, double thickness, Material material);
  // An ellipsoid of the given half axes with bumps of the given share of them.
  void lump(const Eigen::Vector3d& center, const Eigen::Vector3d& half, double bumps, std::uint64_t seed, Material material);

  const TriangleMesh& mesh() const { return mesh_; }

 private:
  using Grid = std::vector<std::vector<int>>;  // of vertices
  int vertex(const Eigen::Vector3d& p);
  // Quads of a grid of vertices, which face the side from which rows and columns turn counter-clockwise.
  void paint(const Grid& grid, Material material);
  void triangle(int a, int b, int c, const Eigen::Vector2d& ua, const Eigen::Vector2d& ub, const Eigen::Vector2d& uc);
  void cap(std::vector<int> ring, Material material);

  double picture_;
  TriangleMesh mesh_;
};

}  // namespace periplus::mesh
