#include "services/simulator/simulator_service.h"

#include <algorithm>
#include <deque>
#include <filesystem>
#include <mutex>
#include <optional>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/render/renderer.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_wire.h"
#include "common/wire/perception_wire.h"
#include "idl/ros2.h"
#include "idl/sim.h"
#include "services/simulator/ideal_robot.h"
#include "services/simulator/lens.h"

namespace periplus::simulator {

namespace {

using Clock = rosgraph_msgs::msg::dds_::Clock_;
using Image = sensor_msgs::msg::dds_::Image_;
using CameraInfo = sensor_msgs::msg::dds_::CameraInfo_;
using JointState = sensor_msgs::msg::dds_::JointState_;
using PoseStamped = geometry_msgs::msg::dds_::PoseStamped_;

constexpr std::uint64_t kTicksPerClock = 100;
constexpr int kImageDepth = 8;
const char* const kCameras[] = {"left", "right", "wide"};

// A view as it was published: all of one tick.
struct View {
  std::string id;
  std::uint64_t tick = 0;
  std::int64_t stamp_ns = 0;
  Image images[3];
  CameraInfo infos[3];
  JointState joints;
  PoseStamped base;
};

msg::RobotState to_wire(const RobotState& s) {
  msg::RobotState m;
  m.tick(s.tick);
  m.stamp_ns(s.stamp_ns);
  m.positions(wire::vector_to_wire(s.positions));
  m.velocities(wire::vector_to_wire(s.velocities));
  m.pose_world_base(wire::to_wire(s.X_WB));
  m.pose_world_left_foot(wire::to_wire(s.X_W_left));
  m.pose_world_right_foot(wire::to_wire(s.X_W_right));
  m.fallen(s.fallen);
  return m;
}

std::string urdf_beside(const std::string& yaml) { return std::filesystem::path(yaml).replace_extension(".urdf").string(); }

std::shared_ptr<const robot::RobotModel> load_robot(const std::string& yaml) { return robot::RobotModel::load_files(urdf_beside(yaml), yaml); }

std::vector<render::TrueObject> load_objects(const scene::Scene& scene, const std::vector<std::string>& folders) {
  if (!scene.truth) return {};
  return {render::load_true_object(*scene.truth, folders)};
}

SimulatorSettings with(SimulatorSettings settings, const scene::CameraImperfections& cameras) {
  apply(cameras, settings);
  return settings;
}

// Of left, right and wide camera.
std::vector<Lens> lenses_of(const scene::CameraImperfections& cameras, const robot::RobotModel& robot) {
  return {Lens(robot.camera(kCameras[0]).pinhole, cameras.left_distortion), Lens(robot.camera(kCameras[1]).pinhole, cameras.right_distortion),
          Lens(robot.camera(kCameras[2]).pinhole, cameras.wide_distortion)};
}

render::RendererOptions renderer_options(const SimulatorSettings& s, const std::vector<Lens>& lenses, const std::vector<std::string>& folders) {
  render::RendererOptions o;
  o.backend = s.backend;
  o.threads = s.render_threads;
  o.samples = s.samples;
  o.asset_folders = folders;
  o.max_width = o.max_height = 1;
  for (const Lens& lens : lenses) {
    o.max_width = std::max(o.max_width, lens.drawn().width);
    o.max_height = std::max(o.max_height, lens.drawn().height);
  }
  return o;
}

}  // namespace

struct SimulatorService::Impl {
  Impl(service::Service& life, const SimulatorSettings& s, const SimulatorOptions& o)
      : node(life.node()),
        scene(scene::load_scene(o.scene_file)),
        settings(with(s, scene.cameras)),
        scene_revision(wire::scene_revision(scene::without_truth(read_file(o.scene_file)))),
        robot_revision(wire::robot_revision(read_file(o.robot_file), read_file(urdf_beside(o.robot_file)))),
        folders{std::filesystem::path(o.scene_file).parent_path().string()},
        objects(load_objects(scene, folders)),
        robot(load_robot(o.robot_file), scene.robot_start, {.joint_limit_slack = s.joint_limit_slack, .fall_at_tick = s.fall_at_tick}),
        lenses(lenses_of(scene.cameras, robot.model())),
        renderer(scene, objects, renderer_options(s, lenses, folders)),
        states(node, "periplus/robot/state", dds::qos_stream()),
        clock(node, "rt/clock", dds::qos_stream()),
        joint_states(node, "rt/joint_states", dds::qos_stream(kImageDepth)),
        base_poses(node, "rt/base_pose", dds::qos_stream(kImageDepth)) {
    for (const char* topic : {"rt/stereo/left/", "rt/stereo/right/", "rt/wide/"}) {
      images.push_back(std::make_unique<dds::Publisher<Image>>(node, std::string(topic) + "image_raw", dds::qos_stream(kImageDepth)));
      infos.push_back(std::make_unique<dds::Publisher<CameraInfo>>(node, std::string(topic) + "camera_info", dds::qos_stream(kImageDepth)));
    }
    if (o.truth) publish_truth();
    state_server = life.serve<msg::RobotStateRequest, msg::RobotStateReply>(
        "robot/state", [this](const msg::RobotStateRequest&, msg::RobotStateReply& reply, dds::RpcContext&) {
          const std::lock_guard lock(robot_mutex);
          reply.state(to_wire(robot.state()));
          reply.scene_id(scene.name);
          reply.scene_revision(scene_revision);
          reply.robot_revision(robot_revision);
        });
    trigger_server = life.serve<msg::CameraTriggerRequest, msg::CameraTriggerReply>(
        "camera/trigger", [this](const msg::CameraTriggerRequest& request, msg::CameraTriggerReply& reply, dds::RpcContext&) { trigger(request, reply); });
    commands.emplace(node, "periplus/robot/command", dds::qos_stream(), [this](const msg::RobotCommand& m) { take(m); });
    log::info("simulating", {{"scene", scene.name}, {"robot", robot.model().name()}, {"rendering", renderer.backend()}});
  }

