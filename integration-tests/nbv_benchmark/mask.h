// A set of numbered things (surface samples, voxels) as bits.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace periplus::nbv_benchmark {

class Mask {
 public:
  Mask() = default;
  explicit Mask(std::size_t size) : size_(size), words_((size + 63) / 64, 0) {}

  std::size_t size() const { return size_; }
  void set(std::size_t i) { words_[i / 64] |= std::uint64_t{1} << i % 64; }
  bool test(std::size_t i) const { return words_[i / 64] >> i % 64 & 1; }
  std::size_t count() const {
    std::size_t n = 0;
    for (const std::uint64_t w : words_) n += static_cast<std::size_t>(std::popcount(w));
    return n;
  }
  Mask& operator|=(const Mask& other) {
    for (std::size_t w = 0; w < words_.size(); ++w) words_[w] |= other.words_[w];
    return *this;
  }
  // |this and other|, |this less other|.
  std::size_t in_common(const Mask& other) const {
    std::size_t n = 0;
    for (std::size_t w = 0; w < words_.size(); ++w) n += static_cast<std::size_t>(std::popcount(words_[w] & other.words_[w]));
    return n;
  }
  std::size_t beyond(const Mask& other) const { return count() - in_common(other); }
  bool operator==(const Mask&) const = default;

 private:
  std::size_t size_ = 0;
  std::vector<std::uint64_t> words_;
};

// |covered and of| / |of|; 1 where there is nothing to cover.
inline double share(const Mask& covered, const Mask& of) {
  const std::size_t n = of.count();
  return n == 0 ? 1.0 : static_cast<double>(covered.in_common(of)) / static_cast<double>(n);
}

}  // namespace periplus::nbv_benchmark
