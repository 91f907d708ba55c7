#include "services/nbv_planner/nbv_planner_service.h"

#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "idl/nbv.h"
#include "services/nbv_planner/scattered_runner.h"
#include "services/nbv_planner/situation.h"
#include "services/nbv_planner/task_exchange_service.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::nbv {
namespace {

using Clock = std::chrono::steady_clock;

// A part of another's search is not worth a long wait: it is done there meanwhile.
constexpr double kPartWait_s = 0.2;
constexpr double kLongestTimeLimit_s = 3600;

// A situation with what can be made of it beforehand.
struct Prepared {
  explicit Prepared(Situation s, const Settings& settings)
      : situation(std::move(s)), evaluator(situation, settings.evaluation, settings.constraints) {}
  const Situation situation;
  const Evaluator evaluator;
};

// Bit for bit.
bool same(Evaluation a, Evaluation b) {
  Numbers x, y;
  append_numbers(a, x);
  append_numbers(b, y);
  return x == y;
}

// When the best so far is to come back; none: never.
std::optional<Clock::time_point> deadline_of(const msg::PlanViewRequest& q, Clock::time_point arrival) {
  const double limit = q.time_limit_s();
  require(std::isfinite(limit), ErrorCode::not_finite, "time_limit_s must be finite");
  require(limit >= 0 && limit <= kLongestTimeLimit_s, ErrorCode::bad_input,
          "time_limit_s must lie in 0 (none) to " + std::to_string(static_cast<int>(kLongestTimeLimit_s)));
  if (limit == 0) return std::nullopt;
  return arrival + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit));
}

}  // namespace

struct NbvPlannerService::Impl {
  Impl(service::Service& service, const Settings& s) : settings(s), knowledge(service.node()) {
    exchange = std::make_unique<TaskExchange>(service, settings.alike, settings.search.threads, [this](const msg::PlanViewRequest& q) {
      return [this, q, ready = prepare(q, kPartWait_s)](TaskRunner& runner) {
        plan_view(ready->evaluator, q.seed(), search_settings(q), runner);
      };
    });
    server = service.serve<msg::PlanViewRequest, msg::PlanViewReply>(
        "nbv/plan", [this](const msg::PlanViewRequest& q, msg::PlanViewReply& r, dds::RpcContext& c) { plan(q, r, c); });
  }

  Situation situation_of(const msg::PlanViewRequest& q, double wait_s) const;
  std::shared_ptr<const Prepared> prepare(const msg::PlanViewRequest& q, double wait_s);
  SearchSettings search_settings(const msg::PlanViewRequest& q) const;
  void plan(const msg::PlanViewRequest& q, msg::PlanViewReply& r, dds::RpcContext& context);

  Settings settings;
  wire::Knowledge knowledge;
  // The newest, for the parts of one search are asked for one after the other.
  std::mutex mutex;
  msg::PlanViewRequest prepared_for;
  std::shared_ptr<const Prepared> prepared;
  std::unique_ptr<TaskExchange> exchange;
  std::shared_ptr<dds::RpcServer<msg::PlanViewRequest, msg::PlanViewReply>> server;  // last: stops first
};

Situation NbvPlannerService::Impl::situation_of(const msg::PlanViewRequest& q, double wait_s) const {
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
  const auto wait = std::chrono::milliseconds(static_cast<long>(wait_s * 1000));
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
  s.views = object->views;
  s.scene = environment->scene;
  s.collision = environment->collision;
  s.body = environment->robot->body_box();
  s.reachability = settings.reachability;
  check(s);
  return s;
}

std::shared_ptr<const Prepared> NbvPlannerService::Impl::prepare(const msg::PlanViewRequest& q, double wait_s) {
  Situation situation = situation_of(q, wait_s);
  msg::PlanViewRequest key = q;
  key.header({});
  {
    const std::lock_guard lock(mutex);
    // The same request about the same model: a revision's number may return with another model behind it.
    if (prepared && prepared_for == key && prepared->situation.grid == situation.grid &&
        prepared->situation.collision == situation.collision) {
      return prepared;
    }
  }
  const auto made = std::make_shared<const Prepared>(std::move(situation), settings);
  const std::lock_guard lock(mutex);
  prepared_for = key;
  prepared = made;
  return made;
}

SearchSettings NbvPlannerService::Impl::search_settings(const msg::PlanViewRequest& q) const {
  SearchSettings search = settings.search;
  if (q.max_evaluations() > 0) search.max_evaluations = static_cast<int>(std::min(q.max_evaluations(), 1000000u));
  return search;
}

void NbvPlannerService::Impl::plan(const msg::PlanViewRequest& q, msg::PlanViewReply& r, dds::RpcContext& context) {
  const auto start = Clock::now();
  const auto deadline = deadline_of(q, start);
  const auto ready = prepare(q, settings.revision_wait_s);
  const std::chrono::duration<double> waited = Clock::now() - start;
  const SearchSettings search = search_settings(q);
  const auto poll = [&](double share) {
    context.throw_if_cancelled();
    context.progress(share, "searching the next best view");
  };
  ScatteredRunner runner(search.threads, q.scatter() ? exchange->others(q, settings.other_instances) : std::vector<std::unique_ptr<OtherInstance>>{}, deadline);
  PlannedView view = plan_view(ready->evaluator, q.seed(), search, runner, poll);
  r.tasks(static_cast<std::uint32_t>(runner.tasks()));
  r.tasks_elsewhere(static_cast<std::uint32_t>(runner.tasks_elsewhere()));
  if (runner.tasks_elsewhere() > 0) {
    Evaluator::Workspace workspace;
    if (!same(ready->evaluator.evaluate(view.X_WC, workspace), view.evaluation)) {
      log::error("another planner computes something else; planned again alone", {{"plan", q.plan_id().to_string()}});
      ThreadRunner alone(search.threads, deadline);
      view = plan_view(ready->evaluator, q.seed(), search, alone, poll);
      r.tasks_elsewhere(0);
    }
  }
  const Evaluation& e = view.evaluation;
  r.pose_world_camera(wire::to_wire(view.X_WC));
  r.predicted_gain_px(static_cast<double>(e.gain.pixels));
  r.predicted_gain_voxels(e.gain.voxels);
  r.score(-view.f_e);
  r.evaluations(static_cast<std::uint32_t>(view.evaluations));
  r.landmark_term(view.landmark_term);
  r.cut_short(view.cut_short);
  for (const auto& [name, value] : view.terms) r.terms().push_back(wire::named(name, value));
  r.seconds().push_back(wire::named("wait", waited.count()));
  for (const auto& [name, value] : view.seconds) r.seconds().push_back(wire::named(name, value));
  log::info("view planned", {{"plan", q.plan_id().to_string()},
                             {"gain_voxels", std::to_string(e.gain.voxels)},
                             {"gain_px", std::to_string(e.gain.pixels)},
                             {"f_e", std::to_string(view.f_e)},
                             {"evaluations", std::to_string(view.evaluations)},
                             {"tasks", std::to_string(r.tasks())},
                             {"tasks_elsewhere", std::to_string(r.tasks_elsewhere())}});
}

NbvPlannerService::NbvPlannerService(service::Service& service, const Settings& settings)
    : impl_(std::make_unique<Impl>(service, settings)) {}
NbvPlannerService::~NbvPlannerService() = default;

}  // namespace periplus::nbv
