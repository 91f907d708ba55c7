// The object as it is explored: the model server's carving and labels (common/object_model), without images and files.
#pragma once

#include "common/object_model/carving.h"
#include "common/object_model/evidence.h"
#include "common/voxel/occupancy_grid.h"
#include "integration-tests/nbv_benchmark/arena.h"
#include "integration-tests/nbv_benchmark/sensor.h"

namespace periplus::nbv_benchmark {

class Reconstruction {
 public:
  // All unknown but what touches a solid.
  Reconstruction(const Arena& arena, const Subject& subject, const object_model::CarvingSettings& settings);

  // As object_model::ObjectModel::integrate, but for colours, signed distances and features.
  void integrate(const Look& look);

  const voxel::OccupancyGrid& grid() const { return grid_; }
  // As the file `model.periplus`, for other programs: grid and evidence, without views.
  std::string model_file(const std::string& object_id) const;
  // Of Subject::voxel_points: those whose voxel is known.
  Mask known(const Subject& subject) const;

 private:
  const Arena& arena_;
  object_model::CarvingSettings settings_;
  voxel::OccupancyGrid grid_;
  std::vector<std::uint64_t> known_solids_;
  object_model::Evidence evidence_;
};

}  // namespace periplus::nbv_benchmark
