#include "common/render/texture.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/core/error.h"

namespace periplus::render {
namespace {

TEST(Texture, SeedDecides) {
  const ImageU8 a = make_texture(256, 128, 7), b = make_texture(256, 128, 7), c = make_texture(256, 128, 8);
  EXPECT_EQ(a.data, b.data);
  EXPECT_NE(a.data, c.data);
  EXPECT_THROW(make_texture(0, 10, 1), Error);
  EXPECT_THROW(make_texture(10, 100000, 1), Error);
}

// Matching needs contrast everywhere: no 16 x 16 patch is flat.
TEST(Texture, NoFlatPatch) {
  const ImageU8 t = make_texture(512, 512, 3);
  int flat = 0, patches = 0;
  for (int y = 0; y < 512; y += 16)
    for (int x = 0; x < 512; x += 16, ++patches) {
      int low = 255, high = 0;
      for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i) {
          low = std::min<int>(low, t.at(x + i, y + j, 1));
          high = std::max<int>(high, t.at(x + i, y + j, 1));
        }
      flat += high - low < 8;
    }
  EXPECT_LT(flat, 0.02 * patches);  // within a large disc
}

TEST(Texture, BadPicturesAreRefused) {
  EXPECT_THROW(load_texture("/nowhere.png"), Error);
  const auto path = std::filesystem::temp_directory_path() / ("texture_test-" + std::to_string(getpid()) + ".png");
  std::ofstream(path) << "not a picture";
  EXPECT_THROW(load_texture(path), Error);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace periplus::render
