// The objects of the benchmark: any triangle mesh, upright and scaled to one size, with samples of its surface.
//
// Object frame O: z up, origin in the middle of the bounding box. Metres.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/mesh/triangle_mesh.h"
#include "common/mesh/triangle_tree.h"
#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::nbv_benchmark {

struct SubjectFile {
  std::string name;
  std::string path;
  std::string up_axis = "y";  // x y z -x -y -z of the file's axes
  std::string texture;        // a picture, for stereo where the file has texture coordinates; empty: rich noise
};

struct Subject {
  SubjectFile file;
  std::string sha256;                        // of the file
  mesh::TriangleMesh mesh;                   // frame O
  std::shared_ptr<const mesh::TriangleTree> tree;
  std::vector<mesh::SurfaceSample> samples;  // area-uniform
  // The grid's side lengths; a cube with a margin, so that all objects are explored at the same resolution.
  double box_side = 0;
  double voxel_size = 0;
  // The voxels that the surface passes through, of a grid about the origin of O; each by one point of the surface in it.
  std::vector<Eigen::Vector3d> voxel_points, voxel_normals;
};

struct SubjectOptions {
  double longest_side = 0.5;   // [m]
  double margin = 1.1;         // box side, times the longest side
  int voxels = 128;            // along the box's side
  int samples = 20000;
  std::uint64_t seed = 1;
};

// Throws Error(io | bad_input | bad_size) naming the file and what is wrong with it.
Subject load_subject(const SubjectFile& file, const SubjectOptions& options);
// From a mesh in any unit; for tests.
Subject make_subject(const std::string& name, mesh::TriangleMesh mesh, const std::string& up_axis, const SubjectOptions& options);

// The objects of the catalogue (config/objects.yaml). Throws Error(bad_input) for a file that is no catalogue, Error(io) naming
// what has to be fetched.
std::vector<SubjectFile> read_catalogue(const std::string& path);
// All mesh files of a folder (.obj .off .ply .stl .dae .gltf .glb .3ds), by name. Throws Error(io) if there is no such folder, Error(bad_input) if it holds
// no mesh.
std::vector<SubjectFile> mesh_folder(const std::string& folder, const std::string& up_axis);

// Occupied where the surface is, everything else empty; the box stands about X_WO * 0.
voxel::OccupancyGrid true_grid(const Subject& subject, const Pose& X_WO);
// What the surface looks like in a grid of this subject's geometry; see voxel_points.
voxel::GridGeometry grid_geometry(const Subject& subject, const Eigen::Vector3d& box_center_W);

}  // namespace periplus::nbv_benchmark
