#include "common/wire/object_chunks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/dds/codec_impl.h"
#include "common/object_model/compression.h"
#include "common/wire/testing/random_grid.h"

namespace periplus::wire {
namespace {

using object_model::Landmark;
using testing::change;
using testing::random_grid;

std::vector<Landmark> landmarks(std::size_t n) {
  std::vector<Landmark> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back({{0.001 * static_cast<double>(i), 1, 2}, {0, 0, 1}, 0.02});
  return out;
}

TEST(ObjectChunks, HoldEveryVoxelOnce) {
  for (const Eigen::Vector3i& size : {Eigen::Vector3i(20, 13, 10), Eigen::Vector3i(140, 66, 82), Eigen::Vector3i(64, 128, 1), Eigen::Vector3i(8, 200, 96)}) {
    const voxel::OccupancyGrid grid = random_grid(size, 5);
    voxel::OccupancyGrid again(grid.geometry());
    for (std::size_t n = 0; n < voxel_chunk_count(grid.geometry()); ++n) write_chunk(read_chunk(grid, n), n, again);
    EXPECT_TRUE(testing::same_voxels(grid, again)) << size.transpose();
  }
}

// As model.idl says.
TEST(ObjectChunks, HoldVoxelsWhereTheContractSays) {
  voxel::OccupancyGrid grid(testing::geometry({140, 82, 200}));
  EXPECT_EQ(voxel_chunk_count(grid.geometry()), 3u * 2 * 4);
  for (int x = 0; x < 140; ++x)
    for (int y = 0; y < 82; ++y)
      for (int z = 0; z < 200; ++z) grid.set_state({x, y, z}, voxel::VoxelState::empty);
  const Eigen::Vector3i v(64 + 13, 64 + 6, 3 * 64 + 2);  // in chunk (1, 1, 3): voxel (13, 6, 2), in brick (1, 0, 0)
  grid.set_state(v, voxel::VoxelState::known);
  for (std::size_t n = 0; n < voxel_chunk_count(grid.geometry()); ++n) {
    const VoxelChunk chunk = read_chunk(grid, n);
    for (std::size_t w = 0; w < chunk.size(); ++w) {
      const bool here = n == (1 * 2 + 1) * 4 + 3 && w % kChunkPlaneWords == (1 * 64) * 8 + 5 && w / kChunkPlaneWords < 2;
      ASSERT_EQ(chunk[w], here ? std::uint64_t{1} << (6 * 8 + 2) : 0) << n << " " << w;
    }
  }
}

TEST(ObjectChunks, DigestIsTheContractsFormula) {
  VoxelChunk chunk{};
  chunk[0] = 7;
  chunk[12287] = 1;
  EXPECT_EQ(chunk_digest(chunk), 0xbeed295eb1f448c7u);  // computed from the contract in another language
  VoxelChunk other = chunk;
  other[700] ^= 1;
  EXPECT_NE(chunk_digest(other), chunk_digest(chunk));
}

TEST(ObjectSplitter, MakesOnlyWhatChanged) {
  voxel::OccupancyGrid grid = random_grid({140, 66, 82}, 1);  // 3 x 2 x 2 chunks
  std::vector<Landmark> seen = landmarks(2500);              // 3 chunks
  ObjectSplitter splitter;
  const ObjectOnWire first = splitter.split("bunny", grid, seen);
  EXPECT_EQ(first.chunks.size(), 15u);
  EXPECT_EQ(first.revision.voxel_chunks().size(), 12u);
  EXPECT_EQ(first.revision.landmark_chunks().size(), 3u);
  EXPECT_TRUE(splitter.split("bunny", grid, seen).chunks.empty());
  EXPECT_EQ(splitter.split("cup", grid, seen).chunks.size(), 15u);

  grid.revision = 2;
  change(grid, 50, 2, {0, 0, 64}, {64, 64, 82});
  seen[1100].size_m = 0.05;
  const ObjectOnWire second = splitter.split("bunny", grid, seen);
  ASSERT_EQ(second.chunks.size(), 2u);
  EXPECT_EQ(second.chunks[0].part(), 0);
  EXPECT_EQ(second.chunks[0].index(), 1u);
  EXPECT_EQ(second.chunks[0].digest(), second.revision.voxel_chunks()[1]);
  EXPECT_EQ(second.chunks[1].part(), 1);
  EXPECT_EQ(second.chunks[1].index(), 1u);
  EXPECT_EQ(second.revision.revision(), 2u);

  // Fewer landmarks, and as many again: whoever has the revision in between has the others' chunks no more.
  EXPECT_TRUE(splitter.split("bunny", grid, {seen.begin(), seen.begin() + 1024}).chunks.empty());
  EXPECT_EQ(splitter.split("bunny", grid, seen).chunks.size(), 2u);
  splitter.forget("bunny");
  EXPECT_EQ(splitter.split("bunny", grid, seen).chunks.size(), 15u);
  EXPECT_THROW(splitter.split("../etc", grid), Error);
  EXPECT_THROW(splitter.split("bunny", grid, landmarks(65537)), Error);
}

TEST(ObjectSplitter, NoSampleIsLargerThanTheContractSays) {
  voxel::OccupancyGrid grid(testing::geometry({512, 512, 512}, 0.004));
  Random random(3);
  for (std::size_t w = 0; w < 8 * 8 * 64 * 64; ++w) grid.occupied()[w] = random.next();  // nothing to deflate in the first chunks
  for (std::size_t w = 0; w < 8 * 8 * 64 * 64; ++w) grid.known()[w] = random.next() & grid.occupied()[w];
  for (std::size_t w = 0; w < 8 * 8 * 64 * 64; ++w) grid.environment()[w] = random.next() & grid.occupied()[w] & ~grid.known()[w];
  ObjectSplitter splitter;
  const ObjectOnWire object = splitter.split("bunny", grid, landmarks(65536), std::vector<Pose>(2000, Pose::Identity()));
  EXPECT_EQ(object.chunks.size(), 512u + 64u);
  EXPECT_EQ(object.revision.views().size(), kViewsOnWire);
  EXPECT_LE(dds::codec<msg::ObjectRevision>().size(&object.revision), 128u << 10);
  std::vector<std::uint8_t> bytes(128u << 10);
  for (const msg::ObjectChunk& chunk : object.chunks) {
    ASSERT_LE(dds::codec<msg::ObjectChunk>().size(&chunk), 128u << 10);
    msg::ObjectChunk back;  // and no sequence is over its bound
    const std::size_t n = dds::codec<msg::ObjectChunk>().encode(&chunk, bytes.data(), bytes.size());
    ASSERT_TRUE(dds::codec<msg::ObjectChunk>().decode(bytes.data(), n, &back));
  }
}

TEST(ObjectSplitter, TheLastViewsGoOut) {
  std::vector<Pose> views;
  for (int i = 0; i < static_cast<int>(kViewsOnWire) + 5; ++i) views.push_back(look_at({std::cos(0.01 * i), std::sin(0.01 * i), 1.2}, {0, 0, 0.7}));
  ObjectSplitter splitter;
  const msg::ObjectRevision m = splitter.split("bunny", random_grid({9, 9, 9}, 1), {}, views).revision;
  ASSERT_EQ(m.views().size(), kViewsOnWire);
  EXPECT_EQ(m.views().front().position().x(), views[5].translation().x());
  EXPECT_EQ(m.views().back().position().x(), views.back().translation().x());
}

TEST(ObjectChunks, HostileChunksAreRefused) {
  ObjectSplitter splitter;
  const ObjectOnWire object = splitter.split("bunny", random_grid({20, 13, 10}, 1), landmarks(2));
  using M = msg::ObjectChunk;
  const auto refusal = [&](std::size_t chunk, const std::function<void(M&)>& spoil) {
    M m = object.chunks[chunk];
    spoil(m);
    try {
      content_from_wire(m);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  const auto packed = [](const std::vector<std::uint64_t>& words) {
    const std::string s = object_model::pack_bytes(words.data(), words.size() * 8, 1);
    return std::vector<std::uint8_t>(s.begin(), s.end());
  };
  EXPECT_EQ(refusal(0, [](M&) {}), ErrorCode::ok);
  EXPECT_EQ(refusal(1, [](M&) {}), ErrorCode::ok);
  EXPECT_EQ(refusal(0, [](M& m) { m.part(2); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [](M& m) { m.part(1); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(1, [](M& m) { m.part(0); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [](M& m) { m.index(512); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal(0, [](M& m) { m.index(511); }), ErrorCode::ok);  // whether it is in the grid, its revision tells
  EXPECT_EQ(refusal(1, [](M& m) { m.index(64); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal(0, [](M& m) { m.digest(m.digest() ^ 1); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(1, [](M& m) { m.digest(m.digest() ^ 1); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [](M& m) { m.voxels().clear(); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [](M& m) { m.voxels().pop_back(); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [](M& m) { m.voxels()[m.voxels().size() / 2] ^= 0x55; }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [&](M& m) { m.voxels(packed(std::vector<std::uint64_t>(12287))); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [&](M& m) { m.voxels(packed(std::vector<std::uint64_t>(12289))); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(0, [](M& m) { m.landmarks().resize(1); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(1, [](M& m) { m.voxels().resize(1); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal(1, [](M& m) { m.landmarks().clear(); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal(1, [](M& m) { m.landmarks().resize(1025); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal(1, [](M& m) { m.landmarks()[0].size_m(std::numeric_limits<float>::infinity()); }), ErrorCode::not_finite);
  EXPECT_EQ(refusal(1, [](M& m) { m.landmarks()[1].size_m(-1); }), ErrorCode::not_finite);
  EXPECT_EQ(refusal(1, [](M& m) { m.landmarks()[0].normal().z(std::numeric_limits<double>::quiet_NaN()); }), ErrorCode::not_finite);
}

}  // namespace
}  // namespace periplus::wire
