// An object in chunks, as idl/periplus/model.idl describes them: what changed of it since it was split last, and what a chunk holds.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"
#include "idl/model.h"

namespace periplus::wire {

inline constexpr int kChunkBricks = 8;                  // along each axis
inline constexpr std::size_t kChunkPlaneWords = 4096;   // of each of the three planes
inline constexpr std::size_t kMostVoxelChunks = 512;    // of 512 voxels along each axis
inline constexpr std::size_t kChunkLandmarks = 1024, kMostLandmarkChunks = 64;
// Of more views than this the last ones go on the wire.
inline constexpr std::size_t kViewsOnWire = 1024;

enum class ChunkPart : std::uint8_t { voxels = 0, landmarks = 1 };

// Planes occupied, known, environment of 64 x 64 x 64 voxels.
using VoxelChunk = std::array<std::uint64_t, 3 * kChunkPlaneWords>;

std::size_t voxel_chunk_count(const voxel::GridGeometry& geometry);
// Bricks beyond the grid read as 0, and are not written.
VoxelChunk read_chunk(const voxel::OccupancyGrid& grid, std::size_t index);
void write_chunk(const VoxelChunk& chunk, std::size_t index, voxel::OccupancyGrid& grid);
std::uint64_t chunk_digest(const VoxelChunk& chunk);
std::uint64_t chunk_digest(std::span<const object_model::Landmark> landmarks);

// What a chunk from the wire holds, one of the two.
struct ChunkContent {
  ChunkPart part = ChunkPart::voxels;
  std::vector<VoxelChunk> voxels;  // one, or none
  std::vector<object_model::Landmark> landmarks;
  std::size_t octets() const { return voxels.size() * sizeof(VoxelChunk) + landmarks.size() * sizeof(object_model::Landmark); }
};
// Throws Error(bad_input | bad_size | not_finite): a part or index that there is not, contents that are damaged, belong to the other
// part or have another digest than they claim.
ChunkContent content_from_wire(const msg::ObjectChunk& chunk);

struct ObjectOnWire {
  msg::ObjectRevision revision;
  std::vector<msg::ObjectChunk> chunks;  // that were not made before, to go out before it
};

// Remembers which chunks of each object it made last. Not thread-safe.
class ObjectSplitter {
 public:
  // `views`: left eyes X_WC, in the order of integration. Throws Error(bad_input | bad_size): an identifier that is none, or more than
  // 65536 landmarks.
  ObjectOnWire split(std::string_view object_id, const voxel::OccupancyGrid& grid, const std::vector<object_model::Landmark>& landmarks = {},
                     const std::vector<Pose>& views = {});
  // All its chunks are made again.
  void forget(std::string_view object_id);

 private:
  struct Made {
    std::vector<std::uint64_t> voxels, landmarks;  // digests
  };
  std::map<std::string, Made, std::less<>> made_;
};

}  // namespace periplus::wire
