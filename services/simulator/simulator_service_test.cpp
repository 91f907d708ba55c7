// The simulator over DDS, on a domain of its own.
#include "services/simulator/simulator_service.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "common/dds/codec_impl.h"
#include "common/mesh/triangle_mesh.h"
#include "common/scene/scene.h"
#include "common/service/testing/test_service.h"
#include "common/wire/object_wire.h"
#include "common/wire/testing/environment_texts.h"
#include "idl/ros2.h"
#include "idl/sim.h"

namespace periplus::simulator {
namespace {

using namespace std::chrono_literals;
using Image = sensor_msgs::msg::dds_::Image_;

// The last sample of a topic, waited for.
template <class T>
class Last {
 public:
  Last(dds::Node& node, const std::string& topic, const dds::Qos& qos)
      : subscriber_(node, topic, qos, [this](const T& sample) {
          const std::lock_guard lock(mutex_);
          sample_ = sample;
          ++count_;
          arrived_.notify_all();
        }) {}
  bool wait(int count, std::chrono::seconds timeout = 10s) {
    std::unique_lock lock(mutex_);
    return arrived_.wait_for(lock, timeout, [&] { return count_ >= count; });
  }
  T get() {
    const std::lock_guard lock(mutex_);
    return sample_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  T sample_;
  int count_ = 0;
  dds::Subscriber<T> subscriber_;
};

TEST(SimulatorService, CommandsViewsAndTruthOverDds) {
  const auto folder = std::filesystem::temp_directory_path() / ("simulator_service_test-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  mesh::write_ply(mesh::make_sphere(2, 1), folder / "ball.ply");
  const std::string scene_text =
      "name: ball\nroom: {size_m: [4, 4, 2.5]}\nrobot_start: {x_m: -1.2}\n"
      "lights: [{position_m: [-1, 0, 2]}]\n"
      "cameras: {noise_grey: 1, right_distortion: [-0.2, 0.05, 0.001, 0, 0]}\n"
      "truth: {mesh: ball.ply, longest_side_m: 0.3, position_m: [0, 0, 0.8], texture: \"noise:5\"}\n";
  std::ofstream(folder / "scene.yaml") << scene_text;
  service::testing::TestService life("simulator_service_test");
  dds::Node* const node = &life.node();
  const SimulatorService simulator(life, read_settings(config::parse("", "defaults")),
                                   {(folder / "scene.yaml").string(), PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.yaml", true});

  dds::RpcClient<msg::RobotStateRequest, msg::RobotStateReply> ask_state(*node, "robot/state");
  ASSERT_TRUE(ask_state.wait_for_server(10s));
  msg::RobotStateRequest state_request;
  msg::RobotStateReply state;
  ASSERT_TRUE(ask_state.call(state_request, state).ok());
  EXPECT_EQ(state.state().tick(), 0u);
  EXPECT_EQ(state.state().positions().size(), 30u);
  // Where and what it is, the truth left out.
  EXPECT_EQ(state.scene_id().to_string(), "ball");
  EXPECT_EQ(state.scene_revision().to_string(), wire::scene_revision(scene::without_truth(scene_text)));
  const wire::testing::Texts texts = wire::testing::environment_texts();
  EXPECT_EQ(state.robot_revision().to_string(), wire::robot_revision(texts.robot_yaml, texts.robot_urdf));

  Last<msg::RobotState> states(*node, "periplus/robot/state", dds::qos_stream());
  dds::Publisher<msg::RobotCommand> commands(*node, "periplus/robot/command", dds::qos_stream());
  for (int i = 0; i < 200 && commands.matched() == 0; ++i) std::this_thread::sleep_for(50ms);
  ASSERT_EQ(commands.matched(), 1);
  msg::RobotCommand command;
  command.tick(0);
  command.support(2);
  command.positions() = state.state().positions();
  ASSERT_TRUE(commands.publish(command));
  ASSERT_TRUE(states.wait(1));
  EXPECT_EQ(states.get().tick(), 1u);
  EXPECT_EQ(states.get().stamp_ns(), 5'000'000);
  command.tick(7);  // runs ahead: the robot stays and says where it is
  ASSERT_TRUE(commands.publish(command));
  ASSERT_TRUE(states.wait(2));
  EXPECT_EQ(states.get().tick(), 1u);

  Last<Image> left(*node, "rt/stereo/left/image_raw", dds::qos_stream(8));
  Last<sensor_msgs::msg::dds_::CameraInfo_> right_info(*node, "rt/stereo/right/camera_info", dds::qos_stream(8));
  dds::RpcClient<msg::CameraTriggerRequest, msg::CameraTriggerReply> trigger(*node, "camera/trigger");
  ASSERT_TRUE(trigger.wait_for_server(10s));
  std::this_thread::sleep_for(500ms);  // until the readers of the images are known to the writers
  msg::CameraTriggerRequest look;
  msg::CameraTriggerReply seen;
  look.view_id() = "view-1";
  ASSERT_TRUE(trigger.call(look, seen).ok());
  EXPECT_EQ(seen.tick(), 1u);
  EXPECT_EQ(seen.stamp_ns(), 5'000'000);
  ASSERT_TRUE(left.wait(1));
  ASSERT_TRUE(right_info.wait(1));
  const Image first = left.get();
  EXPECT_EQ(first.data().size(), std::size_t{3} * first.width() * first.height());
  EXPECT_EQ(first.header().stamp().nanosec(), 5'000'000u);
  EXPECT_EQ(right_info.get().d(), (std::vector<double>{-0.2, 0.05, 0.001, 0, 0}));
  EXPECT_NEAR(right_info.get().p()[3], -0.144 * right_info.get().p()[0], 1e-6);

  // The robot moves on; the view stays what it was.
  command.tick(1);
  command.positions()[12] += 0.05;  // the chest; a leg would leave the head where it is
  ASSERT_TRUE(commands.publish(command));
  ASSERT_TRUE(states.wait(3));
  EXPECT_EQ(states.get().tick(), 2u);
  ASSERT_TRUE(trigger.call(look, seen).ok());
  EXPECT_EQ(seen.tick(), 1u);
  ASSERT_TRUE(left.wait(2));
  EXPECT_TRUE(left.get().data() == first.data());
  look.view_id() = "view-2";
  ASSERT_TRUE(trigger.call(look, seen).ok());
  EXPECT_EQ(seen.tick(), 2u);
  ASSERT_TRUE(left.wait(3));
  EXPECT_TRUE(left.get().data() != first.data());
  look.view_id() = "no view";
  EXPECT_EQ(trigger.call(look, seen).error_code, static_cast<int>(ErrorCode::bad_input));

  // The truth comes to late joiners of its partition, and to nobody else.
  dds::Qos in_truth = dds::qos_latest(1);
  in_truth.partition = "truth";
  Last<msg::Truth> truth(*node, "periplus/truth", in_truth), elsewhere(*node, "periplus/truth", dds::qos_latest(1));
  ASSERT_TRUE(truth.wait(1));
  EXPECT_NEAR(truth.get().scale(), 0.15, 1e-9);
  EXPECT_GT(truth.get().mesh_ply().size(), 1000u);
  EXPECT_FALSE(elsewhere.wait(1, 1s));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace periplus::simulator
