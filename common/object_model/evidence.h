// What speaks for each voxel's label, gathered over all views; and the labels that follow from it.
//
// A depth point falls into a voxel (`points`), and is seen through the voxels that the conservative margin leaves standing
// closely in front of it (`seen`): such a voxel has been looked at and found to lie at the surface, so that looking again
// gains nothing. The surface may truly lie a standard deviation of the depth further off, half a voxel at most; it is seen up to there. Points
// of known solids count apart (`solid`): what stands closely before a table's surface is the table's.
//
//   points >= known_points, or seen >= seen_points    known
//   otherwise solid >= seen_points                    environment
//   otherwise                                         unknown
//
// Labels are made anew after each view: a known voxel that is seen through later becomes empty.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/object_model/carving.h"
#include "common/voxel/brick_field.h"

namespace periplus::object_model {

// Of one voxel. Counters stop at their largest value.
struct VoxelEvidence {
  std::uint16_t points = 0, seen = 0, solid = 0;
  std::uint8_t votes = 0;  // of cautious depth maps that show the voxel to be empty
  bool operator==(const VoxelEvidence&) const = default;
};

// Counters of a brick, in its order of voxels.
struct EvidenceBrick {
  std::array<std::uint16_t, voxel::kBrickVoxels> points{}, seen{}, solid{};
  std::array<std::uint8_t, voxel::kBrickVoxels> votes{};
  bool operator==(const EvidenceBrick&) const = default;
};

// That eyes saw voxel `v` of a brick at the surface.
inline bool is_seen(const EvidenceBrick& brick, std::size_t v, const CarvingSettings& settings) {
  return (brick.points[v] >= settings.known_points) | (brick.seen[v] >= settings.seen_points);
}

class Evidence {
 public:
  Evidence() = default;
  explicit Evidence(const voxel::GridGeometry& geometry) : geometry_(geometry), bricks_(geometry) {}

  // Of a voxel inside the grid.
  VoxelEvidence at(const Eigen::Vector3i& v) const;
  void set(const Eigen::Vector3i& v, const VoxelEvidence& e);

  const voxel::BrickField<EvidenceBrick>& bricks() const { return bricks_; }
  voxel::BrickField<EvidenceBrick>& bricks() { return bricks_; }
  bool operator==(const Evidence& other) const { return bricks_ == other.bricks_; }

 private:
  voxel::GridGeometry geometry_;
  voxel::BrickField<EvidenceBrick> bricks_;
};

// Adds the points of one depth map. The same counts for any `simd`.
void add_points(const DepthMap& map, const PixelLimits& limits, const voxel::GridGeometry& geometry, double margin_voxels, Evidence& evidence,
                voxel::Simd simd = voxel::Simd::best);

// What these change of a grid's planes they note in `changed` if it is given: one mark a brick, for voxel::ExposedFaces. No mark is taken back.

// Empties the voxels of a plane of seen_through(); where `votes` is above 1, only those that as many depth maps have shown to be empty.
void empty_voxels(const std::vector<std::uint64_t>& plane, int votes, voxel::OccupancyGrid& grid, Evidence& evidence, voxel::BrickMarks* changed = nullptr);

// What one depth map says to both: seen_through() and empty_voxels() for the grid, add_points() for the evidence, on two threads where
// two are to be had.
void carve_and_count(const DepthMap& map, const PixelLimits& limits, double margin_voxels, int votes, voxel::OccupancyGrid& grid, Evidence& evidence,
                     voxel::BrickMarks* changed = nullptr);

// Labels all occupied voxels but those of `environment`, the plane of what was known before the first look.
void label(const std::vector<std::uint64_t>& environment, const CarvingSettings& settings, const Evidence& evidence,
           voxel::OccupancyGrid& grid, voxel::BrickMarks* changed = nullptr);

}  // namespace periplus::object_model
