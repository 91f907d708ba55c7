#include "services/supervisor/modeling_actions_service.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "common/core/clock.h"
#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/random.h"
#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "common/wire/object_wire.h"
#include "idl/motion.h"
#include "idl/nbv.h"
#include "idl/posture.h"
#include "idl/sim.h"
#include "idl/vision.h"
#include "idl/walk.h"

namespace periplus::supervisor {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

nlohmann::json pose2_json(const msg::Pose2& p) { return {p.x(), p.y(), p.yaw()}; }

voxel::Counts counts_of(const msg::GridCounts& c) { return {c.unknown(), c.known(), c.empty(), c.environment()}; }

// The service lacks the object's revision or the environment that it was asked about.
bool is_revision_not_here(ErrorCode code) {
  return code == ErrorCode::vision_revision_not_here || code == ErrorCode::nbv_revision_not_here || code == ErrorCode::posture_revision_not_here ||
         code == ErrorCode::walk_revision_not_here || code == ErrorCode::motion_revision_not_here;
}

// Throws Error(bad_input) unless the robot stands in the task's room and is the task's robot, as far as its driver knows.
void check_robot(const msg::RobotStateReply& robot, const msg::Environment& task) {
  const std::string scene = robot.scene_revision().to_string(), body = robot.robot_revision().to_string();
  const std::string remedy = "; bring the services up again with `periplus up` and this task, or run it on a domain of its own (--domain)";
  require(scene.empty() || scene == wire::scene_revision(scene::without_truth(wire::text_from_wire(task.scene_yaml()))), ErrorCode::bad_input,
          "the robot stands in scene " + robot.scene_id().to_string() + ", which is not the task's scene " + task.scene_id().to_string() +
              " (the texts differ)" + remedy);
  require(body.empty() || body == wire::robot_revision(wire::text_from_wire(task.robot_yaml()), wire::text_from_wire(task.robot_urdf())), ErrorCode::bad_input,
          "the robot that runs is not the task's: its YAML or URDF differs" + remedy);
}

}  // namespace

struct ModelingActions::Impl {
  Impl(dds::Node& node, const ActionSettings& s, const Task& t, const std::string& id, const msg::Environment& e, RunRecorder& rec, Whiteboard& board,
       Recording& caught, WriteQueue& queue, const Interruption& cut, std::function<void(msg::RunEvent)> send)
      : settings(s), task(t), run_id(id), environment(e), recorder(rec), whiteboard(board), recording(caught), writes(queue), interruption(cut), publish(std::move(send)),
        knowledge(node),
        robot_state(node, "robot/state"), set_environment(node, "model/set_environment"), begin(node, "model/begin"), capture(node, "vision/capture"), process(node, "vision/process"),
        integrate(node, "model/integrate"), model_publish(node, "model/publish"), model_export(node, "model/export"), model_digest(node, "model/digest"),
        plan_view(node, "nbv/plan"), posture(node, "posture/generate"), plan_walk(node, "walk/plan"), walk(node, "motion/walk"),
        set_posture(node, "motion/set_posture"), motion_state(node, "motion/state"), halt(node, "motion/halt"), stop_rule(t.stop),
        robot(robot::RobotModel::load(wire::text_from_wire(e.robot_urdf()), wire::text_from_wire(e.robot_yaml()))), box(t.box) {}

  ActionSettings settings;
  Task task;
  std::string run_id;
  msg::Environment environment;
  RunRecorder& recorder;
  Whiteboard& whiteboard;
  Recording& recording;
  WriteQueue& writes;                 // for what takes time: pictures and arrays
  const Interruption& interruption;
  std::function<void(msg::RunEvent)> publish;
  wire::Knowledge knowledge;