  // A command that cannot be executed is answered with the present state: the robot stays where it is.
  void take(const msg::RobotCommand& m) {
    const std::lock_guard lock(robot_mutex);
    const std::uint64_t before = robot.state().tick;
    msg::RobotState answer;
    try {
      require(m.support() <= 2, ErrorCode::bad_input, "the support of a command must be 0 (left), 1 (right) or 2 (both)");
      answer = to_wire(robot.command(m.tick(), static_cast<Support>(m.support()), wire::vector_from_wire(m.positions(), "joint positions")));
    } catch (const Error& e) {
      log::warn("refused a joint command", {{"tick", std::to_string(m.tick())}, {"reason", e.what()}});
      answer = to_wire(robot.state());
    }
    states.publish(answer);
    if (robot.state().tick != before && robot.state().tick % kTicksPerClock == 0) publish_clock(robot.state().stamp_ns);
  }

  void publish_clock(std::int64_t stamp_ns) {
    Clock now;
    now.clock(wire::stamp_to_wire(stamp_ns));
    clock.publish(now);
  }

  void trigger(const msg::CameraTriggerRequest& request, msg::CameraTriggerReply& reply) {
    const std::string id = wire::id_from_wire(request.view_id(), "view_id");
    require(!settings.silent_cameras, ErrorCode::sim_render_failed, "the cameras are silent, as faults.silent_cameras says");
    auto found = std::find_if(views.begin(), views.end(), [&](const View& v) { return v.id == id; });
    if (found == views.end()) {
      views.push_back(look(id));
      if (views.size() > static_cast<std::size_t>(settings.views_kept)) views.pop_front();
      found = views.end() - 1;
    }
    // The small ones first, so that the images complete the set.
    publish_clock(found->stamp_ns);
    joint_states.publish(found->joints);
    base_poses.publish(found->base);
    for (std::size_t i = 0; i < images.size(); ++i) {
      infos[i]->publish(found->infos[i]);
      images[i]->publish(found->images[i]);
    }
    reply.stamp_ns(found->stamp_ns);
    reply.tick(found->tick);
  }

