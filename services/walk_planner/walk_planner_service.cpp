#include "services/walk_planner/walk_planner_service.h"

#include <chrono>
#include <cmath>
#include <string>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "idl/walk.h"

namespace periplus::walk {
namespace {

StepRegion read_region(const config::Node& node, StepRegion region) {
  node.read("x_min_m", region.x_min, {.maximum = 0});
  node.read("x_max_m", region.x_max, {.minimum = 0});
  node.read("y_min_m", region.y_min, {.minimum = 0});
  node.read("y_max_m", region.y_max, {.minimum = 0});
  node.read("yaw_out_rad", region.yaw_out, {.minimum = 0});
  node.read("yaw_in_rad", region.yaw_in, {.minimum = 0});
  return region;
}

}  // namespace

WalkSettings read_settings(const config::Node& configuration) {
  WalkSettings s;
  const config::Node path = configuration.child("path");
  path.read("yaw_weight_m_per_rad", s.path.yaw_weight, {.minimum = 0.01});
  path.read("extension_m", s.path.extension, {.minimum = 0.01});
  path.read("check_distance_m", s.path.check_distance, {.minimum = 0.001});
  path.read("check_angle_rad", s.path.check_angle, {.minimum = 0.001});
  path.read("samples", s.path.samples, {.minimum = 1, .maximum = 1e6});
  path.read("shortcuts", s.path.shortcuts, {.minimum = 0, .maximum = 1e6});
  path.read("end_radius_m", s.path.end_radius, {.minimum = 0});
  path.read("end_shrink_m", s.path.end_shrink, {.minimum = 0});
  s.path.check();
  s.steps.step = read_region(configuration.child("step"), s.steps.step);
  s.steps.posture = read_region(configuration.child("posture"), s.steps.posture);
  configuration.read("clearance_m", s.steps.clearance, {.minimum = 0});
  configuration.read("most_steps", s.steps.most_steps, {.minimum = 1, .maximum = 1024});
  s.steps.check();
  return s;
}

struct WalkPlannerService::Impl {
  Impl(service::Service& service, const WalkSettings& s) : settings(s), knowledge(service.node()) {
    server = service.serve<msg::WalkPlanRequest, msg::WalkPlanReply>(
        "walk/plan",
        [this](const msg::WalkPlanRequest& q, msg::WalkPlanReply& r, dds::RpcContext& c) { plan(q, r, c); });
  }

  void plan(const msg::WalkPlanRequest& request, msg::WalkPlanReply& reply, dds::RpcContext& context) {
    const auto begin = std::chrono::steady_clock::now();
    const std::string plan_id = wire::id_from_wire(request.plan_id(), "plan_id");
    const std::string object_id = wire::id_from_wire(request.object_id(), "object_id", true);
    const Feet start{wire::from_wire(request.left_start()), wire::from_wire(request.right_start())};
    const Feet goal{wire::from_wire(request.left_goal()), wire::from_wire(request.right_goal())};

    const auto environment = knowledge.environment_or_throw(
        wire::id_from_wire(request.environment_revision(), "environment_revision"), ErrorCode::walk_revision_not_here);
    std::shared_ptr<const wire::KnownObject> object;
    if (!object_id.empty()) {
      object = knowledge.object(object_id, request.revision());
      require(object != nullptr, ErrorCode::walk_revision_not_here,
              "revision " + std::to_string(request.revision()) + " of object " + object_id +
                  " has not arrived; have it published with model/publish and ask again");
    }
    context.throw_if_cancelled();

    const Eigen::Vector2d half_room = 0.5 * environment->scene.room.size.head<2>();
    const FloorSpace floor(environment->collision, environment->robot->body_box(),
                           object ? object->grid.get() : nullptr, -half_room, half_room);
    const WalkPlan plan =
        plan_walk(floor, half_stance_width(environment->robot), start, goal, request.seed(), settings);

    reply.steps().clear();
    for (const Footstep& step : plan.steps) {
      msg::Step s;
      s.foot(step.left ? 0 : 1);
      s.pose(wire::to_wire(step.sole));
      reply.steps().push_back(s);
    }
    reply.path().clear();
    for (const Pose2& p : plan.path) reply.path().push_back(wire::to_wire(p));
    reply.length_m(plan.length);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    reply.seconds() = {wire::named("plan", seconds)};
    log::info("walk planned", {{"plan_id", plan_id},
                               {"steps", std::to_string(plan.steps.size())},
                               {"length_m", std::to_string(plan.length)},
                               {"samples", std::to_string(plan.samples)},
                               {"seconds", std::to_string(seconds)}});
  }

  WalkSettings settings;
  wire::Knowledge knowledge;
  std::shared_ptr<dds::RpcServer<msg::WalkPlanRequest, msg::WalkPlanReply>> server;
};

WalkPlannerService::WalkPlannerService(service::Service& service, const WalkSettings& settings)
    : impl_(std::make_unique<Impl>(service, settings)) {}
WalkPlannerService::~WalkPlannerService() = default;

}  // namespace periplus::walk
