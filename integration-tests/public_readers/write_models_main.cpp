// write_models FOLDER: a sphere's model in every format, and what a reader must find as truth.json.
#include <cstdio>
#include <exception>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/object_model/model_export.h"
#include "common/object_model/testing/sphere_views.h"

namespace {

using namespace periplus;
using namespace periplus::object_model;

nlohmann::json numbers(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json bounds(const std::vector<Eigen::Vector3f>& points) {
  Eigen::Vector3f least = points.at(0), most = least;
  for (const Eigen::Vector3f& p : points) {
    least = least.cwiseMin(p);
    most = most.cwiseMax(p);
  }
  return {numbers(least), numbers(most)};
}

// Each edge in both directions once: what a reader calls watertight.
bool is_closed(const SurfaceMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t n = 0; n < 3; ++n) ++edges[{t[n], t[(n + 1) % 3]}];
  for (const auto& [edge, count] : edges)
    if (count != 1 || !edges.contains({edge.second, edge.first})) return false;
  return true;
}

void write(const std::string& folder) {
  const testing::Sphere sphere;
  ObjectBox box = testing::box_around(sphere);
  box.size = {0.48, 0.48, 0.4};  // voxels on the lattice of the files
  ObjectModel model("ball", box, 0.02, {});
  constexpr int kViews = 6;
  for (int n = 0; n < kViews; ++n) model.integrate(testing::ideal_view(sphere, n, kViews), {}, {});
  for (const ExportFormat& format : export_formats()) {
    std::ofstream file(folder + "/ball" + format.extension, std::ios::binary);
    file << export_model(model, format.name);
    require(file.flush().good(), ErrorCode::io, std::string("cannot write a file in ") + folder);
  }
  const SurfaceMesh mesh = extract_surface(model.grid(), model.state().tsdf, CarvingSettings{}.truncation_voxels * 0.02);
  const SurfacePoints cloud = surface_points(model);
  const voxel::Counts counts = model.grid().counts();
  nlohmann::json truth;
  truth["voxel_m"] = 0.02;
  truth["mesh"] = {{"vertices", mesh.vertices.size()}, {"triangles", mesh.triangles.size()}, {"bounds", bounds(mesh.vertices)}, {"closed", is_closed(mesh)}};
  for (const std::size_t i : {std::size_t{0}, mesh.vertices.size() / 2, mesh.vertices.size() - 1})
    truth["mesh"]["samples"].push_back({{"index", i}, {"position", numbers(mesh.vertices[i])}, {"color", mesh.colors[i]}});
  truth["points"] = {{"count", cloud.points.size()}, {"bounds", bounds(cloud.points)}};
  for (const std::size_t i : {std::size_t{0}, cloud.points.size() / 2, cloud.points.size() - 1})
    truth["points"]["samples"].push_back({{"index", i}, {"position", numbers(cloud.points[i])}, {"color", cloud.colors[i]}, {"normal", numbers(cloud.normals[i])}});
  truth["voxels"] = {{"occupied", counts.known + counts.environment}, {"free", counts.empty}};
  truth["features"] = {{"count", kViews * 5}, {"x", model.state().views[0]->features[0].p_W.x()}, {"octets", 128}};
  truth["sphere"] = {{"center", {sphere.center.x(), sphere.center.y(), sphere.center.z()}}, {"radius", sphere.radius}};
  std::ofstream(folder + "/truth.json") << truth.dump(1);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "write_models FOLDER\n");
    return 2;
  }
  try {
    write(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "write_models: %s\n", error.what());
    return 1;
  }
  return 0;
}