  dds::RpcClient<msg::RobotStateRequest, msg::RobotStateReply> robot_state;
  dds::RpcClient<msg::SetEnvironmentRequest, msg::SetEnvironmentReply> set_environment;
  dds::RpcClient<msg::BeginRequest, msg::BeginReply> begin;
  dds::RpcClient<msg::CaptureRequest, msg::CaptureReply> capture;
  dds::RpcClient<msg::ProcessRequest, msg::ProcessReply> process;
  dds::RpcClient<msg::IntegrateRequest, msg::IntegrateReply> integrate;
  dds::RpcClient<msg::PublishRequest, msg::PublishReply> model_publish;
  dds::RpcClient<msg::ExportRequest, msg::ExportReply> model_export;
  dds::RpcClient<msg::DigestRequest, msg::DigestReply> model_digest;
  dds::RpcClient<msg::PlanViewRequest, msg::PlanViewReply> plan_view;
  dds::RpcClient<msg::PostureRequest, msg::PostureReply> posture;
  dds::RpcClient<msg::WalkPlanRequest, msg::WalkPlanReply> plan_walk;
  dds::RpcClient<msg::WalkRequest, msg::MotionReply> walk;
  dds::RpcClient<msg::SetPostureRequest, msg::MotionReply> set_posture;
  dds::RpcClient<msg::MotionStateRequest, msg::MotionReply> motion_state;
  dds::RpcClient<msg::HaltRequest, msg::HaltReply> halt;

  StopRule stop_rule;
  std::shared_ptr<const robot::RobotModel> robot;
  Clock::time_point started = Clock::now();

  int look_number = 0;
  int attempt = 0;                    // counts plans, so that each has an id of its own
  int motions = 0;
  int forbidden_here = 0;             // at this look
  int lost_here = 0;                  // images or perceptions asked for again at this look
  msg::Revision environment_revision; // as the model server knows it
  std::uint32_t revision = 0;         // of the object
  object_model::ObjectBox box;        // of the object; the task's, or what the model server has let it grow to
  std::vector<Pose> forbidden;        // of the whole run
  LookRecord current;                 // of the look under way
  std::vector<LookRecord> looks;
  msg::PlanViewReply view;            // the next one
  msg::PostureReply next_posture;
  msg::WalkPlanReply steps;
  nlohmann::json path = nlohmann::json::array();
  std::string digest;

  std::string id(const char* what, int number) const { return run_id + "-" + what + std::to_string(number); }
  std::string view_id() const { return id("v", look_number); }

  // Calls and throws Error for whatever was not a good reply.
  template <class Client, class Req, class Rep>
  void call(Client& client, const char* rpc, Req& request, Rep& reply, double deadline_s) {
    dds::CallOptions options;
    options.deadline = milliseconds(deadline_s);
    options.wait_for_server = milliseconds(settings.wait_for_service_s);
    options.cancelled = [this] { return interruption.outcome().has_value(); };
    client.call(request, reply, options).throw_if_failed(rpc);
  }

  // As call(), for what needs the environment: a service that lacks it, or the object's revision, has them published again and
  // is asked once more.
  template <class Client, class Req, class Rep>
  void call_knowing(Client& client, const char* rpc, Req& request, Rep& reply, double deadline_s) {
    request.environment_revision(environment_revision);
    try {
      call(client, rpc, request, reply, deadline_s);
      return;
    } catch (const Error& e) {
      if (!is_revision_not_here(e.code())) throw;
      log::info("published again", {{"for", rpc}, {"because", e.what()}});
    }
    msg::PublishRequest again;
    msg::PublishReply published;
    again.object_id(task.object_id);
    call(model_publish, "model/publish", again, published, settings.request_deadline_s);
    call(client, rpc, request, reply, deadline_s);
  }

  // How long a look's files wait for what goes past on the topics.
  std::chrono::milliseconds patience() const { return interruption.hasty() ? 0s : 2s; }

  StereoRig rig() const { return robot->stereo_rig(); }
  // Forbids the pose of the present plan; no_view if that was one too many.
  Trigger forbid(Trigger otherwise) {
    forbidden.push_back(wire::from_wire(view.pose_world_camera()));
    nlohmann::json poses = nlohmann::json::array();
    for (const Pose& X : forbidden) poses.push_back(to_json(X));
    whiteboard.put("forbidden", poses);
    return ++forbidden_here >= task.most_forbidden ? Trigger::no_view : otherwise;
  }

