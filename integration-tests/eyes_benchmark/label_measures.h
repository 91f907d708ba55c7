// How a model's labels agree with what the eyes truly saw (thesis 5.1.2: perceived voxels are known, occluded ones unknown).
#pragma once

#include <cstdint>
#include <vector>

#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"
#include "integration-tests/eyes_benchmark/stage.h"

namespace periplus::eyes_benchmark {

struct LabelQuality {
  std::size_t known = 0, known_hidden = 0;  // known voxels, and those of them that no ray of an eye reaches before the object stops it
  // Voxels whose surface an eye saw plainly: ten pixels with a measured depth, no more than 60 degrees from the normal.
  std::size_t plain = 0, plain_unknown = 0, plain_emptied = 0;
  double hidden_share() const { return known == 0 ? 0 : static_cast<double>(known_hidden) / static_cast<double>(known); }
  double plain_unknown_share() const { return plain == 0 ? 0 : static_cast<double>(plain_unknown) / static_cast<double>(plain); }
  double plain_emptied_share() const { return plain == 0 ? 0 : static_cast<double>(plain_emptied) / static_cast<double>(plain); }
};

// By voxel_index(): 1 for the voxels that a ray through a pixel's centre of an eye passes up to the true depth.
std::vector<std::uint8_t> reached_voxels(const std::vector<Shot>& shots, const voxel::GridGeometry& geometry);
// `reached` as above. `perceptions`: of the shots that gave one, whose view_id ends with the shot's number.
LabelQuality label_quality(const voxel::OccupancyGrid& grid, const std::vector<std::uint8_t>& reached, const mesh::TriangleTree& object_W,
                           const std::vector<Shot>& shots, const std::vector<object_model::Perception>& perceptions);

}  // namespace periplus::eyes_benchmark
