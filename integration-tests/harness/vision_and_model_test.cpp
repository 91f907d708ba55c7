// Vision and model server together, fed with images made without the simulator: the voxels that come out, against the truth.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "common/wire/object_wire.h"
#include "idl/model.h"
#include "idl/vision.h"
#include "integration-tests/harness/camera_injector.h"
#include "integration-tests/harness/test_bench.h"

namespace periplus::harness {
namespace {

using namespace std::chrono_literals;
using voxel::VoxelState;

// How a grid compares with the ball.
struct Comparison {
  int touching = 0, touching_emptied = 0;  // voxels that the surface runs through, above the table
  int ghosts = 0, volume = 0;              // occupied voxels wholly outside; voxels wholly or partly within
  double coverage = 0;                     // of the surface that eyes at 1.2 m can see: a known voxel within one voxel
  int known_astray = 0;                    // known voxels farther than 2.5 voxels from the surface
};

Comparison compare(const voxel::OccupancyGrid& grid) {
  Comparison c;
  const voxel::GridGeometry& g = grid.geometry();
  const Eigen::Vector3d center = BallOnTable::center();
  const auto each = [&](auto f) {
    for (int x = 0; x < g.size.x(); ++x)
      for (int y = 0; y < g.size.y(); ++y)
        for (int z = 0; z < g.size.z(); ++z) f(Eigen::Vector3i(x, y, z));
  };
  each([&](const Eigen::Vector3i& v) {
    const VoxelState state = grid.state(v);
    if (state == VoxelState::environment) return;
    // Nearest and farthest point of the voxel's cube; the grid's axes are the world's.
    const Eigen::Vector3d p = g.center_world(v) - center;
    const double half = g.voxel_size / 2;
    const double nearest = (p.cwiseAbs().array() - half).max(0.0).matrix().norm();
    const double farthest = (p.cwiseAbs().array() + half).matrix().norm();
    const bool outside = nearest > BallOnTable::kRadius;
    if (!outside) ++c.volume;
    if (outside && state != VoxelState::empty) ++c.ghosts;
    if (!outside && farthest >= BallOnTable::kRadius) {
      ++c.touching;
      c.touching_emptied += state == VoxelState::empty;
    }
    c.known_astray += state == VoxelState::known && std::abs(p.norm() - BallOnTable::kRadius) > 2.5 * g.voxel_size;
  });
  Random random(5);
  int samples = 0, covered = 0;
  while (samples < 4000) {
    const Eigen::Vector3d n = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    if (n.z() < -0.3) continue;
    ++samples;
    const Eigen::Vector3d p = center + BallOnTable::kRadius * n;
    const Eigen::Vector3i at = g.voxel_of(p);
    bool near = false;
    for (int i = 0; i < 27 && !near; ++i) {
      const Eigen::Vector3i v = at + Eigen::Vector3i(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
      near = grid.state(v) == VoxelState::known && (g.center_world(v) - p).norm() <= g.voxel_size;
    }
    covered += near;
  }
  c.coverage = static_cast<double>(covered) / samples;
  return c;
}

class VisionAndModel : public testing::Test {
 protected:
  VisionAndModel()
      : bench("vision-and-model"),
        capture(bench.node(), "vision/capture"),
        process(bench.node(), "vision/process"),
        set_environment(bench.node(), "model/set_environment"),
        begin(bench.node(), "model/begin"),
        integrate(bench.node(), "model/integrate"),
        knowledge(bench.node()) {
    bench.start("periplus-vision-server");
    bench.start("periplus-model-server");
  }
  ~VisionAndModel() override {
    if (HasFailure()) std::fputs(bench.logs().c_str(), stderr);
  }

  template <class Q, class R>
  R call(dds::RpcClient<Q, R>& client, const std::string& rpc, Q request) {
    R reply;
    client.call(request, reply, {.deadline = 60s, .wait_for_server = 30s}).throw_if_failed(rpc);
    return reply;
  }

  // Environment, object, and a look from each azimuth; the grid after the last one.
  voxel::OccupancyGrid model(CameraInjector& injector, int looks) {
    msg::SetEnvironmentRequest environment;
    environment.environment(
        wire::environment_to_wire("ball-on-table", BallOnTable::scene_yaml(), bench.robot_yaml(), bench.robot_urdf()));
    const msg::Revision environment_revision = call(set_environment, "model/set_environment", environment).revision();
    msg::BeginRequest object;
    object.object_id("ball");
    object.box(wire::to_wire(BallOnTable::box()));
    object.voxel_m(0.01);
    call(begin, "model/begin", object);
    std::uint32_t revision = 0;
    for (int i = 0; i < looks; ++i) {
      injector.stand(BallOnTable::view(2 * M_PI * i / looks + 0.3, i % 2 ? 1.35 : 1.1));
      const std::string view = "look-" + std::to_string(i);
      msg::CaptureRequest c;
      c.view_id(view);
      c.environment_revision(environment_revision);
      call(capture, "vision/capture", c);
      msg::ProcessRequest p;
      p.view_id(view);
      p.environment_revision(environment_revision);
      p.box(wire::to_wire(BallOnTable::box()));
      share = call(process, "vision/process", p).valid_share_in_box();
      msg::IntegrateRequest in;
      in.object_id("ball");
      in.view_id(view);
      const msg::IntegrateReply out = call(integrate, "model/integrate", in);
      if (i == 0) {
        EXPECT_GT(out.found_gain_px(), 0);
      }
      revision = out.revision();
    }
    const auto known = knowledge.object("ball", revision, 10s);
    require(known != nullptr, ErrorCode::not_ready, "the ball's newest revision did not arrive");
    return *known->grid;
  }

  TestBench bench;
  dds::RpcClient<msg::CaptureRequest, msg::CaptureReply> capture;
  dds::RpcClient<msg::ProcessRequest, msg::ProcessReply> process;
  dds::RpcClient<msg::SetEnvironmentRequest, msg::SetEnvironmentReply> set_environment;
  dds::RpcClient<msg::BeginRequest, msg::BeginReply> begin;
  dds::RpcClient<msg::IntegrateRequest, msg::IntegrateReply> integrate;
  wire::Knowledge knowledge;
  double share = 0;
};

void report(const Comparison& c) {
  std::printf("touching %d, emptied %d; ghosts %d of %d; coverage %.3f; known astray %d\n", c.touching, c.touching_emptied,
              c.ghosts, c.volume, c.coverage, c.known_astray);
}

TEST_F(VisionAndModel, ATexturedBallIsModelled) {
  CameraInjector injector(bench.node(), BallOnTable::scene(), bench.robot());
  const Comparison c = compare(model(injector, 6));
  report(c);
  // Stereo of rich texture, six ideal views, voxels of 1 cm.
  EXPECT_LE(c.touching_emptied, 0.01 * c.touching);
  EXPECT_GE(c.coverage, 0.95);
  EXPECT_LE(c.ghosts, 0.35 * c.volume);
  EXPECT_LE(c.known_astray, 0.01 * c.touching);
}

TEST_F(VisionAndModel, APlainBallGetsThePoorModelThatItDeserves) {
  CameraInjector injector(bench.node(), BallOnTable::scene(true), bench.robot());
  const Comparison c = compare(model(injector, 4));
  report(c);
  EXPECT_LT(share, 0.8);  // the model server is told to be careful
  EXPECT_LT(c.coverage, 0.6);
  EXPECT_LE(c.touching_emptied, 0.05 * c.touching);
  EXPECT_LE(c.known_astray, 0.05 * c.touching);
}

}  // namespace
}  // namespace periplus::harness