  void record_motion(const char* what, const msg::MotionReply& reply) {
    whiteboard.put(what, {{"configuration", reply.configuration()}, {"left_foot", pose2_json(reply.left_foot())}, {"right_foot", pose2_json(reply.right_foot())}});
  }

  Outcome prepare();
  Outcome grab_images();
  Outcome half_sitting();
  Outcome process_images();
  Outcome integrate_view();
  Outcome next_view();
  Outcome generate_posture();
  Outcome plan_steps();
  Outcome do_walk();
  Outcome do_set_posture();
  Outcome do_halt();
  void publish_look();
};

ModelingActions::ModelingActions(dds::Node& node, const ActionSettings& settings, const Task& task, const std::string& run_id, const msg::Environment& environment,
                                 RunRecorder& recorder, Whiteboard& whiteboard, Recording& recording, WriteQueue& writes,
                                 const Interruption& interruption, std::function<void(msg::RunEvent)> publish)
    : impl_(std::make_unique<Impl>(node, settings, task, run_id, environment, recorder, whiteboard, recording, writes, interruption, std::move(publish))), interruption_(interruption) {}

ModelingActions::~ModelingActions() {
  try {
    impl_->writes.flush();  // its jobs use what ends here
  } catch (const std::exception& e) {
    log::error("a look's files could not be written", {{"cause", e.what()}});
  }
}

int ModelingActions::look() const { return impl_->look_number; }

Outcome ModelingActions::perform(State state) {
  const Clock::time_point start = Clock::now();
  Outcome outcome = act(state);
  impl_->current.seconds.emplace_back(to_string(state), seconds_since(start));
  if (state == State::integrate_view && outcome.trigger == Trigger::done) impl_->publish_look();
  return outcome;
}

Outcome ModelingActions::act(State state) {
  try {
    switch (state) {
      case State::prepare: return impl_->prepare();
      case State::grab_images: return impl_->grab_images();
      case State::set_half_sitting: return impl_->half_sitting();
      case State::process_images: return impl_->process_images();
      case State::integrate_view: return impl_->integrate_view();
      case State::next_view: return impl_->next_view();
      case State::generate_posture: return impl_->generate_posture();
      case State::plan_steps: return impl_->plan_steps();
      case State::walk: return impl_->do_walk();
      case State::set_posture: return impl_->do_set_posture();
      case State::return_half_sitting: return impl_->half_sitting();
      case State::halt: return impl_->do_halt();
      default: throw_error(ErrorCode::internal, std::string("no action for state ") + to_string(state));
    }
  } catch (const Error& e) {
    const std::string cause = std::string(periplus::to_string(e.code())) + ": " + e.what();
    log::warn("state failed", {{"state", to_string(state)}, {"cause", cause}});
    switch (e.code()) {
      case ErrorCode::cancelled:
      case ErrorCode::motion_halted:
        if (const auto cut = interruption_.outcome()) return *cut;
        return {Trigger::failed, cause};
      case ErrorCode::supervisor_service_lost:
      case ErrorCode::motion_robot_silent:
        return {Trigger::lost, cause};
      case ErrorCode::vision_view_unknown:
        if (state == State::process_images && ++impl_->lost_here <= 3) return {Trigger::view_lost, cause};
        break;
      case ErrorCode::model_perception_not_here:
        if (state == State::integrate_view && ++impl_->lost_here <= 3) return {Trigger::perception_lost, cause};
        break;
      case ErrorCode::bad_input:
      case ErrorCode::bad_size:
      case ErrorCode::not_finite:
        if (state == State::prepare) return {Trigger::refused, cause};
        break;
      case ErrorCode::nbv_no_reachable_view:
        if (state == State::next_view) {
          // After a view that was planned and reached, with none forbidden since: what is still unknown is out of reach, and
          // the promise of a next view is 0.
          const bool all_seen = impl_->look_number >= 2 && impl_->forbidden_here == 0;
          return {all_seen ? Trigger::gain_small : Trigger::no_view, cause};
        }
        break;
      case ErrorCode::posture_infeasible:
        if (state == State::generate_posture) return {impl_->forbid(Trigger::infeasible), cause};
        break;
      case ErrorCode::walk_no_path:
      case ErrorCode::walk_goal_in_collision:
        if (state == State::plan_steps) return {impl_->forbid(Trigger::no_path), cause};
        break;
      case ErrorCode::walk_start_in_collision:
        // What is known to be an obstacle is where the robot stands: the way to any other view begins there too.
        if (state == State::plan_steps) return {Trigger::no_view, cause};
        break;
      default: break;
    }
    return {Trigger::failed, cause};
  } catch (const std::exception& e) {
    log::error("state failed", {{"state", to_string(state)}, {"cause", e.what()}});
    return {Trigger::failed, e.what()};
  }
}

