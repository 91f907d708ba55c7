#include "services/nbv_planner/tool/plan_input.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/object_model/model_file.h"
#include "common/object_model/testing/sphere_views.h"

namespace periplus::nbv {
namespace {

using object_model::testing::ideal_view;

class PlanInputTest : public testing::Test {
 protected:
  PlanInputTest() : folder_(std::filesystem::temp_directory_path() / ("periplus_plan_input_test_" + std::to_string(::getpid()))), model_("ball", object_model::testing::box_around({}), 0.02, {}) {
    std::filesystem::create_directories(folder_);
    for (int n : {0, 3}) model_.integrate(ideal_view({}, n, 8), {}, {});
    write("ball.periplus", object_model::write_model(model_));
    write("pair.yaml", "name: pair\nresolution_px: [640, 480]\nvertical_fov_deg: 25\nbaseline_m: 0.144\nmeasures_m: [0.4, 1.9]\nhead_radius_m: 0.2\n"
                       "limits: {height_m: [0.8, 1.6], distance_m: [0.5, 2.0], yaw_deg: [-90, 90]}\n"
                       "body: {lower_m: [-0.2, -0.3, 0], upper_m: [0.2, 0.3, 1.4]}\nscene: wall.yaml\n");
    write("plain.yaml", "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\n");
    write("wall.yaml", "schema: periplus-scene-1\nname: walled\nroom: {size_m: [6, 6, 2.8]}\nsolids:\n"
                       "  - {name: wall, shape: box, size_m: [0.1, 5.9, 2.7], position_m: [-0.6, 0, 1.4]}\n"
                       "truth: {mesh: bunny.obj, longest_side_m: 0.45, up_axis: y, position_m: [0, 0, 0.7]}\n");
    write("empty.yaml", "schema: periplus-scene-1\nname: hall\nroom: {size_m: [9, 9, 3]}\n");
  }
  ~PlanInputTest() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(file(name), std::ios::binary) << text; }
  PlanInput read(const std::string& camera, const std::string& scene = {}, const Settings& settings = {}) const {
    return read_input(file("ball.periplus"), file(camera), scene.empty() ? scene : file(scene), {}, settings);
  }
  // The sentence that it is refused with.
  std::string refusal(const std::string& model, const std::string& camera, const std::string& scene, ErrorCode code) const {
    try {
      read_input(file(model), file(camera), scene.empty() ? scene : file(scene), {}, {});
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), code) << e.what();
      return e.what();
    }
    ADD_FAILURE() << "not refused";
    return {};
  }

  const std::filesystem::path folder_;
  object_model::ObjectModel model_;
};

TEST_F(PlanInputTest, TheModelIsTheSituationsGridWithItsLandmarksAndViews) {
  const PlanInput input = read("pair.yaml");
  const Situation& s = input.situation;
  EXPECT_EQ(input.object_id, "ball");
  EXPECT_EQ(s.grid->counts(), model_.grid().counts());
  EXPECT_EQ(s.grid->known(), model_.grid().known());
  EXPECT_EQ(s.grid->occupied(), model_.grid().occupied());
  EXPECT_EQ(s.grid->revision, model_.grid().revision);
  EXPECT_TRUE(s.grid->geometry().X_WG.isApprox(model_.grid().geometry().X_WG));
  EXPECT_EQ(s.landmarks.size(), model_.landmarks().size());
  EXPECT_FALSE(s.landmarks.empty());
  // The quality of known surface counts from the model's own views, the camera's way from the last of them.
  ASSERT_EQ(s.views.size(), 2u);
  EXPECT_TRUE(s.views[0].isApprox(ideal_view({}, 0, 8).X_WC));
  EXPECT_TRUE(s.views[1].isApprox(ideal_view({}, 3, 8).X_WC));
  ASSERT_TRUE(s.X_WC_now.has_value());
  EXPECT_TRUE(s.X_WC_now->isApprox(s.views[1]));
}

