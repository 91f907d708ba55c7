// The samples of one brick of a signed distance field (tsdf.h), and the same in less memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/voxel/brick_field.h"

namespace periplus::object_model {

struct TsdfSample {
  float distance = 0;              // mean truncated distance [m]
  float weight = 0;                // 0: never seen
  float r = 0, g = 0, b = 0;       // mean colour, 0..255
  float color_weight = 0;
  bool operator==(const TsdfSample&) const = default;
};

// In the order of the grid's planes.
using TsdfBrick = std::array<TsdfSample, voxel::kBrickVoxels>;

// Dictionary coding, lossless: the distinct samples, and of each voxel its place among them. Voxels away from the surface share very few:
// never seen, or seen to be free by so many depth maps.
class PackedTsdfBrick {
 public:
  // 512 times TsdfSample{}.
  PackedTsdfBrick() : distinct_(1) {}
  explicit PackedTsdfBrick(const TsdfBrick& samples);
  // From distinct() and words(). Throws Error(bad_size | bad_input) unless they fit each other.
  PackedTsdfBrick(std::vector<TsdfSample> distinct, std::vector<std::uint64_t> words);

  TsdfSample at(int voxel) const;
  void unpack(TsdfBrick& samples) const;

  // 1 to 512; of samples packed here in the order of their first voxels, no two of the same bits.
  const std::vector<TsdfSample>& distinct() const { return distinct_; }
  // The voxels' places among them, the first in the lowest bits, with as many bits each as the greatest needs: 1, 2, 4, 8 or 16; no word
  // where all samples are one.
  const std::vector<std::uint64_t>& words() const { return words_; }
  static std::size_t word_count(std::size_t distinct);

 private:
  std::vector<TsdfSample> distinct_;
  std::vector<std::uint64_t> words_;
};

}  // namespace periplus::object_model
