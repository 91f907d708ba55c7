#include "integration-tests/nbv_benchmark/subject.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "common/core/config.h"
#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/hash.h"
#include "common/mesh/assets.h"

namespace periplus::nbv_benchmark {
namespace {

// Points that say which voxels the surface passes through: a dozen a voxel's face.
constexpr double kPointsPerFace = 12;

void finish(Subject& s, const SubjectOptions& o) {
  require(o.longest_side > 0 && o.margin >= 1 && o.voxels >= 8 && o.voxels <= 512 && o.samples > 0, ErrorCode::bad_input,
          "an object needs a side > 0, a margin >= 1, 8..512 voxels along its box and at least one sample");
  mesh::scale_upright(s.mesh, o.longest_side, s.file.up_axis);
  const mesh::Bounds b = mesh::bounds(s.mesh);
  mesh::transform(s.mesh, make_pose(-(b.lower + b.upper) / 2, Eigen::Matrix3d::Identity()));
  if (mesh::signed_volume(s.mesh) < 0) mesh::flip(s.mesh);
  s.tree = std::make_shared<mesh::TriangleTree>(s.mesh);
  s.samples = mesh::sample_surface(s.mesh, static_cast<std::size_t>(o.samples), o.seed);
  s.box_side = o.margin * o.longest_side;
  s.voxel_size = s.box_side / o.voxels;
  const voxel::GridGeometry g = grid_geometry(s, Eigen::Vector3d::Zero());
  const auto count = static_cast<std::size_t>(mesh::surface_area(s.mesh) / (s.voxel_size * s.voxel_size) * kPointsPerFace);
  std::vector<bool> taken(static_cast<std::size_t>(g.size.prod()), false);
  for (const mesh::SurfaceSample& p : mesh::sample_surface(s.mesh, std::clamp<std::size_t>(count, 1000, 4'000'000), o.seed + 1)) {
    const Eigen::Vector3i v = g.voxel_of(p.point);
    const std::size_t i = (static_cast<std::size_t>(v.x()) * g.size.y() + v.y()) * g.size.z() + v.z();
    if (!g.contains(v) || taken[i]) continue;
    taken[i] = true;
    s.voxel_points.push_back(p.point);
    s.voxel_normals.push_back(p.normal);
  }
}

}  // namespace

voxel::GridGeometry grid_geometry(const Subject& s, const Eigen::Vector3d& box_center_W) {
  return voxel::GridGeometry::from_box(make_pose(box_center_W, Eigen::Matrix3d::Identity()), Eigen::Vector3d::Constant(s.box_side), s.voxel_size);
}

Subject make_subject(const std::string& name, mesh::TriangleMesh mesh, const std::string& up_axis, const SubjectOptions& options) {
  Subject s;
  s.file = {name, "", up_axis, ""};
  s.mesh = std::move(mesh);
  finish(s, options);
  return s;
}

Subject load_subject(const SubjectFile& file, const SubjectOptions& options) {
  Subject s;
  s.file = file;
  s.sha256 = sha256_hex(read_file(file.path));
  s.mesh = mesh::load(file.path);
  try {
    finish(s, options);
  } catch (const Error& e) {
    throw_error(e.code(), file.path + ": " + e.what());
  }
  return s;
}

std::vector<SubjectFile> read_catalogue(const std::string& path) {
  const config::Node root = config::load_file(path);
  std::vector<SubjectFile> files;
  std::string missing;
  for (const config::Node& n : root.children("objects")) {
    SubjectFile f;
    f.name = n.get<std::string>("name");
    f.path = n.get<std::string>("mesh");
    n.read_choice("up_axis", f.up_axis, {"x", "y", "z", "-x", "-y", "-z"});
    n.read("texture", f.texture);
    try {
      f.path = mesh::find_asset(f.path);
    } catch (const Error&) {
      missing += (missing.empty() ? "" : ", ") + f.path;
    }
    files.push_back(f);
  }
  root.finish();
  require(!files.empty(), ErrorCode::bad_input, path + ": there is no object in `objects`");
  require(missing.empty(), ErrorCode::io,
          "these meshes of " + path + " are not in " + mesh::assets_folder() + ": " + missing + "; deploy/fetch-assets.sh fetches them");
  return files;
}

std::vector<SubjectFile> mesh_folder(const std::string& folder, const std::string& up_axis) {
  namespace fs = std::filesystem;
  require(fs::is_directory(folder), ErrorCode::io, "there is no folder " + folder);
  static const std::vector<std::string> kinds = {".obj", ".off", ".ply", ".stl", ".dae", ".gltf", ".glb", ".3ds"};
  std::map<std::string, SubjectFile> found;
  for (const fs::directory_entry& e : fs::directory_iterator(folder)) {
    std::string kind = e.path().extension().string();
    std::transform(kind.begin(), kind.end(), kind.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (!e.is_regular_file() || std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) continue;
    std::string name = e.path().stem().string();
    if (found.contains(name)) name = e.path().filename().string();
    found[name] = {name, e.path().string(), up_axis, ""};
  }
  std::string known;
  for (const std::string& k : kinds) known += " " + k;
  require(!found.empty(), ErrorCode::bad_input, "the folder " + folder + " holds no mesh (" + known.substr(1) + ")");
  std::vector<SubjectFile> files;
  for (const auto& [name, file] : found) files.push_back(file);
  return files;
}

voxel::OccupancyGrid true_grid(const Subject& s, const Pose& X_WO) {
  voxel::OccupancyGrid grid(grid_geometry(s, X_WO.translation()));
  std::fill(grid.occupied().begin(), grid.occupied().end(), 0);
  for (const Eigen::Vector3d& p : s.voxel_points) {
    const Eigen::Vector3i v = grid.geometry().voxel_of(X_WO * p);
    if (grid.geometry().contains(v)) grid.set_state(v, voxel::VoxelState::known);
  }
  return grid;
}

}  // namespace periplus::nbv_benchmark