  View look(const std::string& id) {
    View view;
    view.id = id;
    RobotState state;
    Pose poses[3];
    {
      const std::lock_guard lock(robot_mutex);
      state = robot.state();
      for (std::size_t i = 0; i < 3; ++i) poses[i] = robot.X_WC(kCameras[i]);
    }
    view.tick = state.tick;
    view.stamp_ns = state.stamp_ns;
    wire::StampedJoints joints{state.stamp_ns, {}};
    for (std::size_t i = 0; i < robot.model().joints().size(); ++i)
      joints.positions.emplace_back(robot.model().joints()[i].name, state.positions[static_cast<Eigen::Index>(i)]);
    view.joints = wire::to_wire(joints);
    view.base = wire::to_wire(state.stamp_ns, "world", state.X_WB);

    const CameraSensor* sensors[] = {&settings.left, &settings.right, &settings.wide};
    const double baseline = (poses[0].inverse() * poses[1].translation()).x();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string name = kCameras[i], frame = name + "_camera_optical";
      const Pinhole& pinhole = robot.model().camera(name).pinhole;
      wire::StampedImage image{state.stamp_ns, frame, lenses[i].bend(renderer.render(poses[i], lenses[i].drawn()).colour)};
      expose(image.image, *sensors[i], picture_seed(settings.seed, id, name));
      view.images[i] = wire::to_wire(image);
      // Rectified it is the ideal camera: K as P, and the true distortion.
      CameraCalibration calibration = CameraCalibration::ideal(pinhole, name == "right" ? baseline : 0);
      calibration.distortion = lenses[i].distortion();
      view.infos[i] = wire::to_wire(state.stamp_ns, frame, calibration);
    }
    return view;
  }

  void publish_truth() {
    require(scene.truth && !objects.empty(), ErrorCode::bad_input, scene.name + ": --truth needs a scene with a `truth` section");
    dds::Qos qos = dds::qos_latest(1);
    qos.partition = "truth";
    truth.emplace(node, "periplus/truth", qos);
    const render::TrueObject& object = objects.front();
    msg::Truth m;
    m.scene() = scene.name;
    m.mesh() = object.path;
    m.longest_side_m(scene.truth->longest_side);
    m.up_axis() = scene.truth->up_axis;
    m.scale(object.scale);
    m.pose_world_object(wire::to_wire(object.X_WM));
    const std::string ply = mesh::to_ply(object.mesh_W);
    m.mesh_ply().assign(ply.begin(), ply.end());
    require(truth->publish(m), ErrorCode::bad_size, scene.name + ": the object's mesh is too large to be published; simplify it");
  }

  dds::Node& node;  // before the rest, so that others see the simulator start while the pictures are made
  const scene::Scene scene;
  const SimulatorSettings settings;
  const std::string scene_revision, robot_revision;
  const std::vector<std::string> folders;
  const std::vector<render::TrueObject> objects;
  std::mutex robot_mutex;
  IdealRobot robot;
  const std::vector<Lens> lenses;
  render::Renderer renderer;
  std::deque<View> views;  // of the trigger's one thread
  dds::Publisher<msg::RobotState> states;
  dds::Publisher<Clock> clock;
  dds::Publisher<JointState> joint_states;
  dds::Publisher<PoseStamped> base_poses;
  std::vector<std::unique_ptr<dds::Publisher<Image>>> images;
  std::vector<std::unique_ptr<dds::Publisher<CameraInfo>>> infos;
  std::optional<dds::Publisher<msg::Truth>> truth;
  std::shared_ptr<dds::RpcServer<msg::RobotStateRequest, msg::RobotStateReply>> state_server;
  std::shared_ptr<dds::RpcServer<msg::CameraTriggerRequest, msg::CameraTriggerReply>> trigger_server;
  std::optional<dds::Subscriber<msg::RobotCommand>> commands;
};

SimulatorService::SimulatorService(service::Service& service, const SimulatorSettings& settings, const SimulatorOptions& options)
    : impl_(std::make_unique<Impl>(service, settings, options)) {}

SimulatorService::~SimulatorService() = default;

}  // namespace periplus::simulator
