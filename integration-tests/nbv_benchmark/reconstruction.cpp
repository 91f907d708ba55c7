#include "integration-tests/nbv_benchmark/reconstruction.h"

#include "common/object_model/model_file.h"
#include "common/object_model/object_model.h"

namespace periplus::nbv_benchmark {

Reconstruction::Reconstruction(const Arena& arena, const Subject& subject, const object_model::CarvingSettings& settings)
    : arena_(arena), settings_(settings) {
  const object_model::ObjectModel begun(subject.file.name, arena.box, subject.voxel_size, {"", arena.collision, {}});
  grid_ = begun.grid();
  known_solids_ = begun.state().known_solids;
  evidence_ = begun.state().evidence;
}

void Reconstruction::integrate(const Look& look) {
  const voxel::GridGeometry& g = grid_.geometry();
  const object_model::CarvingRule rule = object_model::carving_rule(look.silhouette_valid_share, 0, g.voxel_size, settings_);
  const scene::CollisionWorld* solids = arena_.scene.solids.empty() ? nullptr : arena_.collision.get();
  for (const object_model::DepthMap& map : look.depth) {
    const object_model::PixelLimits limits = object_model::pixel_limits(map, g, settings_, rule.close_gaps, solids);
    object_model::empty_voxels(object_model::seen_through(grid_, map.camera, map.X_WC, limits.limit, rule.margin_voxels), rule.votes, grid_, evidence_);
    object_model::add_points(map, limits, g, rule.margin_voxels, evidence_);
  }
  object_model::label(known_solids_, settings_, evidence_, grid_);
  ++grid_.revision;
}

std::string Reconstruction::model_file(const std::string& object_id) const {
  object_model::ModelState state;
  state.object_id = object_id;
  state.box = arena_.box;
  state.grid = grid_;
  state.known_solids = known_solids_;
  state.evidence = evidence_;
  state.log_odds = object_model::LogOdds(grid_.geometry());
  state.tsdf = object_model::Tsdf(grid_.geometry());
  return object_model::write_model(object_model::ObjectModel(std::move(state)));
}

Mask Reconstruction::known(const Subject& subject) const {
  Mask out(subject.voxel_points.size());
  for (std::size_t i = 0; i < subject.voxel_points.size(); ++i)
    if (grid_.state(grid_.geometry().voxel_of(arena_.X_WO * subject.voxel_points[i])) == voxel::VoxelState::known) out.set(i);
  return out;
}

}  // namespace periplus::nbv_benchmark