Outcome ModelingActions::Impl::prepare() {
  {
    msg::RobotStateRequest request;
    msg::RobotStateReply reply;
    call(robot_state, "robot/state", request, reply, settings.request_deadline_s);
    check_robot(reply, environment);
  }
  {
    msg::SetEnvironmentRequest request;
    msg::SetEnvironmentReply reply;
    request.environment(environment);
    call(set_environment, "model/set_environment", request, reply, settings.request_deadline_s);
    environment_revision = reply.revision();
  }
  msg::BeginRequest request;
  msg::BeginReply reply;
  request.object_id(task.object_id);
  request.box(wire::to_wire(task.box));
  request.voxel_m(task.voxel_m);
  // A run begins its object anew, in place of the one before. Not in place of one that cannot be read, whose views may be saved yet: asked
  // without `reset`, the model server refuses that.
  try {
    call(begin, "model/begin", request, reply, settings.request_deadline_s);
  } catch (const Error& e) {
    if (e.code() != ErrorCode::model_object_differs) throw;
  }
  request.reset(true);
  call(begin, "model/begin", request, reply, settings.request_deadline_s);
  revision = reply.revision();
  box = wire::from_wire(reply.box());
  if (revision > 0) {  // counting goes on where an object was known
    msg::RunEvent event;
    event.kind("note");
    event.state("prepare");
    event.text("object " + task.object_id + " was known to the model server: it is begun anew, the views of earlier runs are kept no longer");
    publish(event);
  }
  whiteboard.put("model", {{"object_id", task.object_id}, {"revision", revision}, {"unknown", reply.counts().unknown()}});
  return {};
}

Outcome ModelingActions::Impl::grab_images() {
  if (looks.size() == static_cast<std::size_t>(look_number)) ++look_number;  // not when a lost view is taken again
  forbidden_here = 0;
  msg::CaptureRequest request;
  msg::CaptureReply reply;
  request.view_id(view_id());
  call_knowing(capture, "vision/capture", request, reply, settings.request_deadline_s);
  current.look = look_number;
  current.X_WC = wire::from_wire(reply.pose_world_camera());
  whiteboard.put("view", {{"view_id", view_id()}, {"stamp_ns", reply.stamp_ns()}, {"attempts", reply.attempts()}});
  writes.add([this, look = look_number, stamp = reply.stamp_ns()] { recording.save_images(recorder, look, stamp, patience()); });
  return {};
}

Outcome ModelingActions::Impl::half_sitting() {
  const nlohmann::json recorded = whiteboard.get("half_sitting");
  if (recorded.is_null()) return {Trigger::done, "no half-sitting pose recorded yet, nothing to do"};
  msg::SetPostureRequest request;
  msg::MotionReply reply;
  request.motion_id(id("m", ++motions));
  request.configuration(recorded.at("configuration").get<std::vector<double>>());
  call_knowing(set_posture, "motion/set_posture", request, reply, settings.motion_deadline_s);
  record_motion("standing", reply);
  return {};
}

