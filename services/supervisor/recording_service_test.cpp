#include "services/supervisor/recording_service.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/dds/codec_impl.h"
#include "common/dds/testing/test_domain.h"
#include "common/wire/common_wire.h"
#include "idl/sim.h"

namespace periplus::supervisor {
namespace {

using namespace std::chrono_literals;

// A simulator as far as the truth goes.
class TruthTeller {
 public:
  TruthTeller(dds::Node& node, const std::string& scene) : publisher_(node, "periplus/truth", in_truth()) {
    msg::Truth truth;
    truth.scene(scene);
    truth.pose_world_object(wire::to_wire(Pose::Identity()));
    truth.mesh_ply().assign(4, 'p');
    publisher_.publish(truth);
  }

 private:
  static dds::Qos in_truth() {
    dds::Qos qos = dds::qos_latest(1);
    qos.partition = "truth";
    return qos;
  }
  dds::Publisher<msg::Truth> publisher_;
};

class TruthOfARun : public testing::Test {
 protected:
  TruthOfARun()
      : folder(std::filesystem::temp_directory_path() / ("periplus_recording_test_" + std::to_string(::getpid()))),
        node(node_on(domain.id())),
        recording(*node),
        recorder(folder.string()) {}
  ~TruthOfARun() override { std::filesystem::remove_all(folder); }

  static std::shared_ptr<dds::Node> node_on(int domain) {
    dds::NodeOptions options = dds::NodeOptions::from_environment("recording-test");
    options.domain = domain;
    return dds::Node::create(options);
  }
  // The scene of which the truth is told, once it is; empty if nothing comes within the time.
  std::string scene(std::chrono::milliseconds timeout = 10s) {
    for (const auto end = std::chrono::steady_clock::now() + timeout; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(10ms))
      if (recording.save_truth(recorder)) return nlohmann::json::parse(std::ifstream(folder / "truth.json")).at("scene");
    return "";
  }

  const dds::testing::TestDomain domain;
  const std::filesystem::path folder;
  const std::shared_ptr<dds::Node> node;
  Recording recording;
  const RunRecorder recorder;
};

TEST_F(TruthOfARun, IsThatOfTheSimulatorThatRunsNow) {
  {
    const TruthTeller first(*node, "bunny");
    EXPECT_EQ(scene(), "bunny");
    recording.clear();
    EXPECT_EQ(scene(), "bunny");   // told once, and read again for the second run
  }
  recording.clear();
  EXPECT_EQ(scene(500ms), "");     // who told it is gone
  const TruthTeller second(*node, "triceratops");
  EXPECT_EQ(scene(), "triceratops");
}

}  // namespace
}  // namespace periplus::supervisor
