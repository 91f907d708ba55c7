#include "common/geometry/ply.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

namespace periplus {
namespace {

TEST(Ply, HeaderAndNumbersStandAsTheFormatSays) {
  const std::vector<Eigen::Vector3f> vertices{{0, 0, 0}, {1, 0, 0}, {0, 2.5f, 0}};
  const std::vector<std::array<std::uint8_t, 3>> colors{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}};
  const std::string ply = encode_ply(vertices, colors, triangles, "metres");
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment metres\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  ASSERT_EQ(ply.substr(0, header.size()), header);
  ASSERT_EQ(ply.size(), header.size() + 3 * 15 + 13);
  float y = 0;
  std::memcpy(&y, ply.data() + header.size() + 2 * 15 + 4, 4);
  EXPECT_EQ(y, 2.5f);
  EXPECT_EQ(ply[header.size() + 2 * 15 + 12], 7);
  EXPECT_EQ(ply.substr(header.size() + 45), std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13));
  const std::string plain = encode_ply(vertices, {}, triangles);
  EXPECT_EQ(plain.find("uchar red"), std::string::npos);
  EXPECT_EQ(plain.find("comment"), std::string::npos);
}

}  // namespace
}  // namespace periplus
