#include "common/object_model/descriptor_rows.h"

#include <array>
#include <bit>
#include <cstring>

#include "common/core/error.h"

namespace periplus::object_model {

namespace {

constexpr std::size_t kWords = 8;  // enough for the longest descriptor of bits

template <std::size_t n>
void squares_apart(const std::int16_t* a, const std::vector<std::int16_t>& rows, std::vector<std::uint32_t>& apart) {
  for (std::size_t j = 0; j < apart.size(); ++j) {
    const std::int16_t* b = &rows[j * n];
    std::int32_t sum = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const auto d = static_cast<std::int16_t>(a[k] - b[k]);
      sum += d * d;
    }
    apart[j] = static_cast<std::uint32_t>(sum);
  }
}

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

void DescriptorRows::compare(std::size_t i, const DescriptorRows& other, std::vector<std::uint32_t>& apart) const {
  require(kind_ == other.kind_ && i < size_, ErrorCode::bad_input, "descriptors of two kinds cannot be compared");
  apart.resize(other.size_);
  if (kind_ == DescriptorKind::root_sift) return squares_apart<128>(&numbers_[i * 128], other.numbers_, apart);
  if (kind_ == DescriptorKind::surf) return squares_apart<64>(&numbers_[i * 64], other.numbers_, apart);
  const std::uint64_t* a = &words_[i * kWords];
  for (std::size_t j = 0; j < apart.size(); ++j) {
    const std::uint64_t* b = &other.words_[j * kWords];
    int sum = 0;
    for (std::size_t k = 0; k < kWords; ++k) sum += std::popcount(a[k] ^ b[k]);
    apart[j] = static_cast<std::uint32_t>(sum);
  }
}

}  // namespace periplus::object_model
