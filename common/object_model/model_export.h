// A model for other programs. Metres, world frame, z up, unless a format demands otherwise; colours are sRGB, 0..255.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/object_model/object_model.h"
#include "common/object_model/surface.h"

namespace periplus::object_model {

struct ExportFormat {
  const char* name;
  const char* extension;  // with its dot
  const char* what;       // one line for a person
};
std::span<const ExportFormat> export_formats();

// The bytes of a file. Throws Error(bad_input) naming the formats where `format` is none of them, and for what a format cannot hold.
std::string export_model(const ObjectModel& model, std::string_view format, const CarvingSettings& settings = {});

// Binary little-endian PLY: x y z [m, world frame], red green blue, triangles.
std::string to_ply(const SurfaceMesh& mesh);
// The model's coloured surface.
std::string export_ply(const ObjectModel& model, const CarvingSettings& settings = {});

// Wavefront OBJ: "v x y z r g b" with colours 0..1, "vn", "f v//vn".
std::string to_obj(const SurfaceMesh& mesh);
// Binary glTF 2.0: y up, (x, y, z) of the world becomes (x, z, -y); COLOR_0 is linear, as glTF demands. A mesh without
// triangles becomes a scene without nodes.
std::string to_glb(const SurfaceMesh& mesh);

// The unit normal at each vertex: the mean over its triangles, weighted by their areas; up where these have none.
std::vector<Eigen::Vector3f> vertex_normals(const SurfaceMesh& mesh);

// One point for each known voxel, within that voxel.
struct SurfacePoints {
  std::vector<Eigen::Vector3f> points;                  // world [m]: on the zero of the signed distance, else the voxel's centre
  std::vector<Eigen::Vector3f> normals;                 // unit, outward; zero where neither distances nor empty neighbours tell
  std::vector<std::array<std::uint8_t, 3>> colors;      // rgb; grey where no view gave one
};
SurfacePoints surface_points(const ObjectModel& model);
// Binary little-endian PLY: x y z nx ny nz red green blue.
std::string to_ply(const SurfacePoints& points);
// PCD 0.7, binary: x y z rgb normal_x normal_y normal_z, as PCL and Open3D read them.
std::string to_pcd(const SurfacePoints& points);

// OctoMap binary tree (.bt) with leaves of the voxel size on OctoMap's own lattice (axes of the world, origin a leaf's
// corner): occupied where the voxel at a leaf's centre (on a border, the upper one) is known or environment, free where it is empty, unknown
// elsewhere.
std::string export_bt(const ObjectModel& model);
// The same tree without the file's head, as octomap::OcTree::readBinaryData reads it; nothing where all is unknown.
std::string octomap_data(const voxel::OccupancyGrid& grid);
// The same as a full ColorOcTree (.ot): occupied leaves carry the voxels' colours.
std::string export_ot(const ObjectModel& model);

// Comma-separated values (RFC 4180), one line a feature of each view, with a line of names. Features of one number `landmark` are
// observations of one spot (landmarks.h); `direction` is the orientation on the surface. Descriptors in hexadecimal.
std::string features_csv(const ObjectModel& model);

}  // namespace periplus::object_model
