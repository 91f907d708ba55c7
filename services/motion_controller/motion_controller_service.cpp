#include "services/motion_controller/motion_controller_service.h"

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/core/clock.h"
#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/dds/rpc.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "idl/motion.h"
#include "idl/sim.h"
#include "services/motion_controller/motion_memory.h"
#include "services/motion_controller/step_recovery.h"
#include "services/motion_controller/walk_motion.h"

namespace periplus::motion {
namespace {

using Clock = std::chrono::steady_clock;

RobotReport report_from_wire(const msg::RobotState& s) {
  RobotReport r;
  r.tick = s.tick();
  r.joints = wire::vector_from_wire(s.positions(), "positions of the robot's state");
  r.X_base = wire::from_wire(s.pose_world_base());
  r.X_left = wire::from_wire(s.pose_world_left_foot());
  r.X_right = wire::from_wire(s.pose_world_right_foot());
  r.fallen = s.fallen();
  return r;
}

// What distinguishes one request from another of the same id, to the bit.
std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%a ", value);
  return text;
}

class DdsRobotLink : public RobotLink {
 public:
  explicit DdsRobotLink(dds::Node& node)
      : commands_(node, "periplus/robot/command", dds::qos_stream(16)),
        states_(node, "periplus/robot/state", dds::qos_stream(16), [this](const msg::RobotState& s) { take(s); }) {}

  void send(std::uint64_t tick, int support, const Eigen::VectorXd& joints) override {
    msg::RobotCommand command;
    command.tick(tick);
    command.support(static_cast<std::uint8_t>(support));
    command.positions(wire::vector_to_wire(joints));
    commands_.publish(command);
  }

  std::optional<RobotReport> wait(std::uint64_t tick, double resend_after) override {
    std::unique_lock lock(mutex_);
    const bool came =
        arrived_.wait_for(lock, milliseconds(resend_after), [this, tick] { return newest_ && newest_->tick >= tick; });
    return came ? newest_ : std::nullopt;
  }

  // A robot that was started anew counts from 0: what the former one said no longer holds.
  void forget() {
    const std::lock_guard lock(mutex_);
    newest_.reset();
  }

 private:
  void take(const msg::RobotState& state) {
    try {
      RobotReport report = report_from_wire(state);
      {
        const std::lock_guard lock(mutex_);
        if (newest_ && report.tick < newest_->tick) return;
        newest_ = std::move(report);
      }
      arrived_.notify_all();
    } catch (const Error& e) {
      log::warn("a state of the robot cannot be used", {{"why", e.what()}});
    }
  }

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::optional<RobotReport> newest_;
  dds::Publisher<msg::RobotCommand> commands_;
  dds::Subscriber<msg::RobotState> states_;  // last: its thread uses all the others
};

}  // namespace

MotionSettings read_settings(const config::Node& configuration) {
  MotionSettings s;
  const config::Node gait = configuration.child("gait");
  gait.read("single_support_s", s.gait.single_support);
  gait.read("double_support_s", s.gait.double_support);
  gait.read("first_hold_s", s.gait.first_hold);
  gait.read("end_double_support_s", s.gait.end_double_support);
  gait.read("settle_s", s.gait.settle);
  gait.read("step_height_m", s.gait.step_height);
  gait.read("zmp_ahead_m", s.gait.zmp_ahead);
  gait.read("preview_s", s.gait.preview.preview, {.minimum = 0.1, .maximum = 10});
  gait.read("error_weight", s.gait.preview.error_weight, {.minimum = 1e-12});
  gait.read("jerk_weight", s.gait.preview.jerk_weight, {.minimum = 1e-15});
  s.gait.check();
  const config::Node posture = configuration.child("posture");
  posture.read("least_duration_s", s.posture.least_duration);
  posture.read("com_speed_m_per_s", s.posture.com_speed);
  posture.read("waist_speed_rad_per_s", s.posture.waist_speed);
  posture.read("joint_speed_rad_per_s", s.posture.joint_speed);
  posture.read("halt_duration_s", s.posture.halt_duration);
  posture.read("foot_tolerance_m", s.posture.foot_tolerance);
  posture.read("foot_tolerance_rad", s.posture.foot_tolerance_rad);
  s.posture.check();
  configuration.read("joint_speed_share", s.limits.speed_share, {.minimum = 0.01, .maximum = 1});
  const config::Node robot = configuration.child("robot");
  robot.read("resend_after_s", s.lockstep.resend_after);
  robot.read("silent_after_s", s.lockstep.silent_after);
  robot.read("tracking_tolerance_rad", s.lockstep.tracking_tolerance);
  robot.read("deadline_s", s.robot_deadline, {.minimum = 0.1});
  s.lockstep.check();
  return s;
}