TEST_F(PlanInputTest, WhatTheCamerasFileSaysGoesBeforeTheSettings) {
  Settings settings;
  settings.evaluation.pair.depth_max = 3;
  settings.evaluation.least_landmarks = 9;
  settings.constraints.head_radius = 0.1;
  settings.search.max_evaluations = 77;
  const PlanInput input = read("pair.yaml", {}, settings);
  EXPECT_EQ(input.camera_name, "pair");
  EXPECT_EQ(input.settings.evaluation.pair.depth_min, 0.4);
  EXPECT_EQ(input.settings.evaluation.pair.depth_max, 1.9);
  EXPECT_EQ(input.settings.constraints.head_radius, 0.2);
  EXPECT_EQ(input.settings.evaluation.least_landmarks, 9);
  EXPECT_EQ(input.settings.search.max_evaluations, 77);
  const Situation& s = input.situation;
  EXPECT_EQ(s.rig.baseline, 0.144);
  EXPECT_NEAR(s.rig.camera.fy, 240 / std::tan(12.5 * std::numbers::pi / 180), 1e-9);
  EXPECT_EQ(s.limits.height_min, 0.8);
  EXPECT_EQ(s.limits.distance_max, 2.0);
  EXPECT_NEAR(s.limits.yaw_max, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(s.body.upper, Eigen::Vector3d(0.2, 0.3, 1.4));

  const PlanInput plain = read("plain.yaml", {}, settings);
  EXPECT_EQ(plain.settings.evaluation.pair.depth_max, 3);
  EXPECT_EQ(plain.settings.constraints.head_radius, 0.1);
  EXPECT_EQ(plain.situation.rig.baseline, 0);
  EXPECT_EQ(plain.situation.body.lower, plain.situation.body.upper) << "no body";
}

TEST_F(PlanInputTest, TheSceneIsTheOneGivenElseTheCamerasElseFreeSpace) {
  const PlanInput walled = read("pair.yaml");
  EXPECT_EQ(walled.scene_name, "walled");
  EXPECT_TRUE(walled.situation.collision->contains({-0.6, 0, 1}));
  EXPECT_FALSE(walled.situation.scene.truth.has_value()) << "what only a simulator may know";
  const PlanInput hall = read("pair.yaml", "empty.yaml");
  EXPECT_EQ(hall.scene_name, "hall");
  EXPECT_FALSE(hall.situation.collision->contains({-0.6, 0, 1}));
  EXPECT_TRUE(hall.situation.collision->box_collides(make_pose({4.6, 0, 1}, Eigen::Matrix3d::Identity()), {0.3, 0.3, 0.3}));
  const PlanInput free = read("plain.yaml");
  EXPECT_EQ(free.scene_name, "none");
  EXPECT_FALSE(free.situation.collision->box_collides(make_pose({50, 0, 1}, Eigen::Matrix3d::Identity()), {0.3, 0.3, 0.3}));
}

TEST_F(PlanInputTest, ForbiddenPosesAndReachabilityArriveInTheSituation) {
  struct Half final : Reachability {
    double of(const Pose&) const override { return 0.5; }
  };
  Settings settings;
  settings.reachability = std::make_shared<Half>();
  const std::vector<Pose> forbidden{look_at({1, 0, 1}, {0, 0, 1}), look_at({0, 1, 1}, {0, 0, 1})};
  const PlanInput input = read_input(file("ball.periplus"), file("pair.yaml"), "", forbidden, settings);
  ASSERT_EQ(input.situation.forbidden.size(), 2u);
  EXPECT_TRUE(input.situation.forbidden[1].isApprox(forbidden[1]));
  EXPECT_EQ(input.situation.reachability, settings.reachability);
}

TEST_F(PlanInputTest, AModelWithoutViewsHasNowhereToCountFrom) {
  const object_model::ObjectModel fresh("box", object_model::testing::box_around({}), 0.05, {});
  write("fresh.periplus", object_model::write_model(fresh));
  const PlanInput input = read_input(file("fresh.periplus"), file("plain.yaml"), "", {}, {});
  EXPECT_TRUE(input.situation.views.empty());
  EXPECT_FALSE(input.situation.X_WC_now.has_value());
}

TEST_F(PlanInputTest, WhatIsWrongIsSaidWithItsFileTheSmallFilesFirst) {
  write("bad.yaml", "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\nlimits: {height_m: [2.0, 0.3]}\n");
  EXPECT_NE(refusal("nowhere.periplus", "bad.yaml", "", ErrorCode::bad_input).find("bad.yaml"), std::string::npos);
  EXPECT_NE(refusal("nowhere.periplus", "plain.yaml", "", ErrorCode::io).find("nowhere.periplus"), std::string::npos);
  EXPECT_NE(refusal("ball.periplus", "nowhere.yaml", "", ErrorCode::io).find("nowhere.yaml"), std::string::npos);
  EXPECT_NE(refusal("ball.periplus", "plain.yaml", "nowhere.yaml", ErrorCode::io).find("nowhere.yaml"), std::string::npos);
  const std::string no_model = refusal("wall.yaml", "plain.yaml", "", ErrorCode::bad_input);
  EXPECT_NE(no_model.find("wall.yaml"), std::string::npos) << no_model;
  EXPECT_NE(no_model.find("periplus model export"), std::string::npos) << no_model;
}

}  // namespace
}  // namespace periplus::nbv
