#include "integration-tests/harness/camera_injector.h"

#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/geometry/calibration.h"
#include "common/wire/common_wire.h"
#include "common/wire/perception_wire.h"
#include "idl/ros2.h"
#include "idl/sim.h"

namespace periplus::harness {

namespace {
using Image = sensor_msgs::msg::dds_::Image_;
using CameraInfo = sensor_msgs::msg::dds_::CameraInfo_;
using JointState = sensor_msgs::msg::dds_::JointState_;
using PoseStamped = geometry_msgs::msg::dds_::PoseStamped_;
}  // namespace

struct CameraInjector::Impl {
  struct Shot {
    std::int64_t stamp_ns = 0;
    std::uint64_t number = 0;
    ImageU8 left, right;
    Pose X_WB = Pose::Identity();
    int times = 0;
  };

  Impl(dds::Node& node, AnalyticScene s, std::shared_ptr<const robot::RobotModel> m, double noise)
      : scene(std::move(s)),
        model(std::move(m)),
        sigma(noise),
        left_image(node, "rt/stereo/left/image_raw", dds::qos_stream(8)),
        right_image(node, "rt/stereo/right/image_raw", dds::qos_stream(8)),
        left_info(node, "rt/stereo/left/camera_info", dds::qos_stream(8)),
        right_info(node, "rt/stereo/right/camera_info", dds::qos_stream(8)),
        joints(node, "rt/joint_states", dds::qos_stream(8)),
        base_pose(node, "rt/base_pose", dds::qos_stream(8)),
        trigger(node, "camera/trigger",
                [this](const msg::CameraTriggerRequest& q, msg::CameraTriggerReply& r, dds::RpcContext&) {
                  const std::lock_guard lock(mutex);
                  ++triggers;
                  Shot& shot = take(wire::id_from_wire(q.view_id(), "view_id"));
                  publish(shot);
                  r.stamp_ns(shot.stamp_ns);
                  r.tick(shot.number);
                }) {}

  // The same view asked again is the same shot.
  Shot& take(const std::string& view_id) {
    const auto [it, fresh] = shots.try_emplace(view_id);
    Shot& shot = it->second;
    if (!fresh) return shot;
    const StereoRig rig = model->stereo_rig();
    shot.number = shots.size();
    shot.stamp_ns = static_cast<std::int64_t>(shot.number) * 1000000000;
    shot.left = with_sensor_noise(scene.look(rig.camera, X_WC).image, sigma, 1, 0, 2 * shot.number);
    shot.right = fault == Fault::blank_right
                     ? with_sensor_noise(ImageU8(rig.camera.width, rig.camera.height, 3, 0), sigma, 1, 16, 7)
                     : with_sensor_noise(
                           scene.look(rig.camera, X_WC * Eigen::Translation3d(rig.baseline, 0, 0)).image, sigma, 1.03, 2,
                           2 * shot.number + 1);
    Eigen::VectorXd q = model->half_sitting();
    q.head<6>().setZero();
    robot::Kinematics kinematics(model);
    kinematics.set(q);
    shot.X_WB = X_WC * kinematics.X_WC("left").inverse();
    return shot;
  }

  void publish(Shot& shot) {
    const StereoRig rig = model->stereo_rig();
    left_info.publish(wire::to_wire(shot.stamp_ns, "left", CameraCalibration::ideal(rig.camera)));
    right_info.publish(wire::to_wire(shot.stamp_ns, "right", CameraCalibration::ideal(rig.camera, rig.baseline)));
    wire::StampedJoints positions{shot.stamp_ns, {}};
    for (const robot::Joint& joint : model->joints()) positions.positions.emplace_back(joint.name, joint.half_sitting);
    if (fault == Fault::missing_joint) positions.positions.pop_back();
    joints.publish(wire::to_wire(positions));
    PoseStamped base = wire::to_wire(shot.stamp_ns, "world", shot.X_WB);
    if (fault == Fault::not_a_number_pose) base.pose().position().x(std::numeric_limits<double>::quiet_NaN());
    base_pose.publish(base);

    const bool first = shot.times++ == 0;
    if (fault == Fault::no_images) return;
    left_image.publish(wire::to_wire(wire::StampedImage{shot.stamp_ns, "left", shot.left}));
    if (fault == Fault::lost_once && first) return;
    Image right = wire::to_wire(wire::StampedImage{shot.stamp_ns, "right", shot.right});
    if (fault == Fault::truncated) right.data().resize(right.data().size() - 1000);
    if (fault == Fault::wrong_size) {
      right.height(right.height() / 2);
      right.data().resize(right.data().size() / 2);
    }
    if (fault == Fault::wrong_encoding) right.encoding("mono16");
    if (fault == Fault::stale) right.header().stamp(wire::stamp_to_wire(shot.stamp_ns - 30000000));
    right_image.publish(right);
  }

  const AnalyticScene scene;
  const std::shared_ptr<const robot::RobotModel> model;
  const double sigma;
  mutable std::mutex mutex;
  Pose X_WC = Pose::Identity();
  Fault fault = Fault::none;
  int triggers = 0;
  std::map<std::string, Shot> shots;
  dds::Publisher<Image> left_image, right_image;
  dds::Publisher<CameraInfo> left_info, right_info;
  dds::Publisher<JointState> joints;
  dds::Publisher<PoseStamped> base_pose;
  dds::RpcServer<msg::CameraTriggerRequest, msg::CameraTriggerReply> trigger;
};

CameraInjector::CameraInjector(dds::Node& node, AnalyticScene scene, std::shared_ptr<const robot::RobotModel> model,
                               double sigma)
    : impl_(std::make_unique<Impl>(node, std::move(scene), std::move(model), sigma)) {}
CameraInjector::~CameraInjector() = default;

void CameraInjector::stand(const Pose& X_WC) {
  const std::lock_guard lock(impl_->mutex);
  impl_->X_WC = X_WC;
}

void CameraInjector::fail_by(Fault fault) {
  const std::lock_guard lock(impl_->mutex);
  impl_->fault = fault;
}

int CameraInjector::triggers() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->triggers;
}

}  // namespace periplus::harness