struct MotionControllerService::Impl {
  Impl(service::Service& life, const MotionSettings& s)
      : settings(s), service(life), knowledge(life.node()), link(life.node()), robot_state(life.node(), "robot/state") {
    walk = life.serve<msg::WalkRequest, msg::MotionReply>(
        "motion/walk", [this](const msg::WalkRequest& q, msg::MotionReply& r, dds::RpcContext& c) { on_walk(q, r, c); },
        {.threads = 2});
    set_posture = life.serve<msg::SetPostureRequest, msg::MotionReply>(
        "motion/set_posture",
        [this](const msg::SetPostureRequest& q, msg::MotionReply& r, dds::RpcContext& c) { on_posture(q, r, c); },
        {.threads = 2});
    state = life.serve<msg::MotionStateRequest, msg::MotionReply>(
        "motion/state", [this](const msg::MotionStateRequest&, msg::MotionReply& r, dds::RpcContext&) { on_state(r); });
    halt = life.serve<msg::HaltRequest, msg::HaltReply>(
        "motion/halt", [this](const msg::HaltRequest&, msg::HaltReply& r, dds::RpcContext&) { on_halt(r); });
  }

  // --- the four requests

  void on_walk(const msg::WalkRequest& request, msg::MotionReply& reply, dds::RpcContext& context) {
    const std::string id = wire::id_from_wire(request.motion_id(), "motion_id");
    const std::string environment = wire::id_from_wire(request.environment_revision(), "environment_revision");
    std::vector<Step> steps;
    std::string content = "walk ";
    for (const msg::Step& s : request.steps()) {
      steps.push_back({s.foot(), wire::from_wire(s.pose())});
      content += std::to_string(s.foot()) + " " + exact(s.pose().x()) + exact(s.pose().y()) + exact(s.pose().yaw());
    }
    answer(reply, perform(id, content, context, [&](MotionResult& result) { do_walk(environment, steps, result, context); }));
  }

  void on_posture(const msg::SetPostureRequest& request, msg::MotionReply& reply, dds::RpcContext& context) {
    const std::string id = wire::id_from_wire(request.motion_id(), "motion_id");
    const std::string environment = wire::id_from_wire(request.environment_revision(), "environment_revision");
    const Eigen::VectorXd goal = wire::vector_from_wire(request.configuration(), "configuration");
    std::string content = "posture ";
    for (const double x : request.configuration()) content += exact(x);
    answer(reply, perform(id, content, context, [&](MotionResult& result) {
             const auto begin = Clock::now();
             const auto model = robot_model(environment);
             const RobotReport now = robot_now(*model);
             PostureMotion motion(model, now.configuration(), goal, settings.posture, settings.limits);
             result.plan_seconds = seconds_since(begin);
             run(motion, now, *model, result, context);
           }));
  }

  void on_state(msg::MotionReply& reply) {
    const RobotReport now = ask_robot();
    reply.configuration(wire::vector_to_wire(now.configuration()));
    reply.left_foot(wire::to_wire(to_pose2(now.X_left)));
    reply.right_foot(wire::to_wire(to_pose2(now.X_right)));
    reply.ticks(now.tick);
  }

  void on_halt(msg::HaltReply& reply) {
    reply.was_moving(memory.ask_to_halt());
    if (!reply.was_moving()) return;
    require(memory.wait_until_still(kHaltDeadline), ErrorCode::motion_robot_silent,
            "the robot has not come to a stand; see whether it still answers");
  }

  // --- how they are done

  // Once for each id.
  MotionResult perform(const std::string& id, const std::string& content, dds::RpcContext& context,
                       const std::function<void(MotionResult&)>& work) {
    if (const std::optional<MotionResult> before = memory.begin(id, content)) return *before;
    MotionResult result;
    try {
      context.progress(0, "planning");
      work(result);
    } catch (const Error& e) {
      result.error = e.code();
      result.message = e.what();
    } catch (const std::exception& e) {
      result.error = ErrorCode::internal;
      result.message = e.what();
    }
    memory.finish(result);
    log::info("motion done", {{"motion_id", id},
                              {"error", to_string(result.error)},
                              {"message", result.message},
                              {"ticks", std::to_string(result.ticks)},
                              {"plan_s", std::to_string(result.plan_seconds)},
                              {"execute_s", std::to_string(result.execute_seconds)}});
    return result;
  }

