#include "common/wire/object_assembler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <variant>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/wire/testing/random_grid.h"

namespace periplus::wire {
namespace {

using testing::change;
using testing::random_grid;

using Sample = std::variant<msg::ObjectRevision, msg::ObjectChunk>;
using Objects = ObjectAssembler::Whole;

std::vector<Sample> samples(const ObjectOnWire& object) {
  std::vector<Sample> out(object.chunks.begin(), object.chunks.end());
  out.emplace_back(object.revision);
  return out;
}

void shuffle(std::vector<Sample>& all, Random& random) {
  for (std::size_t n = all.size(); n > 1; --n) std::swap(all[n - 1], all[random.below(n)]);
}

Objects take(ObjectAssembler& assembler, const std::vector<Sample>& all) {
  Objects out;
  for (const Sample& sample : all) {
    const Objects whole = std::visit([&](const auto& m) { return assembler.take(m); }, sample);
    out.insert(out.end(), whole.begin(), whole.end());
  }
  return out;
}

std::vector<object_model::Landmark> landmarks(std::size_t n, double x) {
  std::vector<object_model::Landmark> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back({{x, 0.001 * static_cast<double>(i), 2}, {0, 0, 1}, 0.02});
  return out;
}

TEST(ObjectAssembler, GivesWhatWasSplitInWhateverOrder) {
  const voxel::OccupancyGrid grid = random_grid({140, 66, 82}, 1, 7);
  const std::vector<Pose> views(3, look_at({1, 0.5, 1.2}, {0, 0, 0.7}));
  Random random(2);
  for (int round = 0; round < 20; ++round) {
    ObjectSplitter splitter;
    std::vector<Sample> all = samples(splitter.split("bunny", grid, landmarks(2500, 0.5), views));
    shuffle(all, random);
    ObjectAssembler assembler;
    const Sample last = all.back();
    all.pop_back();
    ASSERT_TRUE(take(assembler, all).empty());
    const Objects objects = take(assembler, {last});
    ASSERT_EQ(objects.size(), 1u);
    const KnownObject& o = *objects[0];
    EXPECT_EQ(o.object_id, "bunny");
    EXPECT_EQ(o.revision, 7u);
    EXPECT_EQ(o.grid->revision, 7u);
    EXPECT_TRUE(testing::same_voxels(*o.grid, grid));
    ASSERT_EQ(o.landmarks.size(), 2500u);
    EXPECT_EQ(o.landmarks[2100].p_W, Eigen::Vector3d(0.5, 2.1, 2));
    EXPECT_NEAR(o.landmarks[1].size_m, 0.02, 1e-8);
    ASSERT_EQ(o.views.size(), 3u);
    EXPECT_TRUE(o.views[2].isApprox(views[2], 1e-14));
  }
}

// What a run sends: grids that change, landmarks that come and go, a box that grows, and an object begun anew; each revision's samples in
// any order, and at times those of two together.
TEST(ObjectAssembler, FollowsARunRevisionByRevision) {
  Random random(9);
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  voxel::OccupancyGrid grid = random_grid({80, 80, 80}, 1, 0);
  std::map<std::uint32_t, std::pair<voxel::OccupancyGrid, std::size_t>> sent;
  std::uint32_t given = 0;
  for (std::uint32_t revision = 1; revision <= 60; ++revision) {
    std::vector<Sample> all;
    const int together = revision % 5 == 0 ? 2 : 1;
    for (int n = 0; n < together; ++n) {
      if (n) ++revision;
      if (revision == 20) grid = random_grid({150, 80, 80}, revision);
      if (revision == 40) grid = voxel::OccupancyGrid(testing::geometry({66, 100, 180}));
      change(grid, 30, revision, {0, 0, 0}, {40, 66, 66});
      grid.revision = revision;
      const std::size_t seen = (revision * 700) % 3000;
      sent[revision] = {grid, seen};
      const auto more = samples(splitter.split("bunny", grid, landmarks(seen, revision / 10)));
      all.insert(all.end(), more.begin(), more.end());
    }
    if (together == 1) shuffle(all, random);  // of two revisions the writer's order of each chunk holds
    for (const auto& object : take(assembler, all)) {
      EXPECT_GT(object->revision, given);
      given = object->revision;
      EXPECT_TRUE(testing::same_voxels(*object->grid, sent[given].first)) << given;
      const auto expected = landmarks(sent[given].second, given / 10);
      ASSERT_EQ(object->landmarks.size(), expected.size()) << given;
      for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(object->landmarks[i].p_W, expected[i].p_W) << given;
    }
    EXPECT_EQ(given, revision);
  }
}

TEST(ObjectAssembler, ATornRevisionIsNeverGivenAndTheNextOneIs) {
  voxel::OccupancyGrid grid = random_grid({140, 66, 82}, 1, 1);
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  ASSERT_EQ(take(assembler, samples(splitter.split("bunny", grid))).size(), 1u);
  change(grid, 20000, 2);
  grid.revision = 2;
  std::vector<Sample> second = samples(splitter.split("bunny", grid));
  ASSERT_EQ(second.size(), 13u);
  const Sample lost = second[3];
  second.erase(second.begin() + 3);
  EXPECT_TRUE(take(assembler, second).empty());
  // Only the lost chunk changes: the third revision needs the second's others.
  change(grid, 50, 3, {0, 64, 64}, {64, 66, 82});
  grid.revision = 3;
  const std::vector<Sample> third = samples(splitter.split("bunny", grid));
  ASSERT_EQ(third.size(), 2u);
  const Objects objects = take(assembler, third);
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0]->revision, 3u);
  EXPECT_TRUE(testing::same_voxels(*objects[0]->grid, grid));
  EXPECT_TRUE(take(assembler, {lost}).empty());  // too late
}