Outcome ModelingActions::Impl::process_images() {
  msg::ProcessRequest request;
  msg::ProcessReply reply;
  request.view_id(view_id());
  request.box(wire::to_wire(box));
  call_knowing(process, "vision/process", request, reply, settings.request_deadline_s);
  current.X_WC = wire::from_wire(reply.pose_world_camera());
  current.valid_share = reply.valid_share();
  current.valid_share_in_box = reply.valid_share_in_box();
  current.features = static_cast<int>(reply.features());
  for (const msg::NamedNumber& n : reply.seconds()) current.seconds.emplace_back("vision." + n.name().to_string(), n.value());
  writes.add([this, look = look_number, view = view_id()] { recording.save_perception(recorder, look, view, patience()); });
  return {};
}

Outcome ModelingActions::Impl::integrate_view() {
  msg::IntegrateRequest request;
  msg::IntegrateReply reply;
  request.object_id(task.object_id);
  request.view_id(view_id());
  call(integrate, "model/integrate", request, reply, settings.request_deadline_s);
  // Each view is a revision of its own. One that is not newer comes from a model in which earlier looks are missing.
  require(reply.revision() > revision, ErrorCode::internal,
          "the model came back with revision " + std::to_string(reply.revision()) + " after " + std::to_string(revision) +
              ": another model server or an older store has taken the view; leave one on this domain (`periplus status`)");
  revision = reply.revision();
  box = wire::from_wire(reply.box());
  current.counts = counts_of(reply.counts());
  current.found_gain_px = reply.found_gain_px();
  current.found_gain_voxels = reply.found_gain_voxels();
  for (const msg::NamedNumber& n : reply.seconds()) current.seconds.emplace_back("model." + n.name().to_string(), n.value());
  writes.add([this, look = look_number, wanted = revision] {
    if (const auto object = knowledge.object(task.object_id, wanted, patience())) recorder.save_grid(look, *object->grid);
  });
  whiteboard.put("model", {{"object_id", task.object_id}, {"revision", revision}, {"unknown", current.counts.unknown}, {"known", current.counts.known}});
  return {};
}

void ModelingActions::Impl::publish_look() {
  msg::RunEvent event;
  event.kind("look");
  event.state("integrate_view");
  event.look(static_cast<std::uint32_t>(look_number));
  auto& numbers = event.numbers();
  const auto add = [&](std::string_view name, double value) { numbers.push_back(wire::named(name, value)); };
  if (current.predicted_gain_px >= 0) {
    add("predicted_gain_px", current.predicted_gain_px);
    add("predicted_gain_voxels", current.predicted_gain_voxels);
  }
  add("found_gain_px", current.found_gain_px);
  add("found_gain_voxels", current.found_gain_voxels);
  add("known", static_cast<double>(current.counts.known));
  add("unknown", static_cast<double>(current.counts.unknown));
  add("valid_share", current.valid_share);
  const nlohmann::json record = RunRecorder::to_json(current);
  for (const auto& [name, value] : record.at("seconds").items())
    if (numbers.size() < 60) add("s." + name, value.get<double>());
  publish(event);
  recorder.save_look(current, rig());
  stop_rule.looked(current.predicted_gain_voxels, current.found_gain_voxels);
  looks.push_back(current);
  lost_here = 0;
  current = LookRecord{};
}

