#include "services/nbv_planner/nbv_planner_service.h"

#include <chrono>
#include <string>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "idl/nbv.h"
#include "services/nbv_planner/situation.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {

struct NbvPlannerService::Impl {
  Impl(service::Service& service, const Settings& s) : settings(s), knowledge(service.node()) {
    server = service.serve<msg::PlanViewRequest, msg::PlanViewReply>(
        "nbv/plan", [this](const msg::PlanViewRequest& q, msg::PlanViewReply& r, dds::RpcContext& c) { plan(q, r, c); });
  }

  Situation situation_of(const msg::PlanViewRequest& q) const;
  void plan(const msg::PlanViewRequest& q, msg::PlanViewReply& r, dds::RpcContext& context) const;

  Settings settings;
  wire::Knowledge knowledge;
  std::shared_ptr<dds::RpcServer<msg::PlanViewRequest, msg::PlanViewReply>> server;  // last: stops first
};

Situation NbvPlannerService::Impl::situation_of(const msg::PlanViewRequest& q) const {
  Situation s;
  wire::id_from_wire(q.plan_id(), "plan_id");
  const std::string object_id = wire::id_from_wire(q.object_id(), "object_id");
  s.rig = wire::from_wire(q.rig());
  s.X_WC_now = wire::from_wire(q.pose_world_camera());
  for (const msg::Pose& pose : q.forbidden()) s.forbidden.push_back(wire::from_wire(pose));
  s.limits = {.height_min = q.height_min_m(), .height_max = q.height_max_m(), .pitch_min = q.pitch_min_rad(),
              .pitch_max = q.pitch_max_rad(), .roll_max = q.roll_max_rad(),
              .distance_min = q.distance_min_m(),
              .distance_max = q.distance_max_m()};
  if (q.yaw_min_rad() != 0 || q.yaw_max_rad() != 0) {
    s.limits.yaw_min = q.yaw_min_rad();
    s.limits.yaw_max = q.yaw_max_rad();
  }
  const auto wait = std::chrono::milliseconds(static_cast<long>(settings.revision_wait_s * 1000));
  const auto object = knowledge.object(object_id, q.revision(), wait);
  if (!object) {
    throw_error(ErrorCode::nbv_revision_not_here, "revision " + std::to_string(q.revision()) + " of object '" + object_id +
                                                      "' has not arrived here; have it published again (model/publish) "
                                                      "or ask another planner");
  }
  const auto environment =
      knowledge.environment_or_throw(wire::id_from_wire(q.environment_revision(), "environment_revision"), ErrorCode::nbv_revision_not_here, wait);
  s.grid = object->grid;
  s.landmarks = object->landmarks;
  s.scene = environment->scene;
  s.collision = environment->collision;
  s.body = environment->robot->body_box();
  check(s);
  return s;
}

void NbvPlannerService::Impl::plan(const msg::PlanViewRequest& q, msg::PlanViewReply& r, dds::RpcContext& context) const {
  const auto start = std::chrono::steady_clock::now();
  const Situation situation = situation_of(q);
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - start;
  SearchSettings search = settings.search;
  if (q.max_evaluations() > 0) search.max_evaluations = static_cast<int>(std::min(q.max_evaluations(), 1000000u));
  const PlannedView view =
      plan_view(situation, q.seed(), search, settings.evaluation, settings.constraints, [&](double share) {
        context.throw_if_cancelled();
        context.progress(share, "searching the next best view");
      });
  const Evaluation& e = view.evaluation;
  r.pose_world_camera(wire::to_wire(view.X_WC));
  r.predicted_gain_px(static_cast<double>(e.gain.pixels));
  r.predicted_gain_voxels(e.gain.voxels);
  r.score(-view.f_e);
  r.evaluations(static_cast<std::uint32_t>(view.evaluations));
  r.landmark_term(view.landmark_term);
  for (const auto& [name, value] : view.terms) r.terms().push_back(wire::named(name, value));
  r.seconds().push_back(wire::named("wait", waited.count()));
  for (const auto& [name, value] : view.seconds) r.seconds().push_back(wire::named(name, value));
  log::info("view planned", {{"plan", q.plan_id().to_string()},
                             {"gain_voxels", std::to_string(e.gain.voxels)},
                             {"gain_px", std::to_string(e.gain.pixels)},
                             {"f_e", std::to_string(view.f_e)},
                             {"evaluations", std::to_string(view.evaluations)}});
}

NbvPlannerService::NbvPlannerService(service::Service& service, const Settings& settings)
    : impl_(std::make_unique<Impl>(service, settings)) {}
NbvPlannerService::~NbvPlannerService() = default;

}  // namespace periplus::nbv
