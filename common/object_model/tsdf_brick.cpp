#include "common/object_model/tsdf_brick.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "common/core/error.h"

namespace periplus::object_model {

namespace {

constexpr std::size_t kSlots = 2 * voxel::kBrickVoxels;
constexpr std::uint16_t kNoPlace = 0xffff;

static_assert(sizeof(TsdfSample) == 6 * sizeof(float));

bool same_bits(const TsdfSample& a, const TsdfSample& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Of all its bits: a file may hold bricks of which the colours alone differ.
std::size_t slot(const TsdfSample& s) {
  const auto words = std::bit_cast<std::array<std::uint64_t, 3>>(s);
  constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15u;
  const std::uint64_t bits = ((words[0] * kGolden ^ std::rotl(words[1], 23)) * kGolden ^ std::rotl(words[2], 47)) * kGolden;
  return ((bits ^ bits >> 32) * kGolden) >> (64 - std::countr_zero(kSlots));
}

// Of one place; a power of two, so that none lies in two words.
std::size_t place_bits(std::size_t distinct) { return distinct > 1 ? std::bit_ceil(static_cast<std::size_t>(std::bit_width(distinct - 1))) : 0; }

// Calls visit(voxel, place) for all voxels in order.
template <class Visit>
void for_each_place(std::size_t distinct, const std::vector<std::uint64_t>& words, Visit&& visit) {
  const std::size_t bits = place_bits(distinct);
  if (bits == 0) {
    for (std::size_t i = 0; i < voxel::kBrickVoxels; ++i) visit(i, std::size_t{0});
    return;
  }
  const std::uint64_t mask = (1u << bits) - 1;
  std::size_t i = 0;
  for (std::uint64_t word : words) {
    for (std::size_t n = 0; n < 64 / bits; ++n, word >>= bits) visit(i++, static_cast<std::size_t>(word & mask));
  }
}

}  // namespace

std::size_t PackedTsdfBrick::word_count(std::size_t distinct) { return voxel::kBrickVoxels / 64 * place_bits(distinct); }

PackedTsdfBrick::PackedTsdfBrick(const TsdfBrick& samples) {
  std::array<std::uint16_t, kSlots> slots;  // of a hash table: places, looked for from the sample's slot on
  slots.fill(kNoPlace);
  std::array<std::uint16_t, voxel::kBrickVoxels> first, places;  // of each place its first voxel; of each voxel its place
  std::size_t n = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0 && same_bits(samples[i], samples[i - 1])) {
      places[i] = places[i - 1];
      continue;
    }
    std::size_t at = slot(samples[i]);
    while (slots[at] != kNoPlace && !same_bits(samples[first[slots[at]]], samples[i])) at = (at + 1) % kSlots;
    if (slots[at] == kNoPlace) {
      first[n] = static_cast<std::uint16_t>(i);
      slots[at] = static_cast<std::uint16_t>(n++);
    }
    places[i] = slots[at];
  }
  distinct_.reserve(n);
  for (std::size_t p = 0; p < n; ++p) distinct_.push_back(samples[first[p]]);
  words_.resize(word_count(n));
  if (const std::size_t bits = place_bits(n); bits > 0) {
    for (std::size_t i = 0; i < places.size(); ++i) words_[i * bits / 64] |= static_cast<std::uint64_t>(places[i]) << i * bits % 64;
  }
}

PackedTsdfBrick::PackedTsdfBrick(std::vector<TsdfSample> distinct, std::vector<std::uint64_t> words) : distinct_(std::move(distinct)), words_(std::move(words)) {
  require(!distinct_.empty() && distinct_.size() <= voxel::kBrickVoxels, ErrorCode::bad_size, "a brick of signed distances has 1 to 512 distinct samples");
  require(words_.size() == word_count(distinct_.size()), ErrorCode::bad_size, "a brick of signed distances has no place for each of its voxels");
  bool there = true;
  for_each_place(distinct_.size(), words_, [&](std::size_t, std::size_t place) { there &= place < distinct_.size(); });
  require(there, ErrorCode::bad_input, "a voxel names a signed distance which its brick has not");
}

TsdfSample PackedTsdfBrick::at(int voxel) const {
  const std::size_t bits = place_bits(distinct_.size()), bit = static_cast<std::size_t>(voxel) * bits;
  return distinct_[bits == 0 ? 0 : words_[bit / 64] >> bit % 64 & ((1u << bits) - 1)];
}

void PackedTsdfBrick::unpack(TsdfBrick& samples) const {
  for_each_place(distinct_.size(), words_, [&](std::size_t i, std::size_t place) { samples[i] = distinct_[place]; });
}

}  // namespace periplus::object_model
