// Triangles as a binary little-endian PLY file.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace periplus {

// `colors` (rgb, one a vertex) may be empty; `comment`, one line, too.
std::string encode_ply(std::span<const Eigen::Vector3f> vertices, std::span<const std::array<std::uint8_t, 3>> colors,
                       std::span<const std::array<std::uint32_t, 3>> triangles, std::string_view comment = {});

}  // namespace periplus
