// Descriptors of visual features: what they are, and how far apart two of one kind are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace periplus::object_model {

// Numbers are stored and sent.
enum class DescriptorKind : std::uint8_t {
  root_sift = 0,  // 128 octets: 512 times RootSIFT (Arandjelovic and Zisserman 2012)
  surf = 1,       // 64 octets: 128 plus 256 times SURF (Bay 2008)
  akaze = 2,      // 61 octets: 486 bits of M-LDB (Alcantarilla 2013)
  orb = 3,        // 32 octets: 256 bits of rBRIEF (Rublee 2011)
};

const char* to_string(DescriptorKind kind);
// Nothing for a number that is no kind.
std::optional<DescriptorKind> descriptor_kind(std::uint32_t number);

std::size_t descriptor_octets(DescriptorKind kind);
// Of bits, compared by the number of those that differ.
bool is_binary(DescriptorKind kind);

// Euclidean distance of descriptors of length 1 (root_sift, surf: 0..2); share of the octets' bits that differ (akaze, orb: 0..1).
// Throws Error(bad_size) unless both have their kind's octets.
double descriptor_distance(DescriptorKind kind, std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);

// The same from whole numbers, for those who compare many: squared distance of octets, or number of differing bits.
double descriptor_distance(DescriptorKind kind, std::uint32_t octets_apart);

}  // namespace periplus::object_model