TEST(ObjectAssembler, TwoRevisionsWhoseHeadersCameFirstAreBothGiven) {
  voxel::OccupancyGrid grid = random_grid({140, 66, 82}, 1, 1);
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  const ObjectOnWire first = splitter.split("bunny", grid);
  change(grid, 50, 2, {0, 0, 0}, {64, 64, 64});
  grid.revision = 2;
  const ObjectOnWire second = splitter.split("bunny", grid);
  EXPECT_TRUE(take(assembler, {first.revision, second.revision}).empty());
  // As Cyclone DDS gives them: all of a chunk's versions, then the next chunk's.
  std::vector<Sample> chunks{first.chunks[0], second.chunks[0]};
  chunks.insert(chunks.end(), first.chunks.begin() + 1, first.chunks.end());
  const Objects objects = take(assembler, chunks);
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0]->revision, 1u);
  EXPECT_TRUE(testing::same_voxels(*objects[0]->grid, random_grid({140, 66, 82}, 1)));
  EXPECT_EQ(objects[1]->revision, 2u);
  EXPECT_TRUE(testing::same_voxels(*objects[1]->grid, grid));
}

// A chunk that is again what it was, while the revision in between is not yet whole.
TEST(ObjectAssembler, AChunkThatGoesBackIsKept) {
  const voxel::OccupancyGrid grid = random_grid({80, 60, 60}, 1, 1);
  voxel::OccupancyGrid other = grid;
  change(other, 50, 2, {0, 0, 0}, {60, 60, 60});
  other.revision = 2;
  voxel::OccupancyGrid back = grid;
  back.revision = 3;
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  ASSERT_EQ(take(assembler, samples(splitter.split("bunny", grid))).size(), 1u);
  const ObjectOnWire second = splitter.split("bunny", other), third = splitter.split("bunny", back);
  const Objects objects = take(assembler, {second.chunks[0], third.chunks[0], second.revision, third.revision});
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_TRUE(testing::same_voxels(*objects[0]->grid, other));
  EXPECT_TRUE(testing::same_voxels(*objects[1]->grid, grid));
}

