#include "common/object_model/tsdf_brick.h"

#include <gtest/gtest.h>

#include <cstring>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::object_model {
namespace {

// `distinct` different samples, in no order, each at least once.
TsdfBrick random_brick(Random& random, std::size_t distinct) {
  std::vector<TsdfSample> samples;
  for (std::size_t n = 0; n < distinct; ++n) {
    TsdfSample s{static_cast<float>(random.uniform(-0.03, 0.03)), static_cast<float>(n), 0, 0, 0, 0};
    if (n % 3 == 0) s.r = static_cast<float>(random.uniform(0, 255)), s.color_weight = 1;
    samples.push_back(s);
  }
  TsdfBrick brick;
  for (std::size_t i = 0; i < brick.size(); ++i) brick[i] = samples[i < distinct ? i : random.below(distinct)];
  for (std::size_t i = brick.size() - 1; i > 0; --i) std::swap(brick[i], brick[random.below(i + 1)]);
  return brick;
}

bool same_octets(const TsdfBrick& a, const TsdfBrick& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST(PackedTsdfBrick, GivesBackEveryBit) {
  Random random(5);
  for (const auto& [distinct, bits] : std::vector<std::pair<std::size_t, std::size_t>>{
           {1, 0}, {2, 1}, {3, 2}, {4, 2}, {5, 4}, {16, 4}, {17, 8}, {100, 8}, {256, 8}, {257, 16}, {511, 16}, {512, 16}}) {
    const TsdfBrick brick = random_brick(random, distinct);
    const PackedTsdfBrick packed(brick);
    EXPECT_EQ(packed.distinct().size(), distinct);
    EXPECT_EQ(packed.words().size(), 512 * bits / 64);
    EXPECT_EQ(packed.distinct().front(), brick.front());
    TsdfBrick back;
    packed.unpack(back);
    EXPECT_TRUE(same_octets(back, brick)) << distinct;
    for (int i = 0; i < voxel::kBrickVoxels; ++i) ASSERT_EQ(packed.at(i), brick[static_cast<std::size_t>(i)]) << distinct << ", voxel " << i;
    PackedTsdfBrick(packed.distinct(), packed.words()).unpack(back);
    EXPECT_TRUE(same_octets(back, brick)) << distinct;
  }
}

TEST(PackedTsdfBrick, TellsZerosOfBothSignsApart) {
  TsdfBrick brick{};
  for (std::size_t i = 0; i < brick.size(); i += 3) brick[i].distance = -0.0f;
  TsdfBrick back;
  PackedTsdfBrick(brick).unpack(back);
  EXPECT_TRUE(same_octets(back, brick));
}

// Colours alone differ.
TEST(PackedTsdfBrick, SamplesOfOneDistanceAndWeightStayApart) {
  TsdfBrick brick{};
  for (std::size_t i = 0; i < brick.size(); ++i) brick[i] = {0.01f, 1, static_cast<float>(i), 0, 0, 1};
  TsdfBrick back;
  PackedTsdfBrick(brick).unpack(back);
  EXPECT_TRUE(same_octets(back, brick));
}

TEST(PackedTsdfBrick, BeginsAsNeverSeen) {
  TsdfBrick back;
  back.fill({1, 1, 1, 1, 1, 1});
  PackedTsdfBrick().unpack(back);
  EXPECT_TRUE(same_octets(back, TsdfBrick{}));
}

TEST(PackedTsdfBrick, PartsThatDoNotFitAreRefused) {
  const std::vector<TsdfSample> three(3);
  std::vector<std::uint64_t> words(16, 0xaaaaaaaaaaaaaaaa);  // two bits each: place 2
  EXPECT_NO_THROW(PackedTsdfBrick(three, words));
  words[15] |= std::uint64_t{3} << 62;
  EXPECT_THROW(PackedTsdfBrick(three, words), Error);  // place 3
  words.assign(15, 0);
  EXPECT_THROW(PackedTsdfBrick(three, words), Error);
  words.assign(17, 0);
  EXPECT_THROW(PackedTsdfBrick(three, words), Error);
  EXPECT_THROW(PackedTsdfBrick({}, {}), Error);
  EXPECT_THROW(PackedTsdfBrick(std::vector<TsdfSample>(513), std::vector<std::uint64_t>(128)), Error);
}

}  // namespace
}  // namespace periplus::object_model
