#include "services/vision_server/vision_server_service.h"

#include <chrono>
#include <cmath>
#include <functional>
#include <opencv2/core/utility.hpp>
#include <string>

#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/dds/rpc.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "common/wire/perception_wire.h"
#include "idl/ros2.h"
#include "idl/sim.h"
#include "idl/vision.h"
#include "services/vision_server/camera_pose.h"
#include "services/vision_server/captured_view.h"
#include "services/vision_server/demosaic.h"
#include "services/vision_server/perceive.h"

namespace periplus::vision {

namespace {

using Image = sensor_msgs::msg::dds_::Image_;
using CameraInfo = sensor_msgs::msg::dds_::CameraInfo_;
using JointState = sensor_msgs::msg::dds_::JointState_;
using PoseStamped = geometry_msgs::msg::dds_::PoseStamped_;
using Part = ViewCollector::Part;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The robot's model says where the eyes stand; a calibration that contradicts it would bend the object's model.
void check_rig(const StereoRig& measured, const StereoRig& model) {
  require(std::abs(measured.baseline - model.baseline) < 0.002 &&
              std::abs(measured.camera.fx / measured.camera.width - model.camera.fx / model.camera.width) < 0.02,
          ErrorCode::vision_image_bad,
          "the camera infos contradict the robot model: baseline " + std::to_string(measured.baseline) + " m against " +
              std::to_string(model.baseline) + " m, fx " + std::to_string(measured.camera.fx) + " px against " +
              std::to_string(model.camera.fx) + " px; correct the one that is wrong");
}

}  // namespace

struct VisionServerService::Impl {
  Impl(service::Service& life, const VisionSettings& s)
      : settings(s),
        collector(s.stamp_tolerance_ns),
        views(static_cast<std::size_t>(s.views_kept)),
        knowledge(life.node()),
        trigger(life.node(), "camera/trigger"),
        perceptions(life.node(), "periplus/perception", dds::qos_latest(8)),
        left_image(life.node(), "rt/stereo/left/image_raw", dds::qos_stream(8),
                   [this](const Image& m) { take_image(Part::left, m); }),
        right_image(life.node(), "rt/stereo/right/image_raw", dds::qos_stream(8),
                    [this](const Image& m) { take_image(Part::right, m); }),
        left_info(life.node(), "rt/stereo/left/camera_info", dds::qos_stream(8),
                  [this](const CameraInfo& m) { take_calibration(Part::left_calibration, m); }),
        right_info(life.node(), "rt/stereo/right/camera_info", dds::qos_stream(8),
                   [this](const CameraInfo& m) { take_calibration(Part::right_calibration, m); }),
        joints(life.node(), "rt/joint_states", dds::qos_stream(64), [this](const JointState& m) {
          guarded("joint states", [&] {
            wire::StampedJoints j = wire::from_wire(m);
            collector.add_joints(j.stamp_ns, std::move(j.positions));
          });
        }),
        base_pose(life.node(), "rt/base_pose", dds::qos_stream(64), [this](const PoseStamped& m) {
          guarded("base pose", [&] {
            const auto [stamp, X_WB] = wire::from_wire(m);
            collector.add_base_pose(stamp, X_WB);
          });
        }) {}

  // Messages that cannot be used are remembered as the cause, should a view stay incomplete, and logged once a capture.
  void guarded(const char* what, const std::function<void()>& take) {
    try {
      take();
    } catch (const Error& e) {
      if (collector.add_fault(std::string(what) + ": " + e.what())) log::warn("refused a message", {{"what", what}, {"reason", e.what()}});
    }
  }

  void take_image(Part eye, const Image& m) {
    guarded(eye == Part::left ? "left image" : "right image", [&] {
      wire::StampedImage image = wire::from_wire(m);
      collector.add_image(eye, image.stamp_ns, demosaiced(std::move(image.image), image.mosaic));
    });
  }

  void take_calibration(Part eye, const CameraInfo& m) {
    guarded(eye == Part::left_calibration ? "left camera info" : "right camera info", [&] {
      auto [stamp, calibration] = wire::from_wire(m);
      collector.add_calibration(eye, stamp, std::move(calibration));
    });
  }

  std::shared_ptr<const wire::KnownEnvironment> environment_of(const msg::Revision& revision) const {
    return knowledge.environment_or_throw(wire::id_from_wire(revision, "environment_revision"), ErrorCode::vision_revision_not_here);
  }

