#include "common/object_model/growth.h"

#include <gtest/gtest.h>

#include <functional>
#include <string_view>

#include "common/core/error.h"
#include "common/core/fault_point.h"
#include "common/core/random.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/scene/scene.h"

namespace periplus::object_model {
namespace {

using namespace testing;

const CarvingSettings kCarving;
const GrowthSettings kGrowth;
const Sphere kBall;
constexpr int kViews = 6;

// The box and where the sphere leaves it, in voxels of 1 cm.
ObjectBox small_box(double yaw = 0) {
  ObjectBox box;
  box.X_WB = make_pose(kBall.center + Eigen::Vector3d(0.03, 0, -0.05), rotation_from_yaw_pitch_roll(yaw, 0, 0));
  box.size = {0.2, 0.4, 0.16};
  return box;
}

Surroundings on_table(double height) {
  scene::Scene scene;
  scene::Solid table;
  table.name = "table";
  table.size = {3, 3, height};
  table.X_WS.translation().z() = height / 2;
  scene.solids.push_back(table);
  return {"table", std::make_shared<const scene::CollisionWorld>(scene), occluders_of(scene)};
}

// What stands nearer than what the depth map shows already, in both images.
template <class Depth>
void put_before(DepthMap& map, Depth&& depth_at) {
  for (int y = 0; y < map.camera.height; ++y)
    for (int x = 0; x < map.camera.width; ++x) {
      const auto z = static_cast<float>(depth_at(x, y));
      if (!(z > 0)) continue;
      map.depth.at(x, y) = std::min(map.depth.at(x, y), z);
      map.depth_minimum.at(x, y) = std::min(map.depth_minimum.at(x, y), z);
    }
}

void put_sphere(DepthMap& map, const Sphere& sphere) {
  const DepthMap other = ideal_depth(sphere, map.X_WC, map.camera);
  put_before(map, [&](int x, int y) { return other.depth.at(x, y); });
}

// A level plane at this height.
void put_plane(DepthMap& map, double height) {
  put_before(map, [&](int x, int y) {
    const Eigen::Vector3d ray_W = map.X_WC.linear() * map.camera.back_project(x, y, 1);
    return ray_W.z() < 0 ? (height - map.X_WC.translation().z()) / ray_W.z() : 0.0;
  });
}

// Integrates as the model server does.
bool look(ObjectModel& model, const Perception& perception, const Surroundings& around = {}) {
  model.integrate(perception, around, kCarving);
  Growth growth = grow(model, around, kCarving, kGrowth);
  EXPECT_EQ(growth.refused, "");
  if (growth.model) model = std::move(*growth.model);
  EXPECT_TRUE(*model.exposed_faces() == voxel::ExposedFaces(model.grid()));
  return growth.model.has_value();
}

class GrowthOfTurnedBoxes : public ::testing::TestWithParam<double> {};

TEST_P(GrowthOfTurnedBoxes, IsTheModelOfTheLargerBoxFromTheStart) {
  ObjectModel model("ball", small_box(GetParam()), 0.01, {});
  const voxel::GridGeometry begun = model.grid().geometry();
  int grown = 0;
  for (int n = 0; n < kViews; ++n) grown += look(model, ideal_view(kBall, n, kViews));
  EXPECT_GE(grown, 1);

  ObjectModel larger("ball", model.state().box, 0.01, {});
  for (int n = 0; n < kViews; ++n) larger.integrate(ideal_view(kBall, n, kViews), {}, kCarving);
  EXPECT_EQ(model.digest(), larger.digest());
  EXPECT_TRUE(model.state().evidence == larger.state().evidence);
  EXPECT_GT(model.grid().revision, static_cast<std::uint32_t>(kViews));

  // It holds the ball with a margin, has grown by whole bricks, and not where the ball does not leave the box.
  const voxel::GridGeometry& g = model.grid().geometry();
  const Eigen::Vector3d offset = (g.X_WG.inverse() * begun.X_WG.translation()) / g.voxel_size;
  EXPECT_TRUE((offset / 8).isApprox((offset / 8).array().round().matrix(), 1e-6)) << offset.transpose();
  EXPECT_EQ((g.size - begun.size).array().unaryExpr([](int n) { return n % 8; }).sum(), 0);
  const Eigen::Vector3d c = g.X_WG.inverse() * kBall.center, most = g.voxel_size * g.size.cast<double>();
  if (GetParam() == 0) {
    EXPECT_GE((c.array() - kBall.radius).minCoeff(), 0.039);
    EXPECT_GE((most - c).minCoeff() - kBall.radius, 0.039);
    EXPECT_EQ(g.size.y(), 40);
    EXPECT_LE((g.size - begun.size).maxCoeff(), 32);
  }
  EXPECT_TRUE(same_box(model.state().begun_box, small_box(GetParam())));
}

INSTANTIATE_TEST_SUITE_P(Yaws, GrowthOfTurnedBoxes, ::testing::Values(0.0, 0.4));

TEST(Growth, SoItIsInTheProbabilisticMode) {
  CarvingSettings carving;
  carving.mode = CarvingMode::probabilistic;
  ObjectModel model("ball", small_box(), 0.01, {});
  for (int n = 0; n < kViews; ++n) {
    model.integrate(ideal_view(kBall, n, kViews), {}, carving);
    if (Growth growth = grow(model, {}, carving, kGrowth); growth.model) model = std::move(*growth.model);
  }
  ASSERT_FALSE(same_box(model.state().box, small_box()));
  ObjectModel larger("ball", model.state().box, 0.01, {});
  for (int n = 0; n < kViews; ++n) larger.integrate(ideal_view(kBall, n, kViews), {}, carving);
  EXPECT_EQ(model.digest(), larger.digest());
}

TEST(Growth, WhatStaysInItsBoxDoesNotGrow) {
  ObjectModel model("ball", box_around(kBall, 0.32), 0.01, {});
  for (int n = 0; n < kViews; ++n) EXPECT_FALSE(look(model, ideal_view(kBall, n, kViews))) << n;
  Perception plain = ideal_view(kBall, 0, kViews);
  plain.silhouette_valid_share = 0.5;
  ObjectModel hardly_seen("ball", small_box(), 0.01, {});
  EXPECT_FALSE(look(hardly_seen, plain));
  GrowthSettings off;
  off.enabled = false;
  ObjectModel leaving("ball", small_box(), 0.01, {});
  leaving.integrate(ideal_view(kBall, 0, kViews), {}, kCarving);
  EXPECT_FALSE(grow(leaving, {}, kCarving, off).model.has_value());
}

// The table goes on outside the box, seen 8 mm too high, 5 mm of noise on it; the ball stands on it and is the object alone.
TEST(Growth, TheTableIsNotTheObjects) {
  const double height = kBall.center.z() - kBall.radius;
  const Surroundings around = on_table(height);
  ObjectModel model("ball", box_around(kBall, 0.36), 0.01, around);
  Random random(3);
  for (int n = 1; n < 2 * kViews; n += 2) {  // the views from above
    Perception p = ideal_view(kBall, n, 2 * kViews);
    for (DepthMap& map : p.depth) put_plane(map, height + 0.008 + 0.005 * random.normal());
    EXPECT_FALSE(look(model, p, around)) << n;
  }
  const int measured_beside = [&] {
    int count = 0;
    for_each_voxel(model.grid().geometry(), [&](const Eigen::Vector3i& v) { count += v.x() == 0 && model.is_measured(v); });
    return count;
  }();
  EXPECT_GT(measured_beside, 10) << "the table's top does not reach the box's faces as the object's, so that nothing is tested";
}

// The table 5 cm too high, by depths that say themselves how uncertain they are: 2 cm from 1.2 m away.
TEST(Growth, TheTableIsNotTheObjectsByUncertainDepthsEither) {
  const double height = kBall.center.z() - kBall.radius;
  const Surroundings around = on_table(height);
  for (const bool says_so : {false, true}) {
    ObjectModel model("ball", box_around(kBall, 0.36), 0.01, around);
    int grown = 0;
    for (int n = 1; n < 2 * kViews; n += 2) {
      Perception p = ideal_view(kBall, n, 2 * kViews);
      for (DepthMap& map : p.depth) {
        put_plane(map, height + 0.05);
        for (std::size_t i = 0; says_so && i < map.depth.data.size(); ++i) map.depth_sigma.data[i] = 0.014f * map.depth.data[i] * map.depth.data[i];
      }
      grown += look(model, p, around);
    }
    EXPECT_EQ(grown > 0, !says_so);
  }
}

// A needle on top of the ball in the picture of one view, where the others see that nothing is there.
TEST(Growth, WhatOtherViewsSeeThroughIsNotTheObjects) {
  const ObjectBox box = box_around(kBall, 0.3);
  Perception wrong = ideal_view(kBall, 1, kViews);
  for (DepthMap& map : wrong.depth)
    for (int bead = 0; bead < 4; ++bead) put_sphere(map, Sphere{kBall.center + Eigen::Vector3d(0, 0, kBall.radius + 0.012 + 0.02 * bead), 0.012});
  ObjectModel without("ball", box, 0.01, {}), with("ball", box, 0.01, {});
  for (int n : {0, 2, 3, 4, 5}) EXPECT_FALSE(look(without, ideal_view(kBall, n, kViews))) << n;
  EXPECT_FALSE(look(without, wrong));
  EXPECT_TRUE(look(with, wrong)) << "alone, nothing speaks against it";
}

// Views of all that are gone through for their points outside, and that are carved.
struct Effort {
  int points = 0, carved = 0;
  bool operator==(const Effort&) const = default;
};
Effort effort_of(const std::function<void()>& work) {
  static Effort effort;
  effort = {};
  fault_hook() = [](const char* point) {
    effort.points += std::string_view(point) == "growth.view";
    effort.carved += std::string_view(point) == "model.labelled";
  };
  work();
  fault_hook() = nullptr;
  --effort.points;  // the newest view alone
  return effort;
}

// A needle on top of the ball, in a small picture.
Perception needle(int look) {
  Perception p = ideal_view(kBall, 1, kViews, 160, 120);
  p.view_id = "needle-" + std::to_string(look);
  for (DepthMap& map : p.depth)
    for (int bead = 0; bead < 4; ++bead) put_sphere(map, Sphere{kBall.center + Eigen::Vector3d(0, 0, kBall.radius + 0.012 + 0.02 * bead), 0.012});
  return p;
}

// It ends at the ball's top.
ObjectBox flat_box() {
  ObjectBox box = box_around(kBall, 0.4);
  box.size.z() = 2 * kBall.radius;
  return box;
}

TEST(Growth, ALookCarvesItselfAloneInABoxThatWasRefuted) {
  ObjectModel model("ball", flat_box(), 0.01, {});
  for (int n : {0, 2, 3, 4, 5}) model.integrate(ideal_view(kBall, n, kViews, 160, 120), {}, kCarving);
  RefutedBoxes kept;
  const auto effort = [&](const ObjectModel& m, const CarvingSettings& carving = kCarving) {
    return effort_of([&] { EXPECT_FALSE(grow(m, {}, carving, kGrowth, &kept).model.has_value()); });
  };
  for (int look = 0; look < 4; ++look) {
    if (look == 2) {  // one that shows nothing outside in between
      Perception clear = ideal_view(kBall, 3, kViews, 160, 120);
      clear.view_id = "clear";
      model.integrate(clear, {}, kCarving);
      EXPECT_EQ(effort(model), Effort());
    }
    model.integrate(needle(look), {}, kCarving);
    const int news = look == 0 ? 6 : look == 2 ? 2 : 1;
    EXPECT_EQ(effort(model), (Effort{news, news})) << look;
  }
  EXPECT_EQ(kept.boxes.size(), 1u);
  // What was carved by other views, by other rules or in other surroundings says nothing.
  const ObjectModel revised = model.revised({{"view-0", model.view("view-0")->X_WC, model.view("view-0")->covariance}}, {}, {}, kCarving);
  EXPECT_EQ(effort(revised), (Effort{10, 10}));
  EXPECT_EQ(effort(revised), Effort());
  CarvingSettings other;
  other.seen_points = 9;
  EXPECT_EQ(effort(revised, other), (Effort{10, 10}));
  EXPECT_NE(grow(revised, on_table(0.1), other, kGrowth, &kept).refused, "");
}

// In the probabilistic mode the needle outvotes the views that refute it in the end.
TEST(Growth, IsTheSameWithRefutedBoxesAndWithout) {
  for (const CarvingMode mode : {CarvingMode::conservative, CarvingMode::probabilistic}) {
    CarvingSettings carving;
    carving.mode = mode;
    ObjectModel with("ball", flat_box(), 0.01, {}), without = with;
    RefutedBoxes kept;
    int grown = 0, refuted = 0;
    const auto both_look = [&](const Perception& p) {
      with.integrate(p, {}, carving);
      without.integrate(p, {}, carving);
      Growth a = grow(with, {}, carving, kGrowth, &kept), b = grow(without, {}, carving, kGrowth);
      ASSERT_EQ(a.model.has_value(), b.model.has_value());
      if (a.model) {
        with = std::move(*a.model);
        without = std::move(*b.model);
        ++grown;
      }
      refuted += !kept.boxes.empty();
      EXPECT_EQ(with.digest(), without.digest());
      EXPECT_EQ(with.grid().revision, without.grid().revision);
      EXPECT_TRUE(with.state().tsdf == without.state().tsdf);
    };
    for (int n : {0, 2, 3, 4, 5}) both_look(ideal_view(kBall, n, kViews, 160, 120));
    for (int look = 0; look < 6; ++look) both_look(needle(look));
    EXPECT_EQ(grown > 0, mode == CarvingMode::probabilistic);
    EXPECT_GT(refuted, 1);
  }
}

// The ball's top leaves the box, and on it is what one view shows and the other, clear one carves.
ObjectModel ball_with_something_on_top(const std::vector<Sphere>& something, const Perception& clear, const CarvingSettings& carving) {
  ObjectBox box = box_around(kBall, 0.4);
  box.X_WB.translation().z() = kBall.center.z() + kBall.radius - 0.22;
  Perception wrong = ideal_view(kBall, 1, kViews);
  for (DepthMap& map : wrong.depth)
    for (const Sphere& sphere : something) put_sphere(map, sphere);
  ObjectModel model("ball", box, 0.01, {});
  model.integrate(clear, {}, carving);
  model.integrate(wrong, {}, carving);
  return model;
}
Sphere above_ball(double height, double radius) { return {kBall.center + Eigen::Vector3d(0, 0, kBall.radius + height), radius}; }

// A pose that is certain at the middle of the box that holds the needle, and uncertain at that of the one that does not: each of the two says
// that the other is the right one.
TEST(Growth, EndsWhereTwoBoxesContradictEachOther) {
  CarvingSettings carving;
  carving.cautious_votes = 3;
  Perception clear = ideal_view(kBall, 3, kViews);
  const std::vector<Sphere> needle{above_ball(0.012, 0.012), above_ball(0.032, 0.012), above_ball(0.052, 0.012)};
  const ObjectModel begun = ball_with_something_on_top(needle, clear, carving);
  const auto distance = [&](int voxels) {
    return (clear.X_WC.translation() - begun.state().box.X_WB.translation() - Eigen::Vector3d(0, 0, 0.005 * voxels)).norm();
  };
  ASSERT_LT(distance(16), distance(8));
  const double sigma = carving.uncertain_pose_voxels * 0.01 / (0.5 * (distance(8) + distance(16)));
  clear.covariance.bottomRightCorner<3, 3>() = sigma * sigma * Eigen::Matrix3d::Identity();
  const Growth growth = grow(ball_with_something_on_top(needle, clear, carving), {}, carving, kGrowth);
  ASSERT_TRUE(growth.model.has_value());
  EXPECT_EQ(growth.model->grid().geometry().size, Eigen::Vector3i(40, 40, 48));
}

// What is carved again ends within the brick that the ball itself takes.
TEST(Growth, AsManyVoxelsStandOutsideAsAreAskedFor) {
  std::vector<Sphere> crown;
  for (const double x : {-0.05, 0.0, 0.05})
    for (const double y : {-0.05, 0.0, 0.05}) crown.push_back({kBall.center + Eigen::Vector3d(x, y, kBall.radius + 0.022), 0.022});
  const ObjectModel begun = ball_with_something_on_top(crown, ideal_view(kBall, 3, kViews), kCarving);
  for (const int least : {200, 300}) {  // the newest view shows 342, and 216 stand
    const Growth growth = grow(begun, {}, kCarving, {.least_voxels = least, .margin_voxels = 0});
    ASSERT_EQ(growth.model.has_value(), least == 200) << least;
    if (growth.model) {
      EXPECT_EQ(growth.model->grid().geometry().size, Eigen::Vector3i(40, 40, 48));
    }
  }
}

TEST(Growth, WhatWasRefutedGrowsAsEverWhereALaterViewShowsIt) {
  std::vector<Sphere> crown;
  for (const double x : {-0.05, 0.0, 0.05})
    for (const double y : {-0.05, 0.0, 0.05}) crown.push_back({kBall.center + Eigen::Vector3d(x, y, kBall.radius + 0.022), 0.022});
  ObjectModel model = ball_with_something_on_top(crown, ideal_view(kBall, 3, kViews), kCarving);
  RefutedBoxes kept;
  ASSERT_FALSE(grow(model, {}, kCarving, {.least_voxels = 300, .margin_voxels = 0}, &kept).model.has_value());
  ASSERT_FALSE(kept.boxes.empty());
  Perception again = ideal_view(kBall, 1, kViews);
  again.view_id = "again";
  for (DepthMap& map : again.depth)
    for (const Sphere& sphere : crown) put_sphere(map, sphere);
  model.integrate(again, {}, kCarving);
  const GrowthSettings fewer{.least_voxels = 200, .margin_voxels = 0};
  const Growth with = grow(model, {}, kCarving, fewer, &kept), without = grow(model, {}, kCarving, fewer);
  ASSERT_TRUE(with.model.has_value());
  EXPECT_EQ(with.model->digest(), without.model->digest());
  EXPECT_EQ(with.model->grid().revision, without.model->grid().revision);
  EXPECT_TRUE(with.model->state().tsdf == without.model->state().tsdf);
}

TEST(Growth, IsRefusedWithAReason) {
  // Five hundred voxels long, and half of the ball's top at its end.
  ObjectBox box = box_around(kBall);
  box.size = {2, 0.04, 0.04};
  box.X_WB.translation() += Eigen::Vector3d(-1, 0, 0.13);
  ObjectModel model("ball", box, 0.004, {});
  model.integrate(ideal_view(kBall, 1, kViews), {}, kCarving);
  Growth growth = grow(model, {}, kCarving, kGrowth);
  EXPECT_FALSE(growth.model.has_value());
  EXPECT_NE(growth.refused.find("larger voxels"), std::string::npos) << growth.refused;

  ModelState state = [&] {
    ObjectModel imported("ball", small_box(), 0.01, {});
    imported.integrate(ideal_view(kBall, 0, kViews), {}, kCarving);
    return imported.state();
  }();
  state.imported = true;
  growth = grow(ObjectModel(std::move(state)), {}, kCarving, kGrowth);
  EXPECT_NE(growth.refused.find("imported"), std::string::npos) << growth.refused;
  ObjectModel elsewhere("ball", small_box(), 0.01, {});
  elsewhere.integrate(ideal_view(kBall, 0, kViews), {}, kCarving);
  growth = grow(elsewhere, on_table(0.1), kCarving, kGrowth);
  EXPECT_FALSE(growth.model.has_value());
  EXPECT_NE(growth.refused.find("another environment"), std::string::npos) << growth.refused;
  for (const GrowthSettings& bad : {GrowthSettings{.least_voxels = 0}, GrowthSettings{.margin_voxels = -1}, GrowthSettings{.least_area = std::nan("")}})
    EXPECT_THROW(bad.check(), Error);
}

}  // namespace
}  // namespace periplus::object_model
