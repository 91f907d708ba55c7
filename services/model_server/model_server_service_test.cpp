// The program itself over DDS: one look, a kill -9, and the same answers from what comes back.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "common/core/hash.h"
#include "common/dds/codec_impl.h"
#include "common/dds/testing/test_domain.h"
#include "common/object_model/model_file.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_wire.h"
#include "common/wire/perception_wire.h"
#include "common/wire/testing/environment_texts.h"

namespace periplus::model {
namespace {

using namespace std::chrono_literals;
using object_model::testing::box_around;
using object_model::testing::ideal_view;
using object_model::testing::Sphere;

// periplus-model-server on a store of its own.
class Program {
 public:
  Program(const std::string& store, int domain) {
    pid_ = ::fork();
    if (pid_ == 0) {
      ::setenv("PERIPLUS_DOMAIN", std::to_string(domain).c_str(), 1);
      const std::string program = PERIPLUS_BIN_DIR "/periplus-model-server", set = "store_folder=" + store;
      ::execl(program.c_str(), program.c_str(), "--set", set.c_str(), "--set", "perception_wait_s=0.5", nullptr);
      ::_exit(127);
    }
  }
  ~Program() { end(SIGTERM); }
  // True if it ended by itself, with this exit status.
  bool ended_with(int wanted) {
    int status = 0;
    for (const auto limit = std::chrono::steady_clock::now() + 20s; std::chrono::steady_clock::now() < limit; std::this_thread::sleep_for(20ms))
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) && WEXITSTATUS(status) == wanted;
      }
    return false;
  }
  int end(int signal) {
    int status = 0;
    if (pid_ > 0) {
      ::kill(pid_, signal);
      ::waitpid(pid_, &status, 0);
    }
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_ = -1;
};

// Keeps the newest model file.
struct Files {
  std::mutex mutex;
  std::condition_variable arrived;
  msg::ModelFile newest;
  void put(const msg::ModelFile& f) {
    {
      std::lock_guard lock(mutex);
      newest = f;
    }
    arrived.notify_all();
  }
  std::string wait(const std::string& sha256) {
    std::unique_lock lock(mutex);
    arrived.wait_for(lock, 10s, [&] { return newest.sha256().to_string() == sha256; });
    return wire::text_from_wire(newest.data());
  }
};

// A place for stores that is not there yet.
std::string empty_folder(const std::string& name) {
  const std::string folder = ::testing::TempDir() + "model_server_service_test." + name + "." + std::to_string(::getpid());
  std::filesystem::remove_all(folder);
  return folder;
}

auto node_on(const dds::testing::TestDomain& domain) {
  dds::NodeOptions options;
  options.name = "model_server_service_test";
  options.domain = domain.id();
  return dds::Node::create(options);
}

TEST(ModelServer, ServesALookAndGoesOnAfterAKill) {
  const std::string store = empty_folder("first");
  const dds::testing::TestDomain domain;
  const auto node = node_on(domain);
  const dds::CallOptions patient{.deadline = 20s, .progress = {}, .cancelled = {}, .wait_for_server = 20s};

  dds::Publisher<msg::Perception> perceptions(*node, "periplus/perception", dds::qos_latest(8));
  dds::RpcClient<msg::SetEnvironmentRequest, msg::SetEnvironmentReply> set_environment(*node, "model/set_environment");
  dds::RpcClient<msg::BeginRequest, msg::BeginReply> begin(*node, "model/begin");
  dds::RpcClient<msg::IntegrateRequest, msg::IntegrateReply> integrate(*node, "model/integrate");
  dds::RpcClient<msg::ExportRequest, msg::ExportReply> export_model(*node, "model/export");
  dds::RpcClient<msg::DigestRequest, msg::DigestReply> digest(*node, "model/digest");
  Files files;
  dds::Subscriber<msg::ModelFile> files_in(*node, "periplus/model/file", dds::qos_stream(4), [&](const msg::ModelFile& f) { files.put(f); });
  const wire::Knowledge knowledge(*node);
  auto program = std::make_unique<Program>(store, domain.id());

  // An object needs an environment.
  const Sphere sphere;
  msg::BeginRequest begin_request;
  begin_request.object_id("ball");
  begin_request.box(wire::to_wire(box_around(sphere)));
  begin_request.voxel_m(0.02);
  msg::BeginReply begun;
  EXPECT_EQ(begin.call(begin_request, begun, patient).error_code, static_cast<int>(ErrorCode::model_environment_missing));

  const auto texts = wire::testing::environment_texts();
  msg::SetEnvironmentRequest environment;
  environment.environment(wire::environment_to_wire(
      "room", texts.scene_yaml + "truth: {mesh: bunny.obj, longest_side_m: 0.45, up_axis: y, position_m: [0, 0, 0.7]}\n", texts.robot_yaml, texts.robot_urdf));
  msg::SetEnvironmentReply environment_reply;
  auto result = set_environment.call(environment, environment_reply, patient);
  ASSERT_TRUE(result.ok()) << result.error_message;
  const auto known = knowledge.environment(environment_reply.revision().to_string(), 10s);
  ASSERT_NE(known, nullptr);
  EXPECT_EQ(known->revision, environment_reply.revision().to_string());
  EXPECT_FALSE(known->scene.truth.has_value());  // what only a simulator may know went no further

  result = begin.call(begin_request, begun, patient);
  ASSERT_TRUE(result.ok()) << result.error_message;
  EXPECT_EQ(begun.revision(), 0u);
  begin_request.voxel_m(0.025);
  EXPECT_EQ(begin.call(begin_request, begun, patient).error_code, static_cast<int>(ErrorCode::model_object_differs));

  msg::IntegrateRequest look;
  look.object_id("ball");
  look.view_id("view-0");
  msg::IntegrateReply seen;
  EXPECT_EQ(integrate.call(look, seen, patient).error_code, static_cast<int>(ErrorCode::model_perception_not_here));
  perceptions.publish(wire::to_wire(ideal_view(sphere, 0, 6, 160, 120)));
  result = integrate.call(look, seen, patient);
  ASSERT_TRUE(result.ok()) << result.error_message;
  EXPECT_EQ(seen.revision(), 1u);
  EXPECT_GT(seen.found_gain_px(), 0);
  const auto object = knowledge.object("ball", 1, 10s);
  ASSERT_NE(object, nullptr);
  EXPECT_EQ(wire::to_wire(object->grid->counts()).known(), seen.counts().known());
  EXPECT_FALSE(object->landmarks.empty());
  ASSERT_EQ(object->views.size(), 1u);
  EXPECT_TRUE(object->views[0].isApprox(ideal_view(sphere, 0, 6, 160, 120).X_WC, 1e-12));
  look.object_id("cup");
  EXPECT_EQ(integrate.call(look, seen, patient).error_code, static_cast<int>(ErrorCode::model_object_unknown));
  look.object_id("ball");
  result = integrate.call(look, seen, patient);
  ASSERT_TRUE(result.ok());
  const msg::IntegrateReply before = seen;
  msg::DigestRequest digest_request;
  digest_request.object_id("ball");
  msg::DigestReply digest_before, digest_after;
  ASSERT_TRUE(digest.call(digest_request, digest_before, patient).ok());

  EXPECT_TRUE(WIFSIGNALED(program->end(SIGKILL)));
  program = std::make_unique<Program>(store, domain.id());
  const wire::Knowledge late(*node);  // hears what the new one republishes
  const auto resumed = late.object("ball", 1, 20s);
  ASSERT_NE(resumed, nullptr);
  ASSERT_EQ(resumed->views.size(), 1u);
  EXPECT_TRUE(resumed->views[0].isApprox(object->views[0], 1e-12));
  EXPECT_NE(late.environment(environment_reply.revision().to_string(), 10s), nullptr);
  result = integrate.call(look, seen, patient);
  ASSERT_TRUE(result.ok()) << result.error_message;
  EXPECT_EQ(seen.revision(), before.revision());
  EXPECT_EQ(seen.found_gain_px(), before.found_gain_px());
  ASSERT_TRUE(digest.call(digest_request, digest_after, patient).ok());
  EXPECT_EQ(digest_after.digest().to_string(), digest_before.digest().to_string());
  EXPECT_EQ(digest_after.views(), 1u);

  // The view a centimetre from where it was taken, and out again.
  dds::RpcClient<msg::ReviseRequest, msg::ReviseReply> revise(*node, "model/revise");
  msg::ReviseRequest better;
  better.object_id("ball");
  better.better().resize(1);
  better.better()[0].view_id("view-0");
  Pose X_WC = resumed->views[0];
  X_WC.translation().z() += 0.01;
  better.better()[0].pose_world_camera(wire::to_wire(X_WC));
  msg::ReviseReply revised;
  result = revise.call(better, revised, patient);
  ASSERT_TRUE(result.ok()) << result.error_message;
  EXPECT_GT(revised.revision(), seen.revision());
  const auto moved = late.object("ball", revised.revision(), 10s);
  ASSERT_NE(moved, nullptr);
  EXPECT_TRUE(moved->views[0].isApprox(X_WC, 1e-12));
  EXPECT_NE(moved->grid->occupied(), resumed->grid->occupied());
  better.better()[0].view_id("view-7");
  EXPECT_EQ(revise.call(better, revised, patient).error_code, static_cast<int>(ErrorCode::bad_input));
  better.better()[0].view_id("view-0");
  better.better()[0].pose_covariance()[0] = -1;
  EXPECT_EQ(revise.call(better, revised, patient).error_code, static_cast<int>(ErrorCode::bad_input));
  better.better()[0].pose_covariance()[0] = 0;
  better.better()[0].pose_world_camera(wire::to_wire(resumed->views[0]));
  ASSERT_TRUE(revise.call(better, revised, patient).ok());
  ASSERT_TRUE(digest.call(digest_request, digest_before, patient).ok());  // features that were moved there and back are rounded

  msg::ExportRequest wanted;
  wanted.object_id("ball");
  msg::ExportReply exported;
  for (const char* format : {"periplus", "ply", "obj", "glb", "points.ply", "pcd", "bt", "ot", "features.csv"}) {
    wanted.format(format);
    result = export_model.call(wanted, exported, patient);
    ASSERT_TRUE(result.ok()) << result.error_message;
    const std::string data = files.wait(exported.sha256().to_string());
    EXPECT_EQ(data.size(), exported.bytes());
    EXPECT_EQ(sha256_hex(data), exported.sha256().to_string());
    if (std::string(format) == "periplus") {
      EXPECT_EQ(object_model::read_model(data).digest(), digest_before.digest().to_string());
    }
  }
  // A second look: both poses, in the order of integration.
  perceptions.publish(wire::to_wire(ideal_view(sphere, 2, 6, 160, 120)));
  look.view_id("view-2");
  ASSERT_TRUE(integrate.call(look, seen, patient).ok());
  const auto twice = late.object("ball", seen.revision(), 10s);
  ASSERT_NE(twice, nullptr);
  ASSERT_EQ(twice->views.size(), 2u);
  EXPECT_TRUE(twice->views[0].isApprox(object->views[0], 1e-12));
  EXPECT_TRUE(twice->views[1].isApprox(ideal_view(sphere, 2, 6, 160, 120).X_WC, 1e-12));

  wanted.format("docx");
  EXPECT_EQ(export_model.call(wanted, exported, patient).error_code, static_cast<int>(ErrorCode::bad_input));
  const int status = program->end(SIGTERM);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  std::filesystem::remove_all(store);
}

// Requests would go to the one or the other, and half of a run's views into each model.
TEST(ModelServer, ASecondOneOfADomainIsRefusedWhateverItsStore) {
  const std::string store = empty_folder("second");
  const dds::testing::TestDomain domain;
  const auto node = node_on(domain);
  dds::RpcClient<msg::DigestRequest, msg::DigestReply> digest(*node, "model/digest");
  Program first(store + "/a", domain.id());
  ASSERT_TRUE(digest.wait_for_server(20s));
  Program second(store + "/b", domain.id());
  EXPECT_TRUE(second.ended_with(2));
  EXPECT_TRUE(digest.wait_for_server(1s));
  first.end(SIGKILL);
  Program heir(store + "/b", domain.id());  // the dead one does not stand in its way
  msg::DigestRequest ask;
  ask.object_id("ball");
  msg::DigestReply answer;
  EXPECT_EQ(digest.call(ask, answer, {.deadline = 20s, .progress = {}, .cancelled = {}, .wait_for_server = 20s}).error_code,
            static_cast<int>(ErrorCode::model_object_unknown));
  std::filesystem::remove_all(store);
}

}  // namespace
}  // namespace periplus::model
