#include "services/vision_server/captured_view.h"

#include <gtest/gtest.h>

#include <thread>

namespace periplus::vision {
namespace {

using Part = ViewCollector::Part;
using namespace std::chrono_literals;

constexpr auto kBegin = ViewCollector::Moment::begin;
constexpr std::int64_t kMillisecond = 1'000'000;

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
  EXPECT_FALSE(c.wait(50, kBegin, 1ms));
  EXPECT_EQ(c.missing(50, kBegin), "right image");
  c.add_image(Part::right, 51, ImageU8(2, 2, 1, 9));  // another instant
  EXPECT_FALSE(c.wait(50, kBegin, 1ms));
  c.add_image(Part::right, 50, ImageU8(2, 2, 1, 8));
  const auto view = c.wait(50, kBegin, 1ms);
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
  EXPECT_FALSE(c.wait(50, kBegin, 1ms));
  c.add_image(Part::right, 45, ImageU8(1, 1, 1, 45));
  c.add_image(Part::right, 52, ImageU8(1, 1, 1, 52));
  ASSERT_TRUE(c.wait(50, kBegin, 1ms));
  EXPECT_EQ(c.wait(50, kBegin, 1ms)->right.at(0, 0), 52);
}

TEST(ViewCollector, ImagesOfTwoExposuresAreNoPair) {
  ViewCollector c(50 * kMillisecond);
  const std::int64_t stamp = 1000 * kMillisecond;
  add_all_but_right(c, stamp);
  c.add_image(Part::right, stamp + 33 * kMillisecond, ImageU8(2, 2, 1, 1));
  EXPECT_FALSE(c.wait(stamp, kBegin, 1ms));
  EXPECT_EQ(c.missing(stamp, kBegin), "left and right image of one exposure (they are 0.033 s apart; have both cameras triggered together)");
  // Half a frame later there is a pair: farther away than the left image alone, but of one moment.
  c.add_image(Part::left, stamp + 33 * kMillisecond + 500'000, ImageU8(2, 2, 1, 2));
  const auto view = c.wait(stamp, kBegin, 1ms);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->left.at(0, 0), 2);
  EXPECT_EQ(view->right.at(0, 0), 1);
  EXPECT_EQ(c.missing(stamp, kBegin), "");
}

TEST(ViewCollector, WhatIsStaleIsSaidToBe) {
  ViewCollector c(kMillisecond);
  const std::int64_t stamp = 1000 * kMillisecond;
  add_all_but_right(c, stamp);
  c.add_image(Part::right, stamp - 250 * kMillisecond, ImageU8(2, 2));
  c.add_image(Part::right, stamp - 400 * kMillisecond, ImageU8(2, 2));
  EXPECT_FALSE(c.wait(stamp, kBegin, 1ms));
  EXPECT_EQ(c.missing(stamp, kBegin), "right image (the nearest that came is 0.25 s older)");
}

TEST(CheckSizes, AnImageOfAnotherSizeThanItsCameraInfoIsRefused) {
  CapturedView view;
  view.left = view.right = ImageU8(7, 5);
  for (CameraCalibration* c : {&view.left_calibration, &view.right_calibration}) {
    c->width = 7;
    c->height = 5;
  }
  EXPECT_NO_THROW(check_sizes(view));
  view.right = ImageU8(5, 7);
  try {
    check_sizes(view);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::vision_image_bad);
    EXPECT_NE(std::string(e.what()).find("the right image has 5 x 7 pixels, its camera info says 7 x 5"), std::string::npos);
  }
}

TEST(ViewCollector, WakesUpWhenTheLastPartArrives) {
  ViewCollector c(0);
  add_all_but_right(c, 7);
  std::thread late([&] {
    std::this_thread::sleep_for(20ms);
    c.add_image(Part::right, 7, ImageU8(1, 1));
  });
  EXPECT_TRUE(c.wait(7, kBegin, 10s));
  late.join();
}

TEST(ViewCollector, OldReadingsAreForgottenAndFaultsRemembered) {
  ViewCollector c(0);
  add_all_but_right(c, 1);
  c.add_image(Part::right, 1, ImageU8(1, 1));
  ASSERT_TRUE(c.wait(1, kBegin, 1ms));
  for (std::int64_t stamp = 2; stamp < 12; ++stamp) c.add_image(Part::right, stamp, ImageU8(1, 1));
  EXPECT_FALSE(c.wait(1, kBegin, 1ms));
  EXPECT_EQ(c.fault(), "");
  EXPECT_TRUE(c.add_fault("right image: truncated"));
  EXPECT_TRUE(c.add_fault("left image: truncated"));
  EXPECT_FALSE(c.add_fault("right image: truncated"));  // at the camera's rate
  EXPECT_EQ(c.fault(), "right image: truncated");
  c.clear_faults();
  EXPECT_EQ(c.fault(), "");
  EXPECT_TRUE(c.add_fault("right image: truncated"));
}

