#include "services/nbv_planner/tool/plan_output.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "services/nbv_planner/testing/situations.h"
#include "services/nbv_planner/tool/pose_text.h"

namespace periplus::nbv {
namespace {

PlanInput input() {
  PlanInput in;
  in.situation = testing::patch_at_plus_x();
  in.situation.views = {look_at({-1, 0, 1}, {0, 0, 1}), look_at({0, 1, 1}, {0, 0, 1}), look_at({0, -1, 1}, {0, 0, 1})};
  in.situation.forbidden = {look_along({1, 0.5, 1.2}, 3, 0.25)};
  in.object_id = "block";
  in.camera_name = "pair";
  in.scene_name = "room";
  return in;
}

Planned planned(const PlanInput& in) {
  Planned p;
  p.view.X_WC = look_along({1.25, -0.5, 1.1}, 170 * std::numbers::pi / 180, 0);
  p.view.evaluation.gain = {225, 57010};
  p.view.f_e = -224.5;
  p.view.evaluations = 292;
  p.view.terms = {{"f_e", -224.5}, {"N_u", 225}, {"quality", 1.25}};
  p.view.seconds = {{"panoramas", 0.25}, {"exact", 0.125}};
  p.method = "thorough";
  p.seed = 18446744073709551615ULL;
  p.seconds = 0.5;
  p.counts = in.situation.grid->counts();
  return p;
}

TEST(PlanOutput, JsonHoldsTheViewAndWhatItWasPlannedOn) {
  const PlanInput in = input();
  const Planned p = planned(in);
  const auto j = nlohmann::json::parse(to_json(in, p));
  EXPECT_EQ(j.at("schema"), "periplus-nbv-1");
  EXPECT_EQ(j.at("result"), "view");
  const auto& model = j.at("model");
  EXPECT_EQ(model.at("object"), "block");
  EXPECT_EQ(model.at("revision"), 1);
  EXPECT_EQ(model.at("views"), 3);
  EXPECT_EQ(model.at("voxel_m"), 0.02);
  EXPECT_EQ(model.at("size"), nlohmann::json({15, 15, 15}));
  EXPECT_EQ(model.at("unknown"), 225);
  EXPECT_EQ(model.at("known"), 14 * 225);
  EXPECT_EQ(j.at("camera").at("baseline_m"), 0.144);
  EXPECT_EQ(j.at("scene"), "room");
  EXPECT_EQ(j.at("seed").get<std::uint64_t>(), p.seed);
  EXPECT_EQ(j.at("gain").at("voxels"), 225);
  EXPECT_EQ(j.at("gain").at("pixels"), 57010);
  EXPECT_EQ(j.at("f_e"), -224.5);
  EXPECT_EQ(j.at("terms").at("quality"), 1.25);
  EXPECT_EQ(j.at("seconds").at("panoramas"), 0.25);
  EXPECT_EQ(j.at("seconds").at("all"), 0.5);
  EXPECT_EQ(j.at("evaluations"), 292);
  EXPECT_EQ(j.at("cut_short"), false);
  EXPECT_FALSE(j.contains("reason"));
  // One pose, written three ways; the forbidden one reads back too.
  const auto& view = j.at("view");
  EXPECT_EQ(view.at("position_m"), nlohmann::json({1.25, -0.5, 1.1}));
  EXPECT_NEAR(view.at("yaw_deg"), 170, 1e-9);
  EXPECT_EQ(view.at("pitch_deg"), 0) << "no negative zero, no 1e-15";
  const auto& q = view.at("quaternion_wxyz");
  EXPECT_TRUE(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix().isApprox(p.view.X_WC.linear(), 1e-12));
  EXPECT_TRUE(parse_pose(view.at("text").get<std::string>(), "view").isApprox(p.view.X_WC, 1e-6));
  ASSERT_EQ(j.at("forbidden").size(), 1u);
  EXPECT_TRUE(parse_pose(j.at("forbidden")[0].get<std::string>(), "forbidden").isApprox(in.situation.forbidden[0], 1e-5));
}

TEST(PlanOutput, EachResultHasItsName) {
  const PlanInput in = input();
  Planned p = planned(in);
  const auto result = [&] { return nlohmann::json::parse(to_json(in, p)).at("result").get<std::string>(); };
  EXPECT_EQ(result(), "view");
  p.view.cut_short = true;
  EXPECT_EQ(result(), "view") << "cut short, but there is one";
  p.view.evaluation.gain = {};
  EXPECT_EQ(result(), "cut_short");
  EXPECT_NE(to_text(in, p).find("no gain found in the time given"), std::string::npos);
  p.view.cut_short = false;
  EXPECT_EQ(result(), "nothing_unknown");
  EXPECT_NE(to_text(in, p).find("nothing unknown is left to see"), std::string::npos);
  p.no_view = "no place satisfies the constraints";
  const auto j = nlohmann::json::parse(to_json(in, p));
  EXPECT_EQ(j.at("result"), "no_reachable_view");
  EXPECT_EQ(j.at("reason"), p.no_view);
  EXPECT_EQ(j.at("model").at("unknown"), 225);
  EXPECT_EQ(j.at("method"), "thorough");
  for (const char* key : {"view", "gain", "f_e", "terms", "evaluations", "seconds"}) EXPECT_FALSE(j.contains(key)) << key;
}

TEST(PlanOutput, TextSaysTheSameAndItsPoseCanBeHandedBack) {
  PlanInput in = input();
  Planned p = planned(in);
  const std::string text = to_text(in, p);
  for (const char* line : {"block, revision 1, 3 views, 15 x 15 x 15 voxels of 0.02 m: 225 unknown, 3150 known, 0 environment", "a pair 0.144 m apart; scene room; 1 forbidden",
                           "position  1.2500 -0.5000 1.1000 m", "yaw 170.00  pitch 0.00  roll 0.00", "225 unknown voxels, 57010 pixels, by both eyes", "quality 1.25",
                           "thorough, seed 18446744073709551615: 292 evaluations, 0.500 s (panoramas 0.250, exact 0.125)", "landmark term off"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "\nin\n" << text;
  }
  const std::size_t begin = text.find("pose      ") + 10, end = text.find(" (as --forbid takes it)");
  ASSERT_NE(end, std::string::npos);
  EXPECT_TRUE(parse_pose(text.substr(begin, end - begin), "text").isApprox(p.view.X_WC, 1e-6));
  EXPECT_EQ(text.find("-0.00"), std::string::npos) << text;

  in.situation.rig.baseline = 0;
  p.view.landmark_term = p.view.cut_short = true;
  const std::string one = to_text(in, p);
  EXPECT_NE(one.find("one camera; scene room"), std::string::npos);
  EXPECT_EQ(one.find("by both eyes"), std::string::npos);
  EXPECT_NE(one.find("landmark term on"), std::string::npos);
  EXPECT_NE(one.find("cut short by the time limit"), std::string::npos);
  p.no_view = "nowhere to stand";
  EXPECT_NE(to_text(in, p).find("no view   nowhere to stand\n"), std::string::npos);
  EXPECT_EQ(to_text(in, p).find("position"), std::string::npos);
}

}  // namespace
}  // namespace periplus::nbv
