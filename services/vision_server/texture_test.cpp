#include "services/vision_server/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::vision {
namespace {

ImageU8 drawn(const std::function<double(int, int)>& grey, double noise, std::uint64_t seed) {
  Random random(seed);
  ImageU8 out(320, 240);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) out.at(x, y) = static_cast<std::uint8_t>(std::clamp(std::lround(grey(x, y) + noise * random.normal()), 0l, 255l));
  return out;
}

double share(const ImageU8& mask) {
  std::size_t n = 0;
  for (const auto v : mask.data) n += v != 0;
  return static_cast<double>(n) / static_cast<double>(mask.data.size());
}

double plain(int, int) { return 128; }
double shaded(int x, int y) { return 60 + 0.4 * x + 0.2 * y; }
double stripes(int x, int) { return 128 + 40 * std::sin(0.5 * x); }
double waves(int x, int y) { return 128 + 20 * std::sin(0.5 * x + 0.1 * y) + 20 * std::sin(0.4 * y - 0.15 * x); }

TEST(Texture, NoiseIsTold) {
  for (const double noise : {1.0, 2.0, 3.0}) {
    EXPECT_NEAR(noise_of(drawn(plain, noise, 1)), noise, 0.2 * noise);
    EXPECT_NEAR(noise_of(drawn(shaded, noise, 2)), noise, 0.2 * noise);
    // Half of the picture tells it.
    EXPECT_NEAR(noise_of(drawn([](int x, int y) { return x < 160 ? 128.0 : waves(x, y); }, noise, 3)), noise, 0.25 * noise);
  }
  EXPECT_EQ(noise_of(drawn(plain, 0, 1)), 0.5);
  EXPECT_EQ(noise_of(ImageU8(8, 8)), 0.5);
}

TEST(Texture, NoiseAndShadingAreNone) {
  for (const double noise : {1.0, 2.0, 3.0}) {
    EXPECT_LT(share(textured_pixels(drawn(plain, noise, 1), noise, {})), 0.01);
    EXPECT_LT(share(textured_pixels(drawn(shaded, noise, 1), noise, {})), 0.01);
  }
}

TEST(Texture, GreyLevelsMustChangeInEveryDirection) {
  EXPECT_LT(share(textured_pixels(drawn(stripes, 1, 1), 1, {})), 0.03);
  EXPECT_GT(share(textured_pixels(drawn(waves, 2, 1), 2, {})), 0.95);
}

// Two plane waves at right angles, of wave number k and amplitude a: both eigenvalues are the gradient's mean square,
// a^2 / 2 (sin k)^2, as Sobel's central difference sees it.
TEST(Texture, TheThresholdIsInGradients) {
  const double k = 2 * M_PI / 7;  // whole waves in a window
  const auto with = [&](double a) { return drawn([&](int x, int y) { return 128 + a * std::sin(k * x) + a * std::sin(k * y); }, 0, 1); };
  TextureSettings s;
  const double noise = 4, limit = std::sqrt(2 * s.above_noise * 12 / 64.0 * noise * noise) / std::sin(k);
  EXPECT_LT(share(textured_pixels(with(0.93 * limit), noise, s)), 0.05);
  EXPECT_GT(share(textured_pixels(with(1.07 * limit), noise, s)), 0.95);
}

TEST(Texture, SettingsOutOfRangeAreRefused) {
  TextureSettings s;
  s.window_px = 4;
  EXPECT_THROW(textured_pixels(ImageU8(20, 20), 1, s), Error);
  s = {};
  s.least_share = 1.1;
  EXPECT_THROW(s.check(), Error);
  s = {};
  s.above_noise = 0;
  EXPECT_THROW(s.check(), Error);
}

}  // namespace
}  // namespace periplus::vision
