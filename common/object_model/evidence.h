// What speaks for each voxel's label, gathered over all views; and the labels that follow from it.
//
// A depth point falls into a voxel (`points`), and is seen through the voxels that the conservative margin leaves standing
// closely in front of it (`seen`): such a voxel has been looked at and found to lie at the surface, so that looking again
// gains nothing. Points of known solids count apart (`solid`): what stands closely before a table's surface is the table's.
//
//   points >= known_points, or seen >= seen_points    known
//   otherwise solid >= seen_points                    environment
//   otherwise                                         unknown
//
// Labels are made anew after each view: a known voxel that is seen through later becomes empty.
#pragma once

#include <cstdint>
#include <vector>

#include "common/object_model/carving.h"

namespace periplus::object_model {

// Index (x * ny + y) * nz + z. Counters stop at their largest value.
struct Evidence {
  std::vector<std::uint16_t> points, seen, solid;
  std::vector<std::uint8_t> votes;  // of depth maps that show the voxel to be empty

  Evidence() = default;
  explicit Evidence(const voxel::GridGeometry& geometry);
};

inline std::size_t voxel_index(const voxel::GridGeometry& g, const Eigen::Vector3i& v) {
  return (static_cast<std::size_t>(v.x()) * g.size.y() + v.y()) * g.size.z() + v.z();
}

// Adds the points of one depth map.
void add_points(const DepthMap& map, const PixelLimits& limits, const voxel::GridGeometry& geometry, const CarvingSettings& settings,
                Evidence& evidence);

// Adds the votes of a plane of seen_through() and empties the voxels that have enough of them: one from a view that is
// not cautious, `cautious_votes` otherwise.
void empty_voxels(const std::vector<std::uint64_t>& plane, bool cautious, const CarvingSettings& settings, voxel::OccupancyGrid& grid,
                  Evidence& evidence);

// Labels all occupied voxels but those of `environment`, the plane of what was known before the first look.
void label(const std::vector<std::uint64_t>& environment, const CarvingSettings& settings, const Evidence& evidence,
           voxel::OccupancyGrid& grid);

}  // namespace periplus::object_model