  void do_walk(const std::string& environment, std::vector<Step> steps, MotionResult& result, dds::RpcContext& context) {
    const auto begin = Clock::now();
    const auto model = robot_model(environment);
    RobotReport now = robot_now(*model);
    // A controller that was started anew in the middle of a walk takes it up where the robot stands.
    const WalkPlace place = find_place(steps, now.X_left, now.X_right);
    if (place.lifted) {
      LandFoot landing(model, now.configuration(), *place.lifted, steps[place.done - 1].sole, settings.gait,
                       settings.limits);
      run(landing, now, *model, result, context);
      now = robot_now(*model);
    }
    steps.erase(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(place.done));
    WalkMotion motion(model, now.configuration(), steps, settings.gait, settings.posture, settings.limits);
    result.plan_seconds = seconds_since(begin) - result.execute_seconds;
    run(motion, now, *model, result, context);
  }

  void run(Trajectory& motion, const RobotReport& now, const robot::RobotModel& model, MotionResult& result,
           dds::RpcContext& context) {
    const auto begin = Clock::now();
    const Execution done = execute(
        motion, now, link, model, settings.lockstep,
        [&] { return memory.halt_asked() || context.cancelled() || service.stopping(); },
        [&](std::size_t executed) { context.progress(motion.fraction(executed), motion.describe(executed)); });
    result.execute_seconds += seconds_since(begin);
    result.configuration = done.report.configuration();
    result.left = to_pose2(done.report.X_left);
    result.right = to_pose2(done.report.X_right);
    result.ticks += done.commands;
    require(!done.halted, ErrorCode::motion_halted,
            "the motion was halted after " + std::to_string(done.commands) + " ticks; the robot stands");
  }

  void answer(msg::MotionReply& reply, const MotionResult& result) {
    if (result.error != ErrorCode::ok) throw Error(result.error, result.message);
    reply.configuration(wire::vector_to_wire(result.configuration));
    reply.left_foot(wire::to_wire(result.left));
    reply.right_foot(wire::to_wire(result.right));
    reply.ticks(result.ticks);
    reply.seconds() = {wire::named("plan", result.plan_seconds), wire::named("execute", result.execute_seconds)};
  }

  std::shared_ptr<const robot::RobotModel> robot_model(const std::string& environment_revision) const {
    return knowledge.environment_or_throw(environment_revision, ErrorCode::motion_revision_not_here)->robot;
  }

  RobotReport ask_robot() {
    msg::RobotStateRequest request;
    msg::RobotStateReply reply;
    dds::CallOptions options;
    options.deadline = milliseconds(settings.robot_deadline);
    options.wait_for_server = milliseconds(settings.robot_deadline);
    const dds::RpcResult called = robot_state.call(request, reply, options);
    if (called.status != dds::RpcStatus::ok)
      throw_error(ErrorCode::motion_robot_silent, std::string("the robot does not answer robot/state (") +
                                                      dds::to_string(called.status) +
                                                      "); is its driver or the simulator running?");
    called.throw_if_failed("robot/state");
    return report_from_wire(reply.state());
  }

  RobotReport robot_now(const robot::RobotModel& model) {
    link.forget();
    const RobotReport now = ask_robot();
    require(!now.fallen, ErrorCode::motion_robot_fault, "the robot has fallen; set it upright and start it anew");
    require(now.joints.size() == static_cast<Eigen::Index>(model.joints().size()), ErrorCode::motion_robot_fault,
            "the robot reports " + std::to_string(now.joints.size()) + " joints, its model has " +
                std::to_string(model.joints().size()) + "; use the same robot YAML for both");
    return now;
  }

  static constexpr double kHaltDeadline = 30;  // [s]

  MotionSettings settings;
  service::Service& service;
  wire::Knowledge knowledge;
  MotionMemory memory;
  DdsRobotLink link;
  dds::RpcClient<msg::RobotStateRequest, msg::RobotStateReply> robot_state;
  std::shared_ptr<dds::RpcServer<msg::WalkRequest, msg::MotionReply>> walk;
  std::shared_ptr<dds::RpcServer<msg::SetPostureRequest, msg::MotionReply>> set_posture;
  std::shared_ptr<dds::RpcServer<msg::MotionStateRequest, msg::MotionReply>> state;
  std::shared_ptr<dds::RpcServer<msg::HaltRequest, msg::HaltReply>> halt;
};

MotionControllerService::MotionControllerService(service::Service& service, const MotionSettings& settings)
    : impl_(std::make_unique<Impl>(service, settings)) {}
MotionControllerService::~MotionControllerService() = default;

}  // namespace periplus::motion
