#include "services/nbv_planner/tool/canvas.h"

#include <cairo.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "common/core/error.h"
#include "common/core/file.h"

namespace periplus::nbv {
namespace {

class CanvasTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const char* name) const { return (folder_ / name).string(); }
  static void draw(Canvas& c) {
    c.fill({{10, 10}, {30, 10}, {30, 30}, {10, 30}}, {1, 0, 0});
    c.line({{0, 40}, {60, 40}}, {0, 0, 1}, 4);
    ImageU8 image(2, 1, 4, 255);
    image.at(0, 0, 0) = image.at(0, 0, 1) = 0;   // blue, then nothing
    image.at(1, 0, 3) = 0;
    c.image(image, 40, 0, 20, 10, true);
    c.text(5, 58, "text", 10);
    c.save();
  }
  const std::filesystem::path folder_ = std::filesystem::temp_directory_path() / ("periplus_canvas_test_" + std::to_string(::getpid()));
};

TEST_F(CanvasTest, APngHasWhatWasDrawnWhereItWasDrawn) {
  Canvas canvas(file("a.png"), 60, 60);
  draw(canvas);
  cairo_surface_t* read = cairo_image_surface_create_from_png(file("a.png").c_str());
  ASSERT_EQ(cairo_surface_status(read), CAIRO_STATUS_SUCCESS);
  ASSERT_EQ(cairo_image_surface_get_width(read), 60);
  const auto pixel = [&](int x, int y) {
    return *reinterpret_cast<const std::uint32_t*>(cairo_image_surface_get_data(read) + y * cairo_image_surface_get_stride(read) + 4 * x) & 0xffffff;
  };
  EXPECT_EQ(pixel(20, 20), 0xff0000u);
  EXPECT_EQ(pixel(35, 20), 0xffffffu);
  EXPECT_EQ(pixel(50, 40), 0x0000ffu);
  EXPECT_EQ(pixel(45, 5), 0x0000ffu);
  EXPECT_EQ(pixel(55, 5), 0xffffffu);
  bool ink = false;
  for (int x = 5; x < 30; ++x)
    for (int y = 48; y < 58; ++y) ink |= pixel(x, y) != 0xffffff;
  EXPECT_TRUE(ink);
  cairo_surface_destroy(read);
}

TEST_F(CanvasTest, TheSameDrawingIsTheSameFile) {
  std::string bytes[2];
  for (std::string& b : bytes) {
    Canvas canvas(file("x.png"), 60, 60);
    draw(canvas);
    b = read_file(file("x.png"));
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  Canvas canvas(file("x.svg"), 60, 60);
  draw(canvas);
  const std::string svg = read_file(file("x.svg"));
  EXPECT_EQ(svg.find("<?xml"), 0u);
  EXPECT_NE(svg.find("rgb(100%,0%,0%)"), std::string::npos);
}

TEST_F(CanvasTest, RefusesOtherEndingsAndFoldersThatAreNotThere) {
  for (const auto& [name, code] : {std::pair{"a.jpg", ErrorCode::bad_input}, {"absent/a.png", ErrorCode::io}}) {
    try {
      Canvas canvas(file(name), 10, 10);
      ADD_FAILURE() << name;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), code);
    }
  }
}

TEST(Viridis, GetsBrighterAllTheWay) {
  double before = -1;
  for (int i = 0; i <= 100; ++i) {
    const Colour c = viridis(i / 100.0);
    const double bright = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    EXPECT_GT(bright, before);
    before = bright;
  }
  EXPECT_EQ(viridis(-1).r, viridis(0).r);
  EXPECT_EQ(viridis(2).r, viridis(1).r);
}

}  // namespace
}  // namespace periplus::nbv
