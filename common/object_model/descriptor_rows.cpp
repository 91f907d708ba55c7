#include "common/object_model/descriptor_rows.h"

#include <array>
#include <bit>
#include <cstring>

#include "common/core/error.h"
#include "common/voxel/simd_function.h"

namespace periplus::object_model {

namespace {

constexpr std::size_t kWords = 8;  // enough for the longest descriptor of bits

PERIPLUS_INLINE std::uint32_t square_apart(const std::int16_t* a, const std::int16_t* b, std::int32_t n) {
  std::int32_t sum = 0;
  for (std::int32_t k = 0; k < n; ++k) {
    const auto d = static_cast<std::int16_t>(a[k] - b[k]);
    sum += d * d;
  }
  return static_cast<std::uint32_t>(sum);
}

// Row by row of n = 128 or 64 numbers.
PERIPLUS_INLINE void squares_body(const std::int16_t* a, const std::int16_t* rows, std::size_t count, std::int32_t n, std::uint32_t* apart) {
  if (n == 128) {
    for (std::size_t j = 0; j < count; ++j) apart[j] = square_apart(a, rows + 128 * j, 128);
  } else {
    for (std::size_t j = 0; j < count; ++j) apart[j] = square_apart(a, rows + 64 * j, 64);
  }
}
PERIPLUS_SIMD_FUNCTION(void, squares, (const std::int16_t* a, const std::int16_t* rows, std::size_t count, std::int32_t n, std::uint32_t* apart),
                       (a, rows, count, n, apart))

}  // namespace

void DescriptorRows::add(std::span<const std::uint8_t> descriptor) {
  require(descriptor.size() == descriptor_octets(kind_), ErrorCode::bad_size, "a descriptor has another number of octets than its kind");
  ++size_;
  if (!is_binary(kind_)) {
    numbers_.insert(numbers_.end(), descriptor.begin(), descriptor.end());
    return;
  }
  std::array<std::uint64_t, kWords> words{};
  std::memcpy(words.data(), descriptor.data(), descriptor.size());
  words_.insert(words_.end(), words.begin(), words.end());
}

void DescriptorRows::compare(std::size_t i, const DescriptorRows& other, std::vector<std::uint32_t>& apart, voxel::Simd simd) const {
  require(kind_ == other.kind_ && i < size_, ErrorCode::bad_input, "descriptors of two kinds cannot be compared");
  apart.resize(other.size_);
  if (!is_binary(kind_)) {
    const std::size_t n = kind_ == DescriptorKind::root_sift ? 128 : 64;
    squares_for(simd)(&numbers_[i * n], other.numbers_.data(), apart.size(), static_cast<std::int32_t>(n), apart.data());
    return;
  }
  const std::uint64_t* a = &words_[i * kWords];
  for (std::size_t j = 0; j < apart.size(); ++j) {
    const std::uint64_t* b = &other.words_[j * kWords];
    int sum = 0;
    for (std::size_t k = 0; k < kWords; ++k) sum += std::popcount(a[k] ^ b[k]);
    apart[j] = static_cast<std::uint32_t>(sum);
  }
}

}  // namespace periplus::object_model
