#include "services/nbv_planner/nbv_planner_service.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "common/core/config.h"
#include "common/dds/codec_impl.h"
#include "common/service/testing/test_service.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_publisher.h"
#include "common/wire/object_wire.h"
#include "common/wire/testing/environment_texts.h"
#include "idl/model.h"
#include "idl/nbv.h"
#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/quality.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

using namespace std::chrono_literals;

msg::Environment room() {
  const wire::testing::Texts texts = wire::testing::environment_texts();
  return wire::environment_to_wire("room", "name: room\nroom: {size_m: [6, 6, 2.8]}\n", texts.robot_yaml, texts.robot_urdf);
}

msg::PlanViewRequest request() {
  msg::PlanViewRequest q;
  q.plan_id("plan-1");
  q.object_id("block");
  q.revision(1);
  q.environment_revision(room().revision());
  q.rig(wire::to_wire(StereoRig{Pinhole::from_vertical_fov(640, 480, 25 * std::numbers::pi / 180), 0.144}));
  q.pose_world_camera(wire::to_wire(Pose::Identity()));
  q.height_min_m(1.0);
  q.height_max_m(1.35);
  q.distance_min_m(0.6);
  q.distance_max_m(2.5);
  q.pitch_min_rad(-0.4);
  q.pitch_max_rad(1.0);
  q.seed(1);
  q.max_evaluations(300);
  return q;
}

// The service on a node, and whoever tells and asks it.
struct RunningPlanner {
  RunningPlanner(const char* name, const Settings& settings) : service(name), planner(service, settings) {}

  service::testing::TestService service;
  NbvPlannerService planner;
  dds::Publisher<msg::Environment> environments{service.node(), "periplus/environment", dds::qos_latest()};
  wire::ObjectPublisher objects{service.node()};
  dds::RpcClient<msg::PlanViewRequest, msg::PlanViewReply> client{service.node(), "nbv/plan"};
};

