#include "common/object_model/descriptor.h"

#include <bit>
#include <cmath>

#include "common/core/error.h"

namespace periplus::object_model {

const char* to_string(DescriptorKind kind) {
  switch (kind) {
    case DescriptorKind::root_sift: return "root_sift";
    case DescriptorKind::surf: return "surf";
    case DescriptorKind::akaze: return "akaze";
    case DescriptorKind::orb: break;
  }
  return "orb";
}

std::optional<DescriptorKind> descriptor_kind(std::uint32_t number) {
  if (number > static_cast<std::uint32_t>(DescriptorKind::orb)) return std::nullopt;
  return static_cast<DescriptorKind>(number);
}

std::size_t descriptor_octets(DescriptorKind kind) {
  switch (kind) {
    case DescriptorKind::root_sift: return 128;
    case DescriptorKind::surf: return 64;
    case DescriptorKind::akaze: return 61;
    case DescriptorKind::orb: break;
  }
  return 32;
}

bool is_binary(DescriptorKind kind) { return kind == DescriptorKind::akaze || kind == DescriptorKind::orb; }

double descriptor_distance(DescriptorKind kind, std::uint32_t apart) {
  if (is_binary(kind)) return apart / (8.0 * static_cast<double>(descriptor_octets(kind)));
  return std::sqrt(static_cast<double>(apart)) / (kind == DescriptorKind::surf ? 256 : 512);
}

double descriptor_distance(DescriptorKind kind, std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  require(a.size() == descriptor_octets(kind) && b.size() == a.size(), ErrorCode::bad_size, "descriptors to be compared must have their kind's number of octets");
  std::uint32_t apart = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const int d = static_cast<int>(a[i]) - static_cast<int>(b[i]);
    apart += is_binary(kind) ? static_cast<std::uint32_t>(std::popcount(static_cast<std::uint8_t>(a[i] ^ b[i]))) : static_cast<std::uint32_t>(d * d);
  }
  return descriptor_distance(kind, apart);
}

}  // namespace periplus::object_model