Outcome ModelingActions::Impl::next_view() {
  if (look_number >= task.stop.most_looks) return {Trigger::budget_spent, std::to_string(look_number) + " looks taken, the most allowed"};
  if (seconds_since(started) > task.stop.most_time_s) return {Trigger::budget_spent, "the time allowed is spent"};
  const robot::ViewLimits& limits = robot->view_limits();
  msg::PlanViewRequest request;
  request.plan_id(id("p", ++attempt));
  request.object_id(task.object_id);
  request.revision(revision);
  request.rig(wire::to_wire(rig()));
  request.pose_world_camera(wire::to_wire(looks.back().X_WC));
  for (const Pose& X : forbidden) request.forbidden().push_back(wire::to_wire(X));
  request.height_min_m(limits.height_min);
  request.height_max_m(limits.height_max);
  request.distance_min_m(limits.distance_min);
  request.distance_max_m(limits.distance_max);
  request.pitch_min_rad(limits.pitch_min);
  request.pitch_max_rad(limits.pitch_max);
  request.roll_max_rad(limits.roll_max);
  Random seeds(task.seed * 1000003u + static_cast<std::uint64_t>(attempt));
  request.seed(seeds.next());
  request.max_evaluations(0);
  request.time_limit_s(settings.view_time_limit_s);
  request.scatter(true);  // the view is the same, only sooner
  call_knowing(plan_view, "nbv/plan", request, view, settings.request_deadline_s);
  current.predicted_gain_px = view.predicted_gain_px();
  current.predicted_gain_voxels = view.predicted_gain_voxels();
  whiteboard.put("next_view", {{"pose_world_camera", to_json(wire::from_wire(view.pose_world_camera()))},
                               {"predicted_gain_px", view.predicted_gain_px()},
                               {"predicted_gain_voxels", view.predicted_gain_voxels()},
                               {"evaluations", view.evaluations()},
                               {"cut_short", view.cut_short()},
                               {"tasks", view.tasks()},
                               {"tasks_elsewhere", view.tasks_elsewhere()}});
  const Trigger verdict = stop_rule.judge(look_number, view.predicted_gain_voxels());
  std::string promise = "best view promises " + std::to_string(static_cast<long>(view.predicted_gain_voxels())) + " unknown voxels";
  const double trust = stop_rule.trust();
  if (trust < 1) promise += " (" + std::to_string(static_cast<long>(trust * view.predicted_gain_voxels())) + " by what the last looks found of their promises)";
  if (verdict == Trigger::gain_small) return {verdict, promise + ", less than " + std::to_string(static_cast<long>(task.stop.least_gain_voxels))};
  if (verdict == Trigger::converged) return {verdict, promise + ", as the last two did"};
  return {Trigger::done, promise};
}

Outcome ModelingActions::Impl::generate_posture() {
  msg::PostureRequest request;
  request.posture_id(id("q", attempt));
  request.object_id(task.object_id);
  request.revision(revision);
  request.pose_world_camera(view.pose_world_camera());
  call_knowing(posture, "posture/generate", request, next_posture, settings.request_deadline_s);
  whiteboard.put("posture", {{"configuration", next_posture.configuration()},
                             {"left_foot", pose2_json(next_posture.left_foot())},
                             {"right_foot", pose2_json(next_posture.right_foot())},
                             {"camera_error_m", next_posture.camera_error_m()},
                             {"camera_error_rad", next_posture.camera_error_rad()}});
  return {};
}

Outcome ModelingActions::Impl::plan_steps() {
  msg::MotionStateRequest ask;
  msg::MotionReply now;
  call(motion_state, "motion/state", ask, now, settings.request_deadline_s);
  msg::WalkPlanRequest request;
  request.plan_id(id("w", attempt));
  request.object_id(task.object_id);
  request.revision(revision);
  request.left_start(now.left_foot());
  request.right_start(now.right_foot());
  request.left_goal(next_posture.left_foot());
  request.right_goal(next_posture.right_foot());
  Random seeds(task.seed * 7919u + static_cast<std::uint64_t>(attempt));
  request.seed(seeds.next());
  call_knowing(plan_walk, "walk/plan", request, steps, settings.request_deadline_s);
  nlohmann::json step_list = nlohmann::json::array(), line = nlohmann::json::array();
  for (const msg::Step& s : steps.steps()) step_list.push_back({s.foot(), s.pose().x(), s.pose().y(), s.pose().yaw()});
  for (const msg::Pose2& p : steps.path()) line.push_back(pose2_json(p));
  whiteboard.put("steps", step_list);
  path.push_back({{"from_look", look_number}, {"path", line}, {"steps", step_list}, {"length_m", steps.length_m()}});
  return {Trigger::done, std::to_string(steps.steps().size()) + " steps, " + std::to_string(steps.length_m()).substr(0, 4) + " m"};
}

