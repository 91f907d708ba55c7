#include "services/vision_server/captured_view.h"

#include <gtest/gtest.h>

#include <thread>

namespace periplus::vision {
namespace {

using Part = ViewCollector::Part;
using namespace std::chrono_literals;

void add_all_but_right(ViewCollector& c, std::int64_t stamp) {
  c.add_image(Part::left, stamp, ImageU8(2, 2, 1, static_cast<std::uint8_t>(stamp)));
  c.add_calibration(Part::left_calibration, stamp, {});
  c.add_calibration(Part::right_calibration, stamp, {});
  c.add_joints(stamp, {{"neck", 0.1}});
  c.add_base_pose(stamp, Pose(Eigen::Translation3d(1, 2, 3)));
}

TEST(ViewCollector, IsCompleteWhenEveryPartOfThatStampIsThere) {
  ViewCollector c(0);
  add_all_but_right(c, 50);
  EXPECT_FALSE(c.wait(50, 1ms));
  EXPECT_EQ(c.missing(50), "right image");
  c.add_image(Part::right, 51, ImageU8(2, 2, 1, 9));  // another instant
  EXPECT_FALSE(c.wait(50, 1ms));
  c.add_image(Part::right, 50, ImageU8(2, 2, 1, 8));
  const auto view = c.wait(50, 1ms);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->stamp_ns, 50);
  EXPECT_EQ(view->left.at(0, 0), 50);
  EXPECT_EQ(view->right.at(0, 0), 8);
  EXPECT_EQ(view->joints.at(0).first, "neck");
  EXPECT_EQ(view->X_WB.translation().z(), 3);
}

TEST(ViewCollector, WithToleranceTheNearestReadingCounts) {
  ViewCollector c(5);
  add_all_but_right(c, 50);
  c.add_image(Part::right, 44, ImageU8(1, 1, 1, 44));
  EXPECT_FALSE(c.wait(50, 1ms));
  c.add_image(Part::right, 45, ImageU8(1, 1, 1, 45));
  c.add_image(Part::right, 52, ImageU8(1, 1, 1, 52));
  ASSERT_TRUE(c.wait(50, 1ms));
  EXPECT_EQ(c.wait(50, 1ms)->right.at(0, 0), 52);
}

TEST(ViewCollector, WakesUpWhenTheLastPartArrives) {
  ViewCollector c(0);
  add_all_but_right(c, 7);
  std::thread late([&] {
    std::this_thread::sleep_for(20ms);
    c.add_image(Part::right, 7, ImageU8(1, 1));
  });
  EXPECT_TRUE(c.wait(7, 10s));
  late.join();
}

TEST(ViewCollector, OldReadingsAreForgottenAndFaultsRemembered) {
  ViewCollector c(0);
  add_all_but_right(c, 1);
  c.add_image(Part::right, 1, ImageU8(1, 1));
  ASSERT_TRUE(c.wait(1, 1ms));
  for (std::int64_t stamp = 2; stamp < 12; ++stamp) c.add_image(Part::right, stamp, ImageU8(1, 1));
  EXPECT_FALSE(c.wait(1, 1ms));
  EXPECT_EQ(c.fault(), "");
  c.add_fault("right image: truncated");
  EXPECT_EQ(c.fault(), "right image: truncated");
  c.clear_faults();
  EXPECT_EQ(c.fault(), "");
}

TEST(ViewStore, KeepsTheLastViews) {
  ViewStore store(2);
  CapturedView v;
  for (std::int64_t i = 0; i < 3; ++i) {
    v.stamp_ns = i;
    store.put("view" + std::to_string(i), v);
  }
  EXPECT_EQ(store.find("view0"), nullptr);
  ASSERT_NE(store.find("view1"), nullptr);
  EXPECT_EQ(store.find("view2")->stamp_ns, 2);
  store.put("view1", v);  // known again: now the newest
  store.put("view3", v);
  EXPECT_EQ(store.find("view2"), nullptr);
  EXPECT_NE(store.find("view1"), nullptr);
}

}  // namespace
}  // namespace periplus::vision
