// Triangle meshes as plain arrays: load, place, texture coordinates, sampling, writing. Metres after scale_upright();
// before, whatever unit the file is in.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/pose.h"

namespace periplus::mesh {

struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;      // counter-clockwise seen from outside, where there is an outside
  std::vector<Eigen::Vector2d> corner_uv;      // three a triangle, v upwards; or empty
  std::vector<Eigen::Vector3d> corner_normals; // three a triangle, unit length; or empty
  std::vector<Eigen::Vector3d> colours;        // one a vertex, 0..1; or empty

  bool empty() const { return triangles.empty(); }
  // Throws Error(bad_input | not_finite | bad_size) if the arrays do not fit each other.
  void check() const;
};

struct Bounds {
  Eigen::Vector3d lower, upper;
  Eigen::Vector3d size() const { return upper - lower; }
};

struct LoadLimits {
  std::uint64_t most_bytes = 512ull << 20;
  std::size_t most_triangles = 5'000'000;
};

// Any format that assimp reads (OBJ, OFF, PLY, STL, glTF, ...). All parts of the file become one mesh, equal positions one
// vertex; triangles without area are dropped; texture coordinates and vertex colours are kept if every part has them. Throws Error(io) if
// the file cannot be read, Error(bad_input) if it has no triangle or a bad number, Error(bad_size) beyond the limits.
TriangleMesh load(const std::string& path, const LoadLimits& limits = {});

Bounds bounds(const TriangleMesh& mesh);
double surface_area(const TriangleMesh& mesh);
// Of a closed mesh, positive if its triangles face outwards.
double signed_volume(const TriangleMesh& mesh);
// Turns all triangles round.
void flip(TriangleMesh& mesh);
void transform(TriangleMesh& mesh, const Pose& X_AM);

// Turns `up_axis` (x y z -x -y -z) of the mesh to +z, scales its longest side to `longest_side` [m] and puts the middle
// of its bottom face to the origin. Returns X (rotation and translation) and s with p_new = X * (s * p_old).
struct Placement {
  Pose X = Pose::Identity();
  double scale = 1;
};
Placement scale_upright(TriangleMesh& mesh, double longest_side, std::string_view up_axis);

// Corner normals: mean of the faces around a vertex, weighted by area, but the face's own where they differ by more
// than 60 degrees (a crease).
void compute_normals(TriangleMesh& mesh);
// Corner texture coordinates from six projections along the axes, laid out as 3 x 2 tiles of one picture; a tile covers
// `tile_side` [m] about the middle of the mesh. Neighbouring faces with the same main direction share their tile.
void unwrap_six_tiles(TriangleMesh& mesh, double tile_side);

struct SurfaceSample {
  Eigen::Vector3d point, normal;  // the face's normal
  int triangle = 0;
};
// Uniform by area; the same points for the same seed.
std::vector<SurfaceSample> sample_surface(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed);

// Solids with texture coordinates at `texels_per_metre` pictures a metre (1: one picture covers one metre), faces cut into
// pieces of at most 0.25 m so that light per vertex looks even; centred at the origin, z up.
TriangleMesh make_box(const Eigen::Vector3d& size, double pictures_per_metre);
TriangleMesh make_cylinder(double diameter, double height, double pictures_per_metre);
TriangleMesh make_sphere(double diameter, double pictures_per_metre);

// Binary little-endian PLY, float positions; vertex colours where there are any.
std::string to_ply(const TriangleMesh& mesh);
void write_ply(const TriangleMesh& mesh, const std::string& path);
// MuJoCo's binary .msh with three vertices a face, as its texture coordinates are per vertex; normals are computed if absent.
std::string to_msh(const TriangleMesh& mesh);

}  // namespace periplus::mesh
