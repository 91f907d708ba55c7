#include "integration-tests/failures/scripted_services.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include "common/core/clock.h"
#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/service/service_names.h"
#include "common/voxel/occupancy_grid.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_publisher.h"
#include "common/wire/object_wire.h"
#include "common/wire/perception_wire.h"
#include "idl/common.h"
#include "idl/model.h"
#include "idl/motion.h"
#include "idl/nbv.h"
#include "idl/posture.h"
#include "idl/ros2.h"
#include "idl/sim.h"
#include "idl/vision.h"
#include "idl/walk.h"

namespace periplus::failures {

using namespace std::chrono_literals;

namespace {
using RosImage = sensor_msgs::msg::dds_::Image_;
}  // namespace

struct ScriptedServices::Impl {
  struct Failure {
    ErrorCode code;
    std::string sentence;
    int first, last;
  };

  Impl(dds::Node& n, std::shared_ptr<const robot::RobotModel> m, std::set<std::string> without)
      : node(n),
        model(std::move(m)),
        absent(std::move(without)),
        left(node, "rt/stereo/left/image_raw", dds::qos_stream(8)),
        right(node, "rt/stereo/right/image_raw", dds::qos_stream(8)),
        wide(node, "rt/wide/image_raw", dds::qos_stream(8)),
        perceptions(node, "periplus/perception", dds::qos_latest(8)),
        objects(node),
        statuses(node, "periplus/service/status", dds::qos_latest(1)) {}

  template <class Request, class Reply, class Fill>
  void offer(const std::string& rpc, Fill fill) {
    if (absent.contains(rpc)) return;
    servers.push_back(std::make_shared<dds::RpcServer<Request, Reply>>(
        node, rpc, [this, rpc, fill](const Request& q, Reply& r, dds::RpcContext& context) {
          take(rpc, context, [&] { record(q); });
          const std::lock_guard lock(mutex);
          fill(q, r);
        }));
  }

  template <class Request>
  void record(const Request& q) {
    if constexpr (requires { q.environment_revision(); }) environment_revisions.insert(q.environment_revision().to_string());
    note(q);
  }
  template <class Request>
  void note(const Request&) {}
  void note(const msg::SetPostureRequest& q) { postures.push_back(q.configuration()); }
  void note(const msg::BeginRequest& q) { resets.push_back(q.reset()); }
  void note(const msg::PlanViewRequest& q) {
    std::vector<Pose> poses;
    for (const msg::Pose& X : q.forbidden()) poses.push_back(wire::from_wire(X));
    forbidden.push_back(poses);
  }

  template <class Record>
  void take(const std::string& rpc, dds::RpcContext& context, Record record_request) {
    std::unique_lock lock(mutex);
    const int number = ++calls[rpc];
    record_request();
    changed.notify_all();
    for (const auto& [name, failure] : failures)
      if (name == rpc && number >= failure.first && number <= failure.last) throw Error(failure.code, failure.sentence);
    if (!held.contains(rpc)) return;
    while (!context.cancelled() && !closing) changed.wait_for(lock, 20ms);
    throw Error(ErrorCode::motion_halted, "halted");
  }

  Pose eye(int number) const {
    Pose X = Pose::Identity();
    X.translation() = Eigen::Vector3d(1.2 * std::cos(number), 1.2 * std::sin(number), 1.2);
    return X;
  }
  msg::GridCounts counts() const {
    msg::GridCounts c;
    c.unknown(1000 / (revision + 1));
    c.known(10 * revision);
    return c;
  }
  void publish_object() {
    voxel::OccupancyGrid grid(voxel::GridGeometry::from_box(wire::from_wire(box.pose_world_box()), wire::from_wire(box.size()), 0.1));
    grid.revision = revision;
    objects.publish(object_id, grid);
  }
  void publish_images(std::int64_t stamp_ns) {
    const ImageU8 image(16, 12, 3, 90);
    left.publish(wire::to_wire(wire::StampedImage{stamp_ns, "left", image}));
    right.publish(wire::to_wire(wire::StampedImage{stamp_ns, "right", image}));
    wide.publish(wire::to_wire(wire::StampedImage{stamp_ns, "wide", image}));
  }
  void publish_perception(const std::string& view_id) {
    const Pinhole camera = Pinhole::from_vertical_fov(16, 12, 0.4);
    object_model::Perception p;
    p.view_id = view_id;
    p.rig = {camera, 0.144};
    p.depth.push_back({camera, Pose::Identity(), ImageF(16, 12), ImageF(16, 12), ImageF(16, 12)});
    p.color = ImageU8(16, 12, 3, 90);
    p.disparity = ImageF(16, 12);
    p.disparity_filled = ImageU8(16, 12);
    perceptions.publish(wire::to_wire(p));
  }
  msg::Pose2 foot(double x, double y) const { return wire::to_wire(Pose2{x, y, 0}); }
  std::vector<double> configuration(double mark) const {
    Eigen::VectorXd q = model->half_sitting();
    q[0] = mark;
    return wire::vector_to_wire(q);
  }