  // A view once captured stays what it was: asked again, the same answer.
  void capture(const msg::CaptureRequest& request, msg::CaptureReply& reply, dds::RpcContext& context) {
    const std::string view_id = wire::id_from_wire(request.view_id(), "view_id");
    const auto environment = environment_of(request.environment_revision());
    const auto pose_of = [&](const CapturedView& v) { return left_eye_pose(environment->robot, v.joints, v.X_WB); };
    std::uint32_t attempts = 0;
    std::shared_ptr<const CapturedView> view = views.find(view_id);
    std::string missing;
    collector.clear_faults();
    for (int attempt = 0; !view && attempt < settings.attempts; ++attempt) {
      context.throw_if_cancelled();
      ++attempts;
      msg::CameraTriggerRequest ask;
      msg::CameraTriggerReply answer;
      ask.view_id(view_id);
      const ViewCollector::Moment triggered = collector.now();
      const dds::RpcResult result = trigger.call(
          ask, answer, {.deadline = settings.trigger_deadline, .wait_for_server = settings.trigger_deadline});
      require(result.status == dds::RpcStatus::ok, ErrorCode::vision_images_missing,
              std::string("the cameras do not answer (") + dds::to_string(result.status) +
                  "); check that the simulator or the camera driver runs");
      result.throw_if_failed("camera/trigger");
      if (auto complete = collector.wait(answer.stamp_ns(), triggered, settings.images_deadline)) {
        check_sizes(*complete);
        pose_of(*complete);  // refuses joints that do not fit before the view counts as captured
        rig_of(complete->left_calibration, complete->right_calibration);
        views.put(view_id, std::move(*complete));
        view = views.find(view_id);
      } else {
        missing = collector.missing(answer.stamp_ns(), triggered);
        log::warn("incomplete set of images", {{"view", view_id}, {"missing", missing}, {"attempt", std::to_string(attempts)}});
      }
    }
    if (!view) {
      const std::string fault = collector.fault();
      require(fault.empty(), ErrorCode::vision_image_bad, fault);
      throw_error(ErrorCode::vision_images_missing, "asked " + std::to_string(attempts) + " times, but no " + missing +
                                                        " of the stamp of view '" + view_id +
                                                        "' came; check the camera driver, the network and the clocks of their hosts");
    }
    reply.stamp_ns(view->stamp_ns);
    reply.pose_world_camera(wire::to_wire(pose_of(*view)));
    reply.attempts(attempts);
  }

  void process(const msg::ProcessRequest& request, msg::ProcessReply& reply, dds::RpcContext& context) {
    const std::string view_id = wire::id_from_wire(request.view_id(), "view_id");
    const object_model::ObjectBox box = wire::from_wire(request.box());
    const std::shared_ptr<const CapturedView> view = views.find(view_id);
    require(view != nullptr, ErrorCode::vision_view_unknown,
            "view '" + view_id + "' was not captured here; call vision/capture with that view id first");
    const auto environment = environment_of(request.environment_revision());

    const double begun = seconds_now();
    const RectifiedPair pair = rectify(*view, left_eye_pose(environment->robot, view->joints, view->X_WB), maps);
    check_rig(pair.rig, environment->robot->stereo_rig());
    PerceiveReport report;
    report.seconds.emplace_back("rectify", seconds_now() - begun);
    context.throw_if_cancelled();
    object_model::Perception perception =
        perceive(pair, box, {&environment->scene, environment->collision.get()}, settings.perceive, seconds_now, report);
    perception.view_id = view_id;
    perception.stamp_ns = view->stamp_ns;
    const double publishing = seconds_now();
    require(perceptions.publish(wire::to_wire(perception)), ErrorCode::internal,
            "the perception could not be published; see the log");
    report.seconds.emplace_back("publish", seconds_now() - publishing);

    reply.pose_world_camera(wire::to_wire(perception.X_WC));
    reply.valid_share(report.valid_share);
    reply.valid_share_in_box(report.valid_share_in_box);
    reply.features(static_cast<std::uint32_t>(perception.features.size()));
    for (const auto& [name, seconds] : report.seconds) reply.seconds().push_back(wire::named(name, seconds));
    log::info("processed", {{"view", view_id},
                            {"valid_share", std::to_string(report.valid_share)},
                            {"valid_share_in_box", std::to_string(report.valid_share_in_box)},
                            {"silhouette_valid_share", std::to_string(perception.silhouette_valid_share)},
                            {"features", std::to_string(perception.features.size())},
                            {"seconds", std::to_string(seconds_now() - begun)}});
  }

  const VisionSettings settings;
  ViewCollector collector;
  ViewStore views;
  RectificationMaps maps;
  wire::Knowledge knowledge;
  dds::RpcClient<msg::CameraTriggerRequest, msg::CameraTriggerReply> trigger;
  dds::Publisher<msg::Perception> perceptions;
  dds::Subscriber<Image> left_image, right_image;
  dds::Subscriber<CameraInfo> left_info, right_info;
  dds::Subscriber<JointState> joints;
  dds::Subscriber<PoseStamped> base_pose;
};

VisionServerService::VisionServerService(service::Service& service, const VisionSettings& settings) {
  cv::setNumThreads(settings.threads);
  impl_ = std::make_shared<Impl>(service, settings);
  // The RPC servers live as long as the service's metrics do, which is longer than we: they hold us weakly.
  const auto alive = [weak = std::weak_ptr<Impl>(impl_)] {
    auto impl = weak.lock();
    require(impl != nullptr, ErrorCode::not_ready, "the vision server is stopping; ask again or ask another one");
    return impl;
  };
  service.serve<msg::CaptureRequest, msg::CaptureReply>(
      "vision/capture", [alive](const msg::CaptureRequest& q, msg::CaptureReply& r, dds::RpcContext& c) {
        alive()->capture(q, r, c);
      });
  service.serve<msg::ProcessRequest, msg::ProcessReply>(
      "vision/process", [alive](const msg::ProcessRequest& q, msg::ProcessReply& r, dds::RpcContext& c) {
        alive()->process(q, r, c);
      });
}

VisionServerService::~VisionServerService() = default;

}  // namespace periplus::vision