// Joints and base pose at 200 Hz, of the milliseconds [from, to).
void stream(ViewCollector& c, std::int64_t from, std::int64_t to, double angle) {
  for (std::int64_t ms = from; ms < to; ms += 5) {
    c.add_joints(ms * kMillisecond, {{"neck", angle}});
    c.add_base_pose(ms * kMillisecond, Pose(Eigen::Translation3d(angle, 0, static_cast<double>(ms))));
  }
}

void add_pictures(ViewCollector& c, std::int64_t stamp) {
  for (const Part eye : {Part::left, Part::right}) c.add_image(eye, stamp, ImageU8(1, 1));
  for (const Part eye : {Part::left_calibration, Part::right_calibration}) c.add_calibration(eye, stamp, {});
}

TEST(ViewCollector, AnImageThatComesLateFindsItsJointsInAFastStream) {
  ViewCollector c(5 * kMillisecond);
  stream(c, 0, 1000, 0);
  const auto triggered = c.now();
  stream(c, 1000, 1105, 0);  // the image of second 1 takes 100 ms
  add_pictures(c, 1003 * kMillisecond);
  const auto view = c.wait(1003 * kMillisecond, triggered, 1ms);
  ASSERT_TRUE(view);
  EXPECT_EQ(view->X_WB.translation().z(), 1005);  // the nearest
  // A camera that runs freely may hand out an image exposed before the trigger: its joints are there all the same.
  const auto again = c.now();
  add_pictures(c, 500 * kMillisecond);
  EXPECT_TRUE(c.wait(500 * kMillisecond, again, 1ms));
  stream(c, 1105, 2600, 0);
  add_pictures(c, 500 * kMillisecond);
  EXPECT_FALSE(c.wait(500 * kMillisecond, again, 1ms)) << "kept for longer than two seconds";
}

TEST(ViewCollector, AnotherRunOfTheCamerasIsNotTheOneThatWasAsked) {
  ViewCollector c(0);
  add_all_but_right(c, 50);
  c.add_image(Part::right, 50, ImageU8(1, 1, 1, 1));
  const auto triggered = c.now();  // the simulator starts again, its clock with it
  EXPECT_FALSE(c.wait(50, triggered, 1ms));
  EXPECT_EQ(c.missing(50, triggered), "left image, right image, left camera info, right camera info, joint states, base pose");
  add_all_but_right(c, 50);
  EXPECT_EQ(c.missing(50, triggered), "right image");
  c.add_image(Part::right, 50, ImageU8(1, 1, 1, 2));
  ASSERT_TRUE(c.wait(50, triggered, 1ms));
  EXPECT_EQ(c.wait(50, triggered, 1ms)->right.at(0, 0), 2);
}

// The cameras' host an hour before the robot's: which clock, and by how much, is for a person to see.
TEST(ViewCollector, WhatTheRobotSaysByAnotherClockThanTheCamerasIsToldAsSuch) {
  ViewCollector c(5 * kMillisecond);
  const std::int64_t image = 1000 * kMillisecond, hour = 3'600'000;
  const auto triggered = c.now();
  stream(c, hour + 1000, hour + 1105, 0);
  add_pictures(c, image);
  EXPECT_FALSE(c.wait(image, triggered, 1ms));
  EXPECT_EQ(c.missing(image, triggered),
            "joint states (the nearest that came is 3600 s newer), base pose (the nearest that came is 3600 s newer)");
  for (const Part eye : {Part::left, Part::right}) c.add_image(eye, image + 1000 * kMillisecond, ImageU8(1, 1));
  EXPECT_EQ(c.missing(image + 1000 * kMillisecond, triggered).substr(0, 51), "left camera info (the nearest that came is 1 s olde");
}

TEST(ViewCollector, JointsFromBeforeTheClockWentBackAreForgotten) {
  ViewCollector c(5 * kMillisecond);
  stream(c, 0, 4000, 0.1);
  const auto triggered = c.now();
  stream(c, 0, 100, 0.2);
  add_pictures(c, 3000 * kMillisecond);
  EXPECT_EQ(c.missing(3000 * kMillisecond, triggered),
            "joint states (the nearest that came is 2.905 s older), base pose (the nearest that came is 2.905 s older)");
  add_pictures(c, 50 * kMillisecond);
  ASSERT_TRUE(c.wait(50 * kMillisecond, triggered, 1ms));
  EXPECT_EQ(c.wait(50 * kMillisecond, triggered, 1ms)->joints.at(0).second, 0.2);
}

// A clock that is set back by less than what is kept, as a network's time does it.
TEST(ViewCollector, JointsFromBeforeASmallStepBackAreForgottenToo) {
  ViewCollector c(5 * kMillisecond);
  stream(c, 0, 4000, 0.1);
  const auto triggered = c.now();
  stream(c, 3002, 3100, 0.2);
  add_pictures(c, 3050 * kMillisecond);
  ASSERT_TRUE(c.wait(3050 * kMillisecond, triggered, 1ms));
  EXPECT_EQ(c.wait(3050 * kMillisecond, triggered, 1ms)->joints.at(0).second, 0.2);
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
