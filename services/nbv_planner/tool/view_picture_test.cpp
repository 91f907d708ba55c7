#include "services/nbv_planner/tool/view_picture.h"

#include <cairo.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

// Pixels of a PNG that are nearly of a colour.
int count_near(const std::string& file, const Colour& colour) {
  cairo_surface_t* read = cairo_image_surface_create_from_png(file.c_str());
  EXPECT_EQ(cairo_surface_status(read), CAIRO_STATUS_SUCCESS);
  int count = 0;
  for (int y = 0; y < cairo_image_surface_get_height(read); ++y) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(cairo_image_surface_get_data(read) + y * cairo_image_surface_get_stride(read));
    for (int x = 0; x < cairo_image_surface_get_width(read); ++x) {
      const auto off = [&](int shift, double c) { return std::abs(double(row[x] >> shift & 255) - 255 * c); };
      count += off(16, colour.r) < 6 && off(8, colour.g) < 6 && off(0, colour.b) < 6;
    }
  }
  cairo_surface_destroy(read);
  return count;
}

TEST(ViewPicture, ShowsTheChosenViewAndTheCandidatesInTheirColours) {
  const Situation s = testing::patch_at_plus_x();
  const Evaluator evaluator(s, {}, {});
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("periplus_view_picture_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  ViewPicture picture;
  picture.title = "title";
  picture.X_WC = look_at({1.2, 0.2, 1.2}, {0, 0, 1.1});
  picture.f_e = -200;
  const std::string bare = folder / "bare.png", full = folder / "full.png";
  draw_view(bare, evaluator, picture);
  for (int i = 0; i < 40; ++i)
    picture.candidates.push_back({look_at({1.5 * std::cos(i * 0.15), 1.5 * std::sin(i * 0.15), 1.2}, {0, 0, 1.1}), i % 2 ? -200.0 : 100.0, i != 7});
  draw_view(full, evaluator, picture);
  EXPECT_GT(count_near(bare, {0.84, 0.10, 0.16}), 200);
  EXPECT_GT(count_near(full, viridis(1)), count_near(bare, viridis(1)) + 100);  // the best
  EXPECT_GT(count_near(full, viridis(0)), count_near(bare, viridis(0)) + 100);  // the worst
  EXPECT_GT(count_near(bare, {0.38 * 0.98, 0.76 * 0.98, 0.36 * 0.98}) + count_near(bare, {0.38, 0.76, 0.36}), 200);  // unknown voxels
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace periplus::nbv
