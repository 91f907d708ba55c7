#include "services/supervisor/model_view.h"

#include <gtest/gtest.h>

#include "common/mesh/triangle_mesh.h"

namespace periplus::supervisor {
namespace {

TEST(ModelView, ShowsTheNearSideAndLeavesTheGroundWhite) {
  mesh::TriangleMesh box = mesh::make_box({1, 1, 1}, 1);
  const std::string path = testing::TempDir() + "/model_view_test.ply";
  mesh::write_ply(box, path);
  const std::vector<ModelView> views = model_views(path, 64);
  ASSERT_EQ(views.size(), 5u);
  const ImageU8& above = views[4].image;
  EXPECT_EQ(above.at(0, 0), 250);
  EXPECT_LT(above.at(32, 32), 250);
  // From above the unit box is a square of 0.92 * 64 / sqrt(3) = 34 pixels a side.
  int width = 0;
  for (int x = 0; x < 64; ++x) width += above.at(x, 32) != 250;
  EXPECT_NEAR(width, 34, 2);
}

TEST(ModelView, NoFileNoPicture) { EXPECT_TRUE(model_views("/no/such/model.ply", 64).empty()); }

}  // namespace
}  // namespace periplus::supervisor