TEST(NbvPlannerService, AnswersAndRefuses) {
  Settings settings;
  settings.revision_wait_s = 0.2;
  settings.alike = "like this";
  RunningPlanner running("nbv_planner_service_test", settings);
  auto& [service, planner, environments, objects, client] = running;
  const auto ask = [&](msg::PlanViewRequest q, msg::PlanViewReply& r) {
    return client.call(q, r, {.deadline = 60s, .wait_for_server = 10s});
  };
  const auto code = [](const dds::RpcResult& r) { return static_cast<ErrorCode>(r.error_code); };

  msg::PlanViewReply reply;
  EXPECT_EQ(code(ask(request(), reply)), ErrorCode::nbv_revision_not_here);  // nothing was published

  ASSERT_TRUE(environments.publish(room()));
  const Situation s = testing::patch_at_plus_x();
  objects.publish("block", *s.grid);
  dds::RpcResult result;
  for (int i = 0; i < 50; ++i) {  // until both have arrived
    result = ask(request(), reply);
    if (code(result) != ErrorCode::nbv_revision_not_here) break;
  }
  ASSERT_TRUE(result.ok()) << result.error_message;
  EXPECT_GT(reply.predicted_gain_voxels(), 200);
  EXPECT_GT(reply.predicted_gain_px(), 5 * reply.predicted_gain_voxels());
  EXPECT_FALSE(reply.landmark_term());
  EXPECT_GT(reply.evaluations(), 100u);
  EXPECT_LE(reply.evaluations(), 300u);
  const Pose X_WC = wire::from_wire(reply.pose_world_camera());
  EXPECT_GT(X_WC.translation().x(), 0.5);
  ASSERT_FALSE(reply.terms().empty());
  EXPECT_EQ(reply.terms()[2].name().to_string(), "N_u");
  EXPECT_EQ(reply.terms()[2].value(), reply.predicted_gain_voxels());

  msg::PlanViewReply other;
  ASSERT_TRUE(ask(request(), other).ok());
  EXPECT_EQ(reply.pose_world_camera(), other.pose_world_camera());  // asked twice, the same answer

  msg::PlanViewRequest forbidden = request();
  forbidden.forbidden().push_back(reply.pose_world_camera());
  ASSERT_TRUE(ask(forbidden, other).ok());
  const Pose X_other = wire::from_wire(other.pose_world_camera());
  EXPECT_TRUE((X_other.translation() - X_WC.translation()).norm() > 0.1 ||
              angle_between(X_other, X_WC) > 10 * std::numbers::pi / 180);

  msg::PlanViewRequest bad = request();
  bad.height_max_m(std::nan(""));
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::not_finite);
  bad = request();
  bad.object_id("no such/name");
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::bad_input);
  bad = request();
  bad.rig().camera().width(0);
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::bad_input);
  bad = request();
  bad.pose_world_camera().qw(std::nan(""));
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::not_finite);
  bad = request();
  bad.revision(2);
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::nbv_revision_not_here);
  // Only with the environment that the request names, whichever is here.
  bad = request();
  bad.environment_revision(std::string(64, '0'));
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::nbv_revision_not_here);
  bad.environment_revision(std::string());
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::bad_input);
  bad = request();
  bad.height_min_m(2.78);
  bad.height_max_m(2.79);
  EXPECT_EQ(code(ask(bad, other)), ErrorCode::nbv_no_reachable_view);

  // Numbers that cannot be, one at a time.
  using Change = std::function<void(msg::PlanViewRequest&)>;
  const double nan = std::nan(""), infinite = HUGE_VAL;
  const std::vector<std::pair<Change, ErrorCode>> changes{
      {[&](auto& q) { q.time_limit_s(nan); }, ErrorCode::not_finite},
      {[&](auto& q) { q.time_limit_s(infinite); }, ErrorCode::not_finite},
      {[](auto& q) { q.time_limit_s(-1); }, ErrorCode::bad_input},
      {[](auto& q) { q.time_limit_s(1e9); }, ErrorCode::bad_input},
      {[&](auto& q) { q.height_min_m(-infinite); }, ErrorCode::not_finite},
      {[](auto& q) { q.height_min_m(1.4); }, ErrorCode::bad_input},
      {[&](auto& q) { q.distance_max_m(infinite); }, ErrorCode::not_finite},
      {[](auto& q) { q.distance_min_m(3); }, ErrorCode::bad_input},
      {[&](auto& q) { q.pitch_min_rad(nan); }, ErrorCode::not_finite},
      {[](auto& q) { q.pitch_max_rad(-1); }, ErrorCode::bad_input},
      {[&](auto& q) { q.roll_max_rad(nan); }, ErrorCode::not_finite},
      {[&](auto& q) { q.yaw_max_rad(nan); }, ErrorCode::not_finite},
      {[&](auto& q) { q.rig().camera().fx(nan); }, ErrorCode::not_finite},
      {[](auto& q) { q.rig().camera().height(100000); }, ErrorCode::bad_input},
      {[&](auto& q) { q.rig().baseline(infinite); }, ErrorCode::not_finite},
      {[](auto& q) { q.pose_world_camera().qw(2); }, ErrorCode::bad_input},
      {[&](auto& q) {
         q.forbidden().resize(256, q.pose_world_camera());
         q.forbidden().back().position().x(nan);
       }, ErrorCode::not_finite},
      {[](auto& q) { q.plan_id(std::string()); }, ErrorCode::bad_input},
  };
  for (std::size_t i = 0; i < changes.size(); ++i) {
    bad = request();
    changes[i].first(bad);
    EXPECT_EQ(code(ask(bad, other)), changes[i].second) << "change " << i;
    EXPECT_EQ(other.evaluations(), 0u);
  }
  // As many forbidden poses as the IDL allows, none of them near: the same view as without them is still feasible.
  bad = request();
  bad.forbidden().resize(256, wire::to_wire(look_at({-2.5, -2.5, 1.2}, {0, 0, 1.1})));
  EXPECT_TRUE(ask(bad, other).ok());
  bad.forbidden().resize(257);
  EXPECT_EQ(client.call(bad, other, {.deadline = 500ms}).status, dds::RpcStatus::timeout) << "over the bound: dropped where it arrives";

  // What other planners ask.
  dds::RpcClient<msg::RunTasksRequest, msg::RunTasksReply> tasks(service.node(), "nbv/tasks");
  const auto part = [&](const std::function<void(msg::RunTasksRequest&)>& change, msg::RunTasksReply& r) {
    msg::RunTasksRequest q;
    q.plan(request());
    q.alike("like this");
    q.last(2);
    change(q);
    return code(tasks.call(q, r, {.deadline = 60s, .wait_for_server = 10s}));
  };
  msg::RunTasksReply results;
  ASSERT_EQ(part([](auto&) {}, results), ErrorCode::ok);
  EXPECT_EQ(results.results().sizes().size(), 2u);
  const std::size_t numbers = results.results().numbers().size();
  EXPECT_EQ(results.results().sizes()[0] + results.results().sizes()[1], numbers);
  const msg::StageNumbers two = results.results();
  EXPECT_EQ(part([](auto& q) { q.alike("like that"); }, results), ErrorCode::bad_input);
  EXPECT_EQ(part([](auto& q) { q.plan().revision(9); }, results), ErrorCode::nbv_revision_not_here);
  EXPECT_EQ(part([](auto& q) { q.first(2); }, results), ErrorCode::bad_input);
  EXPECT_EQ(part([](auto& q) { q.last(0xffffffffu); }, results), ErrorCode::bad_input);
  EXPECT_EQ(part([](auto& q) { q.last(900000); }, results), ErrorCode::bad_input);
  EXPECT_EQ(part([&](auto& q) { q.done().push_back(two); }, results), ErrorCode::bad_size);  // of two tasks only
  EXPECT_EQ(part([&](auto& q) { q.done().resize(256); }, results), ErrorCode::bad_size);
  EXPECT_EQ(part([&](auto& q) {
              q.done().push_back(two);
              q.done().back().sizes().resize(65536, 0xffffffffu);
            }, results), ErrorCode::bad_size);
  EXPECT_TRUE(results.results().numbers().empty());
  ASSERT_TRUE(ask(request(), other).ok()) << "still there";
  EXPECT_EQ(reply.pose_world_camera(), other.pose_world_camera());
}

