// The vision server's program, fed with synthetic images: depth against the truth, and what it does with spoilt input.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <memory>
#include <mutex>

#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_wire.h"
#include "common/wire/perception_wire.h"
#include "idl/vision.h"
#include "integration-tests/harness/camera_injector.h"
#include "integration-tests/harness/test_bench.h"

namespace periplus::harness {
namespace {

using namespace std::chrono_literals;

class VisionAlone : public testing::Test {
 protected:
  VisionAlone()
      : bench("vision-alone"),
        injector(new_cameras()),
        environment(bench.node(), "periplus/environment", dds::qos_latest()),
        perceptions(bench.node(), "periplus/perception", dds::qos_latest(8),
                    [this](const msg::Perception& p) {
                      const std::lock_guard lock(mutex);
                      last = p;
                      ++received;
                      changed.notify_all();
                    }),
        capture(bench.node(), "vision/capture"),
        process(bench.node(), "vision/process") {
    const msg::Environment room =
        wire::environment_to_wire("ball-on-table", BallOnTable::scene_yaml(), bench.robot_yaml(), bench.robot_urdf());
    environment_revision = room.revision().to_string();
    environment.publish(room);
    bench.start("periplus-vision-server", {"--set", "capture.images_deadline_s=0.7"});
    injector->stand(BallOnTable::view(0.4));
  }
  ~VisionAlone() override {
    if (HasFailure()) std::fputs(bench.logs().c_str(), stderr);
  }

  std::unique_ptr<CameraInjector> new_cameras() {
    return std::make_unique<CameraInjector>(bench.node(), BallOnTable::scene(), bench.robot());
  }
  dds::RpcResult ask_capture(const std::string& view, msg::CaptureReply& reply) {
    msg::CaptureRequest request;
    request.view_id(view);
    request.environment_revision(environment_revision);
    return capture.call(request, reply, {.deadline = 30s, .wait_for_server = 30s});
  }
  dds::RpcResult ask_process(const std::string& view, msg::ProcessReply& reply) {
    msg::ProcessRequest request;
    request.view_id(view);
    request.environment_revision(environment_revision);
    request.box(wire::to_wire(BallOnTable::box()));
    return process.call(request, reply, {.deadline = 60s, .wait_for_server = 30s});
  }
  // The perception published `n`th.
  msg::Perception perception(int n) {
    std::unique_lock lock(mutex);
    EXPECT_TRUE(changed.wait_for(lock, 20s, [&] { return received >= n; }));
    return last;
  }

  TestBench bench;
  std::unique_ptr<CameraInjector> injector;
  dds::Publisher<msg::Environment> environment;
  std::string environment_revision;
  std::mutex mutex;
  std::condition_variable changed;
  msg::Perception last;
  int received = 0;
  dds::Subscriber<msg::Perception> perceptions;
  dds::RpcClient<msg::CaptureRequest, msg::CaptureReply> capture;
  dds::RpcClient<msg::ProcessRequest, msg::ProcessReply> process;
};

TEST_F(VisionAlone, DepthAndCameraPoseAreTheTruth) {
  msg::CaptureReply captured;
  const dds::RpcResult result = ask_capture("look-1", captured);
  ASSERT_TRUE(result.ok()) << dds::to_string(result.status) << ' ' << result.error_message;
  const Pose X_WC = BallOnTable::view(0.4);
  EXPECT_TRUE(wire::from_wire(captured.pose_world_camera()).isApprox(X_WC, 1e-9));

  // Asked again: the same answer, and the cameras are left alone.
  const int triggers = injector->triggers();
  injector->stand(BallOnTable::view(2.0));
  msg::CaptureReply again;
  ASSERT_TRUE(ask_capture("look-1", again).ok());
  EXPECT_EQ(again.stamp_ns(), captured.stamp_ns());
  EXPECT_EQ(injector->triggers(), triggers);

  msg::ProcessReply processed;
  const dds::RpcResult done = ask_process("look-1", processed);
  ASSERT_TRUE(done.ok()) << dds::to_string(done.status) << ' ' << done.error_message;
  EXPECT_GT(processed.valid_share_in_box(), 0.8);
  const msg::Perception first = perception(1);
  const object_model::Perception p = wire::from_wire(first);
  EXPECT_EQ(p.view_id, "look-1");
  EXPECT_EQ(p.features.size(), processed.features());
  ASSERT_EQ(p.depth.size(), 2u);
  EXPECT_EQ(p.depth[0].camera.width, 640);

  const AnalyticScene::Look truth = BallOnTable::scene().look(p.depth[0].camera, X_WC);
  std::vector<double> errors;
  std::size_t object = 0;
  for (std::size_t i = 0; i < truth.depth.data.size(); ++i)
    if (truth.object.data[i]) {
      ++object;
      if (p.depth[0].depth.data[i] > 0)
        errors.push_back(std::abs(p.depth[0].depth.data[i] - truth.depth.data[i]));
    }
  std::sort(errors.begin(), errors.end());
  ASSERT_GT(errors.size(), 0.85 * static_cast<double>(object));
  EXPECT_LT(errors[errors.size() / 2], 0.003);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.012);

