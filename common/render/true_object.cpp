#include "common/core/error.h"
#include "common/mesh/made_models.h"
#include "common/render/renderer.h"

namespace periplus::render {
namespace {

// Room between neighbouring tiles of the texture.
constexpr double kTileSlack = 1.25;

}  // namespace

TrueObject load_true_object(const scene::Truth& truth, const std::vector<std::string>& folders) {
  TrueObject object;
  object.mesh_W = mesh::load_named(truth.mesh, folders, object.path);
  object.texture = truth.texture;
  const mesh::Placement placed = mesh::scale_upright(object.mesh_W, truth.longest_side, truth.up_axis);
  if (mesh::signed_volume(object.mesh_W) < 0) mesh::flip(object.mesh_W);
  mesh::compute_normals(object.mesh_W);
  const bool painted = !truth.texture.empty() && !truth.texture.starts_with("noise:");
  if (!painted || object.mesh_W.corner_uv.empty()) mesh::unwrap_six_tiles(object.mesh_W, kTileSlack * truth.longest_side);
  mesh::transform(object.mesh_W, truth.X_WO);
  object.scale = placed.scale;
  object.X_WM = truth.X_WO * placed.X;
  return object;
}

}  // namespace periplus::render
