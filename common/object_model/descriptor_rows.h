// Many descriptors of one kind, packed so that each is quickly compared with all of another set.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/object_model/descriptor.h"
#include "common/voxel/visibility.h"

namespace periplus::object_model {

class DescriptorRows {
 public:
  explicit DescriptorRows(DescriptorKind kind) : kind_(kind) {}
  DescriptorKind kind() const { return kind_; }
  std::size_t size() const { return size_; }

  // Throws Error(bad_size) for another number of octets than the kind has.
  void add(std::span<const std::uint8_t> descriptor);

  // How far own descriptor i is from each of `other`, of the same kind: squared distance of octets, or number of differing bits, as
  // descriptor_distance() takes them. Whole numbers, the same for any `simd`.
  void compare(std::size_t i, const DescriptorRows& other, std::vector<std::uint32_t>& apart,
               voxel::Simd simd = voxel::Simd::best) const;

 private:
  DescriptorKind kind_;
  std::size_t size_ = 0;
  std::vector<std::int16_t> numbers_;   // of octets compared by value
  std::vector<std::uint64_t> words_;    // of bits, filled up with zeros
};

}  // namespace periplus::object_model