// The views that come with the grid tell how well its known surface was measured: the gain in quality that is answered is the
// one that they lead to, here summed up without the evaluator.
TEST(NbvPlannerService, QualityOfKnownSurfaceCountsFromTheViewsThatCameWithTheGrid) {
  // The middle of the face at +x is unknown; the face at +y was seen from afar and at a grazing angle.
  const auto state = [](int x, int y, int z) {
    const auto inside = [](int v, int margin) { return v >= margin && v < 15 - margin; };
    if (!inside(x, 2) || !inside(y, 2) || !inside(z, 2)) return voxel::VoxelState::empty;
    return x == 12 && inside(y, 5) && inside(z, 5) ? voxel::VoxelState::unknown : voxel::VoxelState::known;
  };
  Situation s = testing::around_the_origin(15, state);
  s.views = {look_at({2.2, 0.7, 1.2}, {0, 0, 1.1}), look_at({-1.0, 0.9, 1.2}, {0, 0, 1.1})};
  Settings settings;
  settings.evaluation.quality_weight = 1;
  RunningPlanner running("nbv_planner_quality_test", settings);
  auto& [service, planner, environments, objects, client] = running;
  ASSERT_TRUE(environments.publish(room()));
  const auto quality = [&](const char* object_id, const std::vector<Pose>& views, Pose& X_WC) {
    objects.publish(object_id, *s.grid, {}, views);
    msg::PlanViewRequest q = request();
    q.object_id(object_id);
    msg::PlanViewReply reply;
    const dds::RpcResult result = client.call(q, reply, {.deadline = 60s, .wait_for_server = 10s});
    EXPECT_TRUE(result.ok()) << result.error_message;
    X_WC = wire::from_wire(reply.pose_world_camera());
    for (const msg::NamedNumber& term : reply.terms()) {
      if (term.name() == "quality") return term.value();
    }
    ADD_FAILURE() << "no term of that name";
    return 0.0;
  };

  Pose X_WC;
  const double answered = quality("seen", s.views, X_WC);
  const std::vector<SurfaceVoxel> surface = known_surface(*s.grid);
  std::vector<Eigen::Vector3i> watched;
  std::vector<int> at(15 * 15 * 15, -1);
  for (std::size_t i = 0; i < surface.size(); ++i) {
    watched.push_back(s.grid->geometry().voxel_of(surface[i].p_W));
    at[surface[i].voxel] = static_cast<int>(i);
  }
  const voxel::VisibilityScene scene(*s.grid, {}, watched);
  const voxel::PairOptions pair = Evaluator(s, settings.evaluation, {}).settings().pair;
  const double reference = settings.evaluation.quality_reference;
  const std::vector<float> so_far = quality_so_far(surface, s, scene, pair, reference);
  EXPECT_GT(*std::max_element(so_far.begin(), so_far.end()), 0.1f) << "the views see something";
  voxel::VisibilityWorkspace w;
  scene.evaluate_pair(X_WC, s.rig, pair, w);
  double gain = 0, from_nothing = 0;
  for_each_watched(w, s.rig, pair.more_than_pixels, [&](std::uint32_t voxel) {
    const auto i = static_cast<std::size_t>(at.at(voxel));
    const double q = look_quality(surface.at(i), X_WC, s.rig.baseline, reference);
    gain += std::max(0.0, q - double(so_far[i]));
    from_nothing += q;
  });
  EXPECT_GT(gain, 1);
  EXPECT_LT(gain, from_nothing);
  EXPECT_NEAR(answered, gain, 1e-6 * gain);

  // Without views nothing is known of the surface's quality, and it does not count.
  EXPECT_EQ(quality("not-seen", {}, X_WC), 0);
}

