#include "common/geometry/ply.h"

#include <bit>

namespace periplus {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");

template <class T>
void append(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::string encode_ply(std::span<const Eigen::Vector3f> vertices, std::span<const std::array<std::uint8_t, 3>> colors,
                       std::span<const std::array<std::uint32_t, 3>> triangles, std::string_view comment) {
  std::string out = "ply\nformat binary_little_endian 1.0\n";
  if (!comment.empty()) out += "comment " + std::string(comment) + "\n";
  out += "element vertex " + std::to_string(vertices.size()) + "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!colors.empty()) out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  out += "element face " + std::to_string(triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  out.reserve(out.size() + 15 * vertices.size() + 13 * triangles.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    for (int n = 0; n < 3; ++n) append(out, vertices[i][n]);
    if (!colors.empty())
      for (const std::uint8_t c : colors[i]) append(out, c);
  }
  for (const auto& triangle : triangles) {
    append(out, std::uint8_t{3});
    for (const std::uint32_t v : triangle) append(out, static_cast<std::int32_t>(v));
  }
  return out;
}

}  // namespace periplus