TEST(ObjectAssembler, PublishedAgainOrBegunAnewIsGivenAgain) {
  voxel::OccupancyGrid grid = random_grid({40, 30, 30}, 1, 5);
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  const std::vector<Sample> first = samples(splitter.split("bunny", grid));
  const auto given = take(assembler, first);
  ASSERT_EQ(given.size(), 1u);
  EXPECT_EQ(take(assembler, first), given);  // the very same
  // A server of the same name that knows another object of that revision.
  voxel::OccupancyGrid other = random_grid({40, 30, 30}, 2, 5);
  ObjectSplitter restarted;
  const auto anew = take(assembler, samples(restarted.split("bunny", other)));
  ASSERT_EQ(anew.size(), 1u);
  EXPECT_TRUE(testing::same_voxels(*anew[0]->grid, other));
  other.revision = 0;
  const auto lower = take(assembler, samples(restarted.split("bunny", other)));
  ASSERT_EQ(lower.size(), 1u);
  EXPECT_EQ(lower[0]->revision, 0u);
  EXPECT_EQ(lower[0]->grid->revision, 0u);
}

// An object begun anew in a smaller box, and again in its first one; landmarks that come back.
TEST(ObjectAssembler, WhatWasBeyondTheEndComesAgain) {
  const voxel::OccupancyGrid large(testing::geometry({140, 66, 82})), small(testing::geometry({60, 60, 60}));
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  std::uint32_t revision = 0;
  for (const auto& [grid, seen] : {std::pair(&large, std::size_t{2500}), std::pair(&small, std::size_t{100}), std::pair(&large, std::size_t{2500})}) {
    voxel::OccupancyGrid now = *grid;
    now.revision = ++revision;
    const Objects objects = take(assembler, samples(splitter.split("bunny", now, landmarks(seen, 1))));
    ASSERT_EQ(objects.size(), 1u) << revision;
    EXPECT_EQ(objects[0]->revision, revision);
    EXPECT_TRUE(testing::same_voxels(*objects[0]->grid, now));
    EXPECT_EQ(objects[0]->landmarks.size(), seen);
  }
}

// What is published again of a whole revision is kept while another one waits: that one, of fewer chunks, may take its place before the rest is here.
TEST(ObjectAssembler, AnOlderRevisionThatBecomesWholeMeanwhileTakesNothingFromTheNewest) {
  const voxel::OccupancyGrid first = random_grid({80, 60, 60}, 1, 1), small = random_grid({64, 60, 60}, 2, 2);
  voxel::OccupancyGrid third = first;
  third.revision = 3;
  write_chunk(read_chunk(small, 0), 0, third);
  ObjectAssembler assembler;
  ASSERT_EQ(take(assembler, samples(ObjectSplitter().split("bunny", first))).size(), 1u);
  ASSERT_TRUE(take(assembler, {ObjectSplitter().split("bunny", small).revision}).empty());  // its chunk is lost
  const ObjectOnWire newest = ObjectSplitter().split("bunny", third);
  ASSERT_EQ(newest.chunks.size(), 2u);
  const Objects objects = take(assembler, {newest.chunks[1], newest.chunks[0], newest.revision});
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_TRUE(testing::same_voxels(*objects[0]->grid, small));
  EXPECT_TRUE(testing::same_voxels(*objects[1]->grid, third));
}

TEST(ObjectAssembler, WhatAWholeRevisionReplacedIsNotKept) {
  voxel::OccupancyGrid grid = random_grid({140, 66, 82}, 1, 1);
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  const ObjectOnWire first = splitter.split("bunny", grid);
  ASSERT_EQ(take(assembler, samples(first)).size(), 1u);
  change(grid, 20000, 2);
  grid.revision = 2;
  ASSERT_EQ(take(assembler, samples(splitter.split("bunny", grid))).size(), 1u);
  EXPECT_TRUE(take(assembler, {first.revision}).empty());
  EXPECT_EQ(take(assembler, {first.chunks.begin(), first.chunks.end()}).size(), 1u);
}