TEST(NbvPlannerService, WhatIsHardToReachCosts) {
  // The patch is at one height; eyes above 1.2 m are hardly reached, less so looking down.
  const config::Node root = config::parse(
      "evaluation: {lambda_reach: 1}\nreachability: {heights_m: [1.0, 1.2, 1.25], pitches_deg: [0, 40], shares: [1, 0.6, 1, 0.6, 0.1, 0]}", "test.yaml");
  const Settings settings = read_settings(root);
  RunningPlanner running("nbv_planner_reachability_test", settings);
  auto& [service, planner, environments, objects, client] = running;
  ASSERT_TRUE(environments.publish(room()));
  objects.publish("block", *testing::patch_at_plus_x().grid);
  msg::PlanViewReply reply;
  msg::PlanViewRequest q = request();
  const dds::RpcResult result = client.call(q, reply, {.deadline = 60s, .wait_for_server = 10s});
  ASSERT_TRUE(result.ok()) << result.error_message;
  const Pose X_WC = wire::from_wire(reply.pose_world_camera());
  const double pitch = camera_yaw_pitch_roll(X_WC).y(), down = std::clamp(pitch / (40 * std::numbers::pi / 180), 0.0, 1.0);
  ASSERT_LE(X_WC.translation().z(), 1.2);
  for (const msg::NamedNumber& term : reply.terms()) {
    if (term.name() == "K_reach") {
      EXPECT_NEAR(term.value(), 0.4 * down, 1e-6);
    }
    if (term.name() == "lambda_reach") {
      EXPECT_GT(term.value(), 100);
    }
  }
  EXPECT_GT(reply.predicted_gain_voxels(), 200);
}

// What known_answers_test.cpp says of the search, over the wire.
TEST(NbvPlannerService, NothingLeftToSeeAndNothingThatCanBeReachedAreDifferentAnswers) {
  Settings settings;
  settings.revision_wait_s = 0.2;
  RunningPlanner running("nbv_planner_known_answers_test", settings);
  auto& [service, planner, environments, objects, client] = running;
  ASSERT_TRUE(environments.publish(room()));
  const auto answer = [&](const char* object_id, const voxel::OccupancyGrid& grid, msg::PlanViewReply& reply) {
    objects.publish(object_id, grid);
    msg::PlanViewRequest q = request();
    q.object_id(object_id);
    dds::RpcResult result;
    for (int i = 0; i < 50; ++i) {  // until it has arrived
      result = client.call(q, reply, {.deadline = 60s, .wait_for_server = 10s});
      if (static_cast<ErrorCode>(result.error_code) != ErrorCode::nbv_revision_not_here) break;
    }
    return result;
  };
  using voxel::VoxelState;
  for (const auto& [name, all] : {std::pair{"complete", VoxelState::known}, {"empty", VoxelState::empty}}) {
    msg::PlanViewReply reply;
    const dds::RpcResult result = answer(name, *testing::around_the_origin(15, [&](int, int, int) { return all; }).grid, reply);
    EXPECT_TRUE(result.ok()) << result.error_message;
    EXPECT_EQ(reply.predicted_gain_voxels(), 0) << name;
  }
  // A patch below the block: every eye is above it.
  msg::PlanViewReply reply;
  const dds::RpcResult result = answer(
      "below", *testing::around_the_origin(15, [](int, int, int z) { return z == 0 ? VoxelState::unknown : VoxelState::known; }).grid, reply);
  // Its sides show; closed by a known rim they do not.
  EXPECT_TRUE(result.ok()) << result.error_message;
  EXPECT_GT(reply.predicted_gain_voxels(), 0);
  const dds::RpcResult hidden = answer(
      "hidden", *testing::around_the_origin(15, [](int x, int y, int z) {
                  return z == 0 && x > 0 && x < 14 && y > 0 && y < 14 ? VoxelState::unknown : VoxelState::known;
                }).grid, reply);
  EXPECT_EQ(static_cast<ErrorCode>(hidden.error_code), ErrorCode::nbv_no_reachable_view) << reply.predicted_gain_voxels();
  EXPECT_NE(hidden.error_message.find("unknown voxels are left"), std::string::npos) << hidden.error_message;
}

}  // namespace
}  // namespace periplus::nbv