Outcome ModelingActions::Impl::do_walk() {
  msg::WalkRequest request;
  msg::MotionReply reply;
  request.motion_id(id("m", ++motions));
  request.steps(steps.steps());
  call_knowing(walk, "motion/walk", request, reply, settings.motion_deadline_s);
  // Where the walk ended is where the robot goes back to before it walks again.
  record_motion("half_sitting", reply);
  return {};
}

Outcome ModelingActions::Impl::do_set_posture() {
  const nlohmann::json wanted = whiteboard.get("posture");
  if (wanted.is_null()) return {Trigger::done, "no posture computed yet, looking from where the robot stands"};
  msg::SetPostureRequest request;
  msg::MotionReply reply;
  request.motion_id(id("m", ++motions));
  request.configuration(wanted.at("configuration").get<std::vector<double>>());
  call_knowing(set_posture, "motion/set_posture", request, reply, settings.motion_deadline_s);
  record_motion("looking", reply);
  current.configuration = reply.configuration();
  return {};
}

Outcome ModelingActions::Impl::do_halt() {
  msg::HaltRequest request;
  msg::HaltReply reply;
  dds::CallOptions options;
  options.deadline = interruption.hasty() ? 2s : 10s;   // a controller that ends with us halts by itself
  halt.call(request, reply, options).throw_if_failed("motion/halt");
  return {};
}

void ModelingActions::export_models() {
  Impl& i = *impl_;
  const auto hasty = [&i] { return i.interruption.hasty(); };
  for (const auto& [format, name] : {std::pair{"periplus", "model.periplus"}, {"ply", "model.ply"}, {"bt", "model.bt"}}) {
    try {
      bool saved = false;
      for (int attempt = 0; attempt < 2 && !saved && !hasty(); ++attempt) {  // the file goes out with each request: one lost sample is asked for again
        msg::ExportRequest request;
        msg::ExportReply reply;
        request.object_id(i.task.object_id);
        request.format(std::string(format));
        dds::CallOptions options;
        options.deadline = milliseconds(i.settings.request_deadline_s);
        options.wait_for_server = 2s;
        options.cancelled = hasty;
        i.model_export.call(request, reply, options).throw_if_failed("model/export");
        saved = i.recording.save_model(i.recorder, name, reply.sha256().to_string(), 5s);
      }
      if (!saved) log::warn("a model file did not arrive", {{"file", name}});
    } catch (const std::exception& e) {
      log::warn("a model file could not be exported", {{"file", name}, {"cause", e.what()}});
    }
  }
  if (hasty()) return;
  try {
    msg::DigestRequest request;
    msg::DigestReply reply;
    request.object_id(i.task.object_id);
    dds::CallOptions options;
    options.deadline = milliseconds(i.settings.request_deadline_s);
    options.cancelled = hasty;
    i.model_digest.call(request, reply, options).throw_if_failed("model/digest");
    i.digest = reply.digest().to_string();
  } catch (const std::exception& e) {
    log::warn("no digest of the model", {{"cause", e.what()}});
  }
}

nlohmann::json ModelingActions::report() const {
  const Impl& i = *impl_;
  nlohmann::json looks = nlohmann::json::array(), forbidden = nlohmann::json::array();
  for (const LookRecord& l : i.looks) looks.push_back(RunRecorder::to_json(l));
  for (const Pose& X : i.forbidden) forbidden.push_back(to_json(X));
  return {{"object_box", to_json(i.box)}, {"looks", looks}, {"views", i.looks.size()}, {"forbidden_poses", forbidden}, {"walks", i.path}, {"model_digest", i.digest}};
}

}  // namespace periplus::supervisor