  // Processed again: the same bytes.
  ASSERT_TRUE(ask_process("look-1", processed).ok());
  const msg::Perception second = perception(2);
  EXPECT_EQ(first.depth()[0].depth(), second.depth()[0].depth());
  EXPECT_EQ(first.depth()[1].depth_minimum(), second.depth()[1].depth_minimum());
  EXPECT_EQ(first.color(), second.color());
  ASSERT_EQ(first.features().size(), second.features().size());
  for (std::size_t i = 0; i < first.features().size(); ++i)
    EXPECT_EQ(first.features()[i].descriptor(), second.features()[i].descriptor());
}

TEST_F(VisionAlone, SpoiltInputHasItsErrorAndNothingIsLost) {
  std::string other_revision(64, '0');
  struct Case {
    Fault fault;
    ErrorCode code;
    const char* says;
  };
  int number = 0;
  for (const Case& c : {Case{Fault::no_images, ErrorCode::vision_images_missing, "left image, right image"},
                        Case{Fault::truncated, ErrorCode::vision_image_bad, "truncated"},
                        Case{Fault::wrong_encoding, ErrorCode::vision_image_bad, "mono16"},
                        Case{Fault::wrong_size, ErrorCode::vision_image_bad, "camera info says"},
                        Case{Fault::stale, ErrorCode::vision_images_missing, "right image"},
                        Case{Fault::not_a_number_pose, ErrorCode::vision_image_bad, "finite"},
                        Case{Fault::missing_joint, ErrorCode::vision_images_missing, "no joint"}}) {
    injector->fail_by(c.fault);
    msg::CaptureReply reply;
    const dds::RpcResult result = ask_capture("spoilt-" + std::to_string(++number), reply);
    EXPECT_EQ(result.status, dds::RpcStatus::ok);
    EXPECT_EQ(result.error_code, static_cast<int>(c.code)) << c.says << ": " << result.error_message;
    EXPECT_NE(result.error_message.find(c.says), std::string::npos) << result.error_message;
  }
  msg::CaptureReply captured;
  msg::ProcessReply processed;
  injector->fail_by(Fault::blank_right);
  ASSERT_TRUE(ask_capture("blank", captured).ok());
  const dds::RpcResult blank = ask_process("blank", processed);
  EXPECT_EQ(blank.error_code, static_cast<int>(ErrorCode::vision_no_depth));
  EXPECT_NE(blank.error_message.find("right eye"), std::string::npos) << blank.error_message;

  EXPECT_EQ(ask_process("never-captured", processed).error_code, static_cast<int>(ErrorCode::vision_view_unknown));

  // The robot's model of another environment will not do.
  std::swap(environment_revision, other_revision);
  EXPECT_EQ(ask_capture("elsewhere", captured).error_code, static_cast<int>(ErrorCode::vision_revision_not_here));
  EXPECT_EQ(ask_process("blank", processed).error_code, static_cast<int>(ErrorCode::vision_revision_not_here));
  std::swap(environment_revision, other_revision);

  // A lost image is asked for again, and all is well.
  injector->fail_by(Fault::lost_once);
  const dds::RpcResult retried = ask_capture("lost", captured);
  EXPECT_TRUE(retried.ok()) << retried.error_message;
  EXPECT_GE(captured.attempts(), 2u);
  injector->fail_by(Fault::none);
  EXPECT_TRUE(ask_process("lost", processed).ok());
}

TEST_F(VisionAlone, CamerasThatWereStartedAgainAreNotTakenForTheOldOnes) {
  msg::CaptureReply before, after;
  ASSERT_TRUE(ask_capture("old-run", before).ok());
  injector.reset();
  injector = new_cameras();  // its clock starts anew: the same stamp
  injector->stand(BallOnTable::view(2.0));
  injector->fail_by(Fault::lost_once);
  const dds::RpcResult result = ask_capture("new-run", after);
  ASSERT_TRUE(result.ok()) << result.error_message;
  EXPECT_EQ(after.stamp_ns(), before.stamp_ns());
  EXPECT_EQ(after.attempts(), 2u) << "the old cameras' right image stood in for the lost one";
  EXPECT_TRUE(wire::from_wire(after.pose_world_camera()).isApprox(BallOnTable::view(2.0), 1e-9));
}

}  // namespace
}  // namespace periplus::harness