  void offer_all();

  dds::Node& node;
  const std::shared_ptr<const robot::RobotModel> model;
  const std::set<std::string> absent;

  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  std::map<std::string, int> calls;
  std::vector<std::pair<std::string, Failure>> failures;
  std::set<std::string> held;
  bool not_a_number = false;
  double promised = 0;                 // 0: less at each plan, but never alike
  msg::RobotStateReply place;
  std::set<std::string> environment_revisions;
  std::vector<std::vector<double>> postures;
  std::vector<bool> resets;
  std::vector<double> reached;
  std::vector<std::vector<Pose>> forbidden;
  std::vector<Pose> planned;
  std::string object_id;
  msg::Box box;
  std::uint32_t revision = 0;
  int forgotten_at = 0;

  dds::Publisher<RosImage> left, right, wide;
  dds::Publisher<msg::Perception> perceptions;
  wire::ObjectPublisher objects;
  dds::Publisher<msg::ServiceStatus> statuses;
  std::thread heart;
  std::atomic<bool> closing{false};
  std::vector<std::shared_ptr<void>> servers;   // last: their threads end first
};

void ScriptedServices::Impl::offer_all() {
  offer<msg::RobotStateRequest, msg::RobotStateReply>("robot/state", [this](const auto&, auto& r) {
    r.scene_id(place.scene_id());
    r.scene_revision(place.scene_revision());
    r.robot_revision(place.robot_revision());
  });
  offer<msg::SetEnvironmentRequest, msg::SetEnvironmentReply>("model/set_environment",
                                                              [](const auto& q, auto& r) { r.revision(q.environment().revision()); });
  offer<msg::BeginRequest, msg::BeginReply>("model/begin", [this](const auto& q, auto& r) {
    object_id = q.object_id().to_string();
    box = q.box();
    r.revision(revision);
    r.box(box);
    r.counts(counts());
  });
  offer<msg::CaptureRequest, msg::CaptureReply>("vision/capture", [this](const auto&, auto& r) {
    const std::int64_t stamp_ns = 1000000000LL * calls["vision/capture"];
    publish_images(stamp_ns);
    r.stamp_ns(stamp_ns);
    r.pose_world_camera(wire::to_wire(eye(0)));
    r.attempts(1);
  });
  offer<msg::ProcessRequest, msg::ProcessReply>("vision/process", [this](const auto& q, auto& r) {
    publish_perception(q.view_id().to_string());
    r.pose_world_camera(wire::to_wire(eye(0)));
    r.valid_share(0.8);
    r.valid_share_in_box(0.9);
  });
  offer<msg::IntegrateRequest, msg::IntegrateReply>("model/integrate", [this](const auto&, auto& r) {
    if (calls["model/integrate"] == forgotten_at) revision = 0;
    ++revision;
    publish_object();
    r.revision(revision);
    r.counts(counts());
    r.box(box);
  });
  offer<msg::PublishRequest, msg::PublishReply>("model/publish", [this](const auto&, auto& r) {
    publish_object();
    r.revision(revision);
  });
  offer<msg::ExportRequest, msg::ExportReply>("model/export", [](const auto&, auto&) {
    throw Error(ErrorCode::model_object_unknown, "nothing was modelled: these services only follow a script");
  });
  offer<msg::DigestRequest, msg::DigestReply>("model/digest", [](const auto&, auto&) {
    throw Error(ErrorCode::model_object_unknown, "nothing was modelled: these services only follow a script");
  });
  offer<msg::PlanViewRequest, msg::PlanViewReply>("nbv/plan", [this](const auto&, auto& r) {
    const int number = calls["nbv/plan"];
    planned.push_back(eye(number));
    r.pose_world_camera(wire::to_wire(planned.back()));
    if (not_a_number) r.pose_world_camera().position().x(std::numeric_limits<double>::quiet_NaN());
    const double gain = promised > 0 ? promised : 10000.0 / number;
    r.predicted_gain_voxels(gain);
    r.predicted_gain_px(10 * gain);
  });
  offer<msg::PostureRequest, msg::PostureReply>("posture/generate", [this](const auto&, auto& r) {
    r.configuration(configuration(100 + calls["posture/generate"]));
    r.left_foot(foot(1, 0.1));
    r.right_foot(foot(1, -0.1));
  });
  offer<msg::MotionStateRequest, msg::MotionReply>("motion/state", [this](const auto&, auto& r) {
    r.configuration(configuration(0));
    r.left_foot(foot(0, 0.1));
    r.right_foot(foot(0, -0.1));
  });
  offer<msg::WalkPlanRequest, msg::WalkPlanReply>("walk/plan", [this](const auto& q, auto& r) {
    for (const int side : {0, 1}) {
      msg::Step step;
      step.foot(static_cast<std::uint8_t>(side));
      step.pose(side == 0 ? q.left_goal() : q.right_goal());
      r.steps().push_back(step);
    }
    r.length_m(1);
  });
  offer<msg::WalkRequest, msg::MotionReply>("motion/walk", [this](const auto&, auto& r) {
    reached = configuration(200 + calls["motion/walk"]);
    r.configuration(reached);
    r.left_foot(foot(1, 0.1));
    r.right_foot(foot(1, -0.1));
  });
  offer<msg::SetPostureRequest, msg::MotionReply>("motion/set_posture",
                                                  [](const auto& q, auto& r) { r.configuration(q.configuration()); });
  offer<msg::HaltRequest, msg::HaltReply>("motion/halt", [](const auto&, auto& r) { r.was_moving(true); });
}

ScriptedServices::ScriptedServices(dds::Node& node, std::shared_ptr<const robot::RobotModel> model, const std::set<std::string>& absent)
    : impl_(std::make_unique<Impl>(node, std::move(model), absent)) {
  impl_->offer_all();
}

ScriptedServices::~ScriptedServices() {
  impl_->closing = true;
  impl_->servers.clear();
  if (impl_->heart.joinable()) impl_->heart.join();
}

void ScriptedServices::fail(const std::string& rpc, ErrorCode code, const std::string& sentence, int first, int last) {
  const std::lock_guard lock(impl_->mutex);
  impl_->failures.push_back({rpc, {code, sentence, first, last}});
}

void ScriptedServices::hold(const std::string& rpc) {
  const std::lock_guard lock(impl_->mutex);
  impl_->held.insert(rpc);
}

void ScriptedServices::plan_not_a_number() {
  const std::lock_guard lock(impl_->mutex);
  impl_->not_a_number = true;
}

void ScriptedServices::promise(double voxels) {
  const std::lock_guard lock(impl_->mutex);
  impl_->promised = voxels;
}

void ScriptedServices::model_revision(std::uint32_t known, int forgotten_at) {
  const std::lock_guard lock(impl_->mutex);
  impl_->revision = known;
  impl_->forgotten_at = forgotten_at;
}

void ScriptedServices::stand_in(const std::string& scene_id, const std::string& scene_revision, const std::string& robot_revision) {
  const std::lock_guard lock(impl_->mutex);
  impl_->place.scene_id(scene_id);
  impl_->place.scene_revision(scene_revision);
  impl_->place.robot_revision(robot_revision);
}

void ScriptedServices::heartbeat() {
  impl_->heart = std::thread([this] {
    while (!impl_->closing) {
      for (const std::string& service : service::service_names()) {
        if (service == "supervisor") continue;
        msg::ServiceStatus status;
        status.instance(service + "-script");
        status.service(service);
        status.vendor(impl_->node.options().vendor);
        status.state(1);
        status.wall_time_ns(wall_time_ns());
        impl_->statuses.publish(status);
      }
      std::this_thread::sleep_for(300ms);
    }
  });
}

int ScriptedServices::calls(const std::string& rpc) const {
  const std::lock_guard lock(impl_->mutex);
  const auto it = impl_->calls.find(rpc);
  return it == impl_->calls.end() ? 0 : it->second;
}

bool ScriptedServices::wait_for_call(const std::string& rpc) const {
  std::unique_lock lock(impl_->mutex);
  return impl_->changed.wait_for(lock, 20s, [&] { return impl_->calls[rpc] > 0; });
}

std::set<std::string> ScriptedServices::environment_revisions() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->environment_revisions;
}

std::vector<std::vector<double>> ScriptedServices::postures() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->postures;
}

std::vector<bool> ScriptedServices::resets() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->resets;
}

std::vector<double> ScriptedServices::walk_end() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->reached;
}

std::vector<std::vector<Pose>> ScriptedServices::forbidden() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->forbidden;
}

std::vector<Pose> ScriptedServices::planned() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->planned;
}

}  // namespace periplus::failures
