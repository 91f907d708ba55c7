#include "common/wire/object_chunks.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/core/error.h"
#include "common/object_model/compression.h"
#include "common/wire/common_wire.h"

namespace periplus::wire {

namespace {

static_assert(std::endian::native == std::endian::little, "words are packed as they lie in memory");

// Calls visit(word in a plane of the chunk, word in a plane of the grid, words) for each row of bricks along z.
template <class Visit>
void for_each_row(const voxel::GridGeometry& geometry, std::size_t index, Visit&& visit) {
  const Eigen::Vector3i bricks = geometry.bricks();
  const Eigen::Vector3i chunks = (bricks.array() + kChunkBricks - 1) / kChunkBricks;
  const int n = static_cast<int>(index);
  const Eigen::Vector3i least = kChunkBricks * Eigen::Vector3i(n / (chunks.y() * chunks.z()), n / chunks.z() % chunks.y(), n % chunks.z());
  const Eigen::Vector3i size = (bricks - least).cwiseMin(kChunkBricks);
  for (int x = 0; x < size.x(); ++x)
    for (int y = 0; y < size.y(); ++y)
      visit(static_cast<std::size_t>((x * kChunkBricks + y) * kChunkBricks) * 8,
            (static_cast<std::size_t>((least.x() + x) * bricks.y() + least.y() + y) * static_cast<std::size_t>(bricks.z()) + static_cast<std::size_t>(least.z())) * 8,
            static_cast<std::size_t>(size.z()) * 8);
}

class Digest {
 public:
  void add(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0x9e3779b97f4a7c15u;
    hash_ ^= hash_ >> 32;
  }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

msg::ObjectChunk chunk_of(std::string_view object_id, ChunkPart part, std::size_t index, std::uint64_t digest) {
  msg::ObjectChunk m;
  m.object_id(std::string(object_id));
  m.part(static_cast<std::uint8_t>(part));
  m.index(static_cast<std::uint32_t>(index));
  m.digest(digest);
  return m;
}

msg::Landmark to_wire(const object_model::Landmark& l) {
  msg::Landmark m;
  m.position(wire::to_wire(l.p_W));
  m.normal(wire::to_wire(l.normal_W));
  m.size_m(static_cast<float>(l.size_m));
  return m;
}

object_model::Landmark from_wire(const msg::Landmark& m) {
  const object_model::Landmark l{wire::from_wire(m.position()), wire::from_wire(m.normal()), static_cast<double>(m.size_m())};
  require(std::isfinite(l.size_m) && l.size_m >= 0, ErrorCode::not_finite, "a landmark's size must be a finite number of metres");
  return l;
}

// True if `digest` is not what was made of this chunk last.
bool is_new(std::vector<std::uint64_t>& made, std::size_t index, std::uint64_t digest) {
  const bool known = index < made.size();
  if (known && made[index] == digest) return false;
  if (!known) made.resize(index + 1);
  made[index] = digest;
  return true;
}

}  // namespace

std::size_t voxel_chunk_count(const voxel::GridGeometry& geometry) {
  const Eigen::Vector3i chunks = (geometry.bricks().array() + kChunkBricks - 1) / kChunkBricks;
  return static_cast<std::size_t>(chunks.prod());
}

VoxelChunk read_chunk(const voxel::OccupancyGrid& grid, std::size_t index) {
  VoxelChunk chunk{};
  for_each_row(grid.geometry(), index, [&](std::size_t in_chunk, std::size_t in_grid, std::size_t words) {
    std::size_t plane = 0;
    for (const auto* words_of : {&grid.occupied(), &grid.known(), &grid.environment()}) {
      std::copy_n(words_of->data() + in_grid, words, chunk.data() + plane + in_chunk);
      plane += kChunkPlaneWords;
    }
  });
  return chunk;
}

void write_chunk(const VoxelChunk& chunk, std::size_t index, voxel::OccupancyGrid& grid) {
  for_each_row(grid.geometry(), index, [&](std::size_t in_chunk, std::size_t in_grid, std::size_t words) {
    std::size_t plane = 0;
    for (auto* words_of : {&grid.occupied(), &grid.known(), &grid.environment()}) {
      std::copy_n(chunk.data() + plane + in_chunk, words, words_of->data() + in_grid);
      plane += kChunkPlaneWords;
    }
  });
}

std::uint64_t chunk_digest(const VoxelChunk& chunk) {
  Digest d;
  for (const std::uint64_t word : chunk) d.add(word);
  return d.value();
}

std::uint64_t chunk_digest(std::span<const object_model::Landmark> landmarks) {
  Digest d;
  for (const object_model::Landmark& l : landmarks) {
    for (const Eigen::Vector3d* v : {&l.p_W, &l.normal_W})
      for (const double x : *v) d.add(std::bit_cast<std::uint64_t>(x));
    d.add(std::bit_cast<std::uint32_t>(static_cast<float>(l.size_m)));
  }
  return d.value();
}

ChunkContent content_from_wire(const msg::ObjectChunk& m) {
  require(m.part() <= static_cast<std::uint8_t>(ChunkPart::landmarks), ErrorCode::bad_input,
          "an object's chunk holds voxels (part 0) or landmarks (part 1), not part " + std::to_string(m.part()));
  ChunkContent content;
  content.part = static_cast<ChunkPart>(m.part());
  const bool voxels = content.part == ChunkPart::voxels;
  const std::size_t most = voxels ? kMostVoxelChunks : kMostLandmarkChunks;
  require(m.index() < most, ErrorCode::bad_size, "an object has at most " + std::to_string(most) + " chunks of this part, so that there is none of number " + std::to_string(m.index()));
  std::uint64_t digest = 0;
  if (voxels) {
    require(m.landmarks().empty(), ErrorCode::bad_input, "a chunk of voxels holds no landmarks");
    content.voxels.resize(1);
    object_model::unpack_bytes({reinterpret_cast<const char*>(m.voxels().data()), m.voxels().size()}, sizeof(VoxelChunk), 1, content.voxels[0].data());
    digest = chunk_digest(content.voxels[0]);
  } else {
    require(m.voxels().empty(), ErrorCode::bad_input, "a chunk of landmarks holds no voxels");
    require(!m.landmarks().empty() && m.landmarks().size() <= kChunkLandmarks, ErrorCode::bad_size,
            "a chunk holds 1.." + std::to_string(kChunkLandmarks) + " landmarks, not " + std::to_string(m.landmarks().size()));
    content.landmarks.reserve(m.landmarks().size());
    for (const msg::Landmark& l : m.landmarks()) content.landmarks.push_back(from_wire(l));
    digest = chunk_digest(content.landmarks);
  }
  require(digest == m.digest(), ErrorCode::bad_input, "an object's chunk has another digest than it claims; have the object published again with model/publish");
  return content;
}

ObjectOnWire ObjectSplitter::split(std::string_view object_id, const voxel::OccupancyGrid& grid,
                                   const std::vector<object_model::Landmark>& landmarks, const std::vector<Pose>& views) {
  check_id(object_id, "the object's id");
  require(landmarks.size() <= kMostLandmarkChunks * kChunkLandmarks, ErrorCode::bad_size, "an object takes at most 65536 landmarks on the wire");
  const voxel::GridGeometry& g = grid.geometry();
  ObjectOnWire out;
  msg::ObjectRevision& m = out.revision;
  m.object_id(std::string(object_id));
  m.revision(grid.revision);
  m.pose_world_grid(wire::to_wire(g.X_WG));
  m.voxel_m(g.voxel_size);
  m.nx(static_cast<std::uint32_t>(g.size.x()));
  m.ny(static_cast<std::uint32_t>(g.size.y()));
  m.nz(static_cast<std::uint32_t>(g.size.z()));
  for (std::size_t n = views.size() - std::min(views.size(), kViewsOnWire); n < views.size(); ++n) m.views().push_back(wire::to_wire(views[n]));

  Made& made = made_[std::string(object_id)];
  for (std::size_t index = 0; index < voxel_chunk_count(g); ++index) {
    const VoxelChunk words = read_chunk(grid, index);
    const std::uint64_t digest = chunk_digest(words);
    m.voxel_chunks().push_back(digest);
    if (!is_new(made.voxels, index, digest)) continue;
    const std::string packed = object_model::pack_bytes(words.data(), sizeof words, 1);
    out.chunks.push_back(chunk_of(object_id, ChunkPart::voxels, index, digest));
    out.chunks.back().voxels(std::vector<std::uint8_t>(packed.begin(), packed.end()));
  }
  for (std::size_t index = 0; index * kChunkLandmarks < landmarks.size(); ++index) {
    const auto some = std::span(landmarks).subspan(index * kChunkLandmarks).first(std::min(kChunkLandmarks, landmarks.size() - index * kChunkLandmarks));
    const std::uint64_t digest = chunk_digest(some);
    m.landmark_chunks().push_back(digest);
    if (!is_new(made.landmarks, index, digest)) continue;
    out.chunks.push_back(chunk_of(object_id, ChunkPart::landmarks, index, digest));
    for (const object_model::Landmark& l : some) out.chunks.back().landmarks().push_back(to_wire(l));
  }
  // Readers forget what lies beyond the end.
  made.voxels.resize(m.voxel_chunks().size());
  made.landmarks.resize(m.landmark_chunks().size());
  return out;
}

void ObjectSplitter::forget(std::string_view object_id) {
  if (const auto it = made_.find(object_id); it != made_.end()) made_.erase(it);
}

}  // namespace periplus::wire