TEST(ObjectAssembler, HostileRevisionsAreRefused) {
  ObjectSplitter splitter;
  const std::vector<Pose> views(3, look_at({1, 0.5, 1.2}, {0, 0, 0.7}));
  const msg::ObjectRevision good = splitter.split("bunny", random_grid({140, 66, 82}, 1), landmarks(2, 1), views).revision;
  using M = msg::ObjectRevision;
  const auto refusal = [&](const std::function<void(M&)>& spoil) {
    M m = good;
    spoil(m);
    ObjectAssembler assembler;
    try {
      assembler.take(m);
    } catch (const Error& e) {
      return e.code();
    }
    return ErrorCode::ok;
  };
  EXPECT_EQ(refusal([](M&) {}), ErrorCode::ok);
  EXPECT_EQ(refusal([](M& m) { m.nx(4000000000u); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal([](M& m) { m.nx(0); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal([](M& m) { m.ny(512); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal([](M& m) { m.voxel_chunks().pop_back(); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal([](M& m) { m.voxel_chunks().push_back(1); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal([](M& m) { m.landmark_chunks().resize(64); }), ErrorCode::ok);
  EXPECT_EQ(refusal([](M& m) { m.landmark_chunks().resize(65); }), ErrorCode::bad_size);
  EXPECT_EQ(refusal([](M& m) { m.voxel_m(std::numeric_limits<double>::quiet_NaN()); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal([](M& m) { m.voxel_m(-0.01); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal([](M& m) { m.object_id("../etc"); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal([](M& m) { m.pose_world_grid().qx(3); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal([](M& m) { m.views()[1].position().z(std::numeric_limits<double>::infinity()); }), ErrorCode::not_finite);
  EXPECT_EQ(refusal([](M& m) { m.views()[0].qw(2); }), ErrorCode::bad_input);
  EXPECT_EQ(refusal([](M& m) { m.views().resize(kViewsOnWire, m.views()[0]); }), ErrorCode::ok);
  EXPECT_EQ(refusal([](M& m) { m.views().resize(kViewsOnWire + 1, m.views()[0]); }), ErrorCode::bad_size);
  ObjectAssembler assembler;
  msg::ObjectChunk nameless;
  EXPECT_THROW(assembler.take(nameless), Error);
}

TEST(ObjectAssembler, BitsBeyondTheGridAndContradictionsAreCleared) {
  voxel::OccupancyGrid grid(testing::geometry({20, 13, 10}));
  for (auto* plane : {&grid.occupied(), &grid.known(), &grid.environment()}) std::fill(plane->begin(), plane->end(), ~std::uint64_t{0});
  ObjectSplitter splitter;
  ObjectAssembler assembler;
  const auto objects = take(assembler, samples(splitter.split("bunny", grid)));
  ASSERT_EQ(objects.size(), 1u);
  EXPECT_EQ(objects[0]->grid->counts(), (voxel::Counts{0, 0, 0, 20 * 13 * 10}));
}

TEST(ObjectAssembler, ForgetsTheObjectsHeardOfLongestAgo) {
  const voxel::OccupancyGrid grid = random_grid({20, 20, 20}, 1);
  const auto name = [](std::size_t n) { return "cup" + std::to_string(n); };
  ObjectAssembler assembler;
  ObjectSplitter splitter;
  std::vector<ObjectOnWire> cups;
  for (std::size_t n = 0; n <= ObjectAssembler::kObjects; ++n) cups.push_back(splitter.split(name(n), grid));
  for (const ObjectOnWire& cup : cups) ASSERT_EQ(take(assembler, samples(cup)).size(), 1u);
  EXPECT_EQ(take(assembler, {cups[1].revision}).size(), 1u);
  EXPECT_TRUE(take(assembler, {cups[0].revision}).empty());  // its chunk went with it
  EXPECT_EQ(take(assembler, {cups[0].chunks[0]}).size(), 1u);
}

// What a late joiner hears of a store of many objects: all chunks, then all revisions.
TEST(ObjectAssembler, ManyObjectsWhoseChunksCameFirstAreAllGiven) {
  const voxel::OccupancyGrid grid = random_grid({140, 66, 82}, 1);
  ObjectAssembler assembler;
  ObjectSplitter splitter;
  std::vector<Sample> chunks, revisions;
  for (std::size_t n = 0; n < ObjectAssembler::kObjects; ++n) {
    const ObjectOnWire cup = splitter.split("cup" + std::to_string(n), grid);
    chunks.insert(chunks.end(), cup.chunks.begin(), cup.chunks.end());
    revisions.emplace_back(cup.revision);
  }
  EXPECT_TRUE(take(assembler, chunks).empty());
  EXPECT_EQ(take(assembler, revisions).size(), ObjectAssembler::kObjects);
  EXPECT_GE(ObjectAssembler::kObjects, 32u);
}

// The largest grids, of objects that come one after the other: the octets of all are bounded, those heard of last stay.
TEST(ObjectAssembler, ForgetsObjectsRatherThanHoldTooMuch) {
  voxel::OccupancyGrid grid(testing::geometry({512, 512, 512}, 0.004));
  std::fill(grid.occupied().begin(), grid.occupied().end(), 0);
  const std::size_t octets = kMostVoxelChunks * sizeof(VoxelChunk);
  const std::size_t fit = ObjectAssembler::kMostOctets / octets;
  const auto name = [](std::size_t n) { return "hall" + std::to_string(n); };
  ObjectOnWire hall = ObjectSplitter().split("hall", grid);
  ObjectAssembler assembler;
  for (std::size_t n = 0; n <= fit; ++n)
    for (msg::ObjectChunk& chunk : hall.chunks) {
      chunk.object_id(name(n));
      EXPECT_TRUE(assembler.take(chunk).empty());
    }
  hall.revision.object_id(name(fit));
  EXPECT_EQ(assembler.take(hall.revision).size(), 1u);
  hall.revision.object_id(name(1));
  EXPECT_EQ(assembler.take(hall.revision).size(), 1u);
  hall.revision.object_id(name(0));
  EXPECT_TRUE(assembler.take(hall.revision).empty());
}

TEST(ObjectAssembler, OldVersionsOfAChunkAndOldRevisionsGo) {
  ObjectSplitter splitter;
  std::vector<ObjectOnWire> revisions;
  for (std::uint32_t n = 0; n <= 4; ++n) revisions.push_back(splitter.split("bunny", random_grid({20, 20, 20}, n, n)));
  ObjectAssembler chunks_first;
  for (const ObjectOnWire& r : revisions) take(chunks_first, {r.chunks[0]});
  EXPECT_TRUE(take(chunks_first, {revisions[0].revision}).empty());
  EXPECT_EQ(take(chunks_first, {revisions[1].revision}).size(), 1u);
  ObjectAssembler headers_first;
  for (const ObjectOnWire& r : revisions) take(headers_first, {r.revision});
  EXPECT_TRUE(take(headers_first, {revisions[0].chunks[0]}).empty());
  EXPECT_EQ(take(headers_first, {revisions[1].chunks[0]}).size(), 1u);
}

TEST(ObjectAssembler, ChunksThatNoRevisionNamesAreBounded) {
  ObjectAssembler assembler;
  ObjectSplitter splitter;
  VoxelChunk words{};
  std::size_t octets = 0, refused = 0;
  for (std::uint64_t version = 1; version <= ObjectAssembler::kVersions && !refused; ++version) {
    words[0] = version;
    voxel::OccupancyGrid grid(testing::geometry({8, 8, 8}));
    write_chunk(words, 0, grid);
    msg::ObjectChunk chunk = ObjectSplitter().split("bunny", grid).chunks[0];
    for (std::uint32_t index = 0; index < kMostVoxelChunks && !refused; ++index) {
      chunk.index(index);
      octets += sizeof(VoxelChunk);
      try {
        assembler.take(chunk);
      } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::bad_size);
        ++refused;
      }
    }
  }
  EXPECT_EQ(refused, 1u);
  EXPECT_LE(octets, ObjectAssembler::kMostWaiting + sizeof(VoxelChunk));
  EXPECT_GT(octets, 2 * kMostVoxelChunks * sizeof(VoxelChunk));  // a whole grid of 512 voxels a side, and the next
  // And goes on.
  const voxel::OccupancyGrid grid = random_grid({140, 66, 82}, 1);
  EXPECT_EQ(take(assembler, samples(splitter.split("bunny", grid))).size(), 1u);
}

}  // namespace
}  // namespace periplus::wire
