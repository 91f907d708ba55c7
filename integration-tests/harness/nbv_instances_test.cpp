// Several planners of one domain share a request: the same view, bit for bit, as one alone, whoever dies on the way.
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <thread>

#include "common/core/random.h"
#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/dds/testing/eventually.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_wire.h"
#include "idl/model.h"
#include "idl/nbv.h"
#include "integration-tests/harness/test_bench.h"

namespace periplus::harness {
namespace {

using namespace std::chrono_literals;
using dds::testing::eventually;
using voxel::VoxelState;

// The ball as it is known after a look or two, with holes and bumps that a search can get lost in.
voxel::OccupancyGrid half_known_ball() {
  voxel::GridGeometry g;
  g.voxel_size = 0.01;
  g.size = {40, 40, 36};
  g.X_WG = make_pose({-0.2, -0.2, 0.7}, Eigen::Matrix3d::Identity());
  voxel::OccupancyGrid grid(g);
  Random random(3);
  for (int x = 0; x < g.size.x(); ++x) {
    for (int y = 0; y < g.size.y(); ++y) {
      for (int z = 0; z < g.size.z(); ++z) {
        const Eigen::Vector3d p = g.center_world({x, y, z}) - BallOnTable::center();
        const double r = p.norm() + 0.01 * std::sin(40 * p.x() + 25 * p.z());
        const bool unknown = p.x() + 0.3 * p.y() > 0.02 || random.uniform() < 0.05;
        grid.set_state({x, y, z}, r > BallOnTable::kRadius ? VoxelState::empty : unknown ? VoxelState::unknown : VoxelState::known);
      }
    }
  }
  grid.revision = 1;
  return grid;
}

class NbvInstances : public ::testing::Test {
 protected:
  using Client = dds::RpcClient<msg::PlanViewRequest, msg::PlanViewReply>;

  NbvInstances() : bench_("nbv-instances"), client_(bench_.node(), "nbv/plan"), environments_(bench_.node(), "periplus/environment", dds::qos_latest()),
                   objects_(bench_.node(), "periplus/object", dds::qos_latest()) {
    environment_ = wire::environment_to_wire("ball-on-table", BallOnTable::scene_yaml(), bench_.robot_yaml(), bench_.robot_urdf());
    environments_.publish(environment_);
    objects_.publish(wire::object_to_wire("ball", half_known_ball(), {}));
  }

  Program& start(const char* vendor, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"--set", "search.threads=1"});
    const int before = client_.servers();
    Program& program = bench_.start("periplus-nbv-planner", more, {{"PERIPLUS_DDS", vendor}});
    EXPECT_TRUE(eventually([&] { return client_.servers() > before; })) << bench_.logs();
    return program;
  }

  msg::PlanViewRequest request(std::uint32_t evaluations = 1200) const {
    msg::PlanViewRequest q;
    q.plan_id("plan");
    q.object_id("ball");
    q.revision(1);
    q.environment_revision(environment_.revision());
    q.rig(wire::to_wire(bench_.robot()->stereo_rig()));
    q.pose_world_camera(wire::to_wire(BallOnTable::view(3)));
    q.height_min_m(1.0);
    q.height_max_m(1.35);
    q.distance_min_m(0.6);
    q.distance_max_m(2.5);
    q.pitch_min_rad(-0.4);
    q.pitch_max_rad(1.0);
    q.seed(1);
    q.max_evaluations(evaluations);
    q.scatter(true);
    return q;
  }

  msg::PlanViewReply ask(msg::PlanViewRequest q, dds::CallOptions options = {}) {
    options.deadline = 60s;
    options.wait_for_server = 10s;
    msg::PlanViewReply r;
    const dds::RpcResult result = client_.call(q, r, options);
    EXPECT_TRUE(result.ok()) << dds::to_string(result.status) << " " << result.error_message << "\n" << bench_.logs();
    return r;
  }

  static void expect_same(const msg::PlanViewReply& a, const msg::PlanViewReply& b) {
    EXPECT_EQ(a.pose_world_camera(), b.pose_world_camera());  // compares doubles exactly
    EXPECT_EQ(a.score(), b.score());
    EXPECT_EQ(a.predicted_gain_voxels(), b.predicted_gain_voxels());
    EXPECT_EQ(a.predicted_gain_px(), b.predicted_gain_px());
    EXPECT_EQ(a.evaluations(), b.evaluations());
    EXPECT_EQ(a.terms(), b.terms());
    EXPECT_FALSE(b.cut_short());
  }

  // Asks until others take part: planners need a moment to find each other.
  msg::PlanViewReply ask_many(const msg::PlanViewRequest& q) {
    msg::PlanViewReply r;
    EXPECT_TRUE(eventually([&] {
      r = ask(q);
      return r.tasks_elsewhere() > 0;
    })) << bench_.logs();
    return r;
  }

  TestBench bench_;
  Client client_;
  dds::Publisher<msg::Environment> environments_;
  dds::Publisher<msg::ObjectGrid> objects_;
  msg::Environment environment_;
};

TEST_F(NbvInstances, ShareARequestAndAgree) {
  start("fastdds");
  const msg::PlanViewReply alone = ask(request());
  EXPECT_EQ(alone.tasks_elsewhere(), 0u);
  EXPECT_GT(alone.tasks(), 50u);
  EXPECT_GT(alone.predicted_gain_voxels(), 50);

  // One that would compute something else is not listened to.
  Program& unlike = start("fastdds", {"--set", "evaluation.forbidden_slope=2"});
  std::this_thread::sleep_for(1s);
  for (int i = 0; i < 2; ++i) {
    const msg::PlanViewReply r = ask(request());
    EXPECT_EQ(r.tasks_elsewhere(), 0u);
    expect_same(alone, r);
  }
  unlike.signal(SIGTERM);
  unlike.wait(10s);
  ASSERT_TRUE(eventually([&] { return client_.servers() == 1; }));

  start("cyclonedds");
  start("fastdds");
  expect_same(alone, ask_many(request()));
  for (int i = 0; i < 3; ++i) {  // whoever leads
    const msg::PlanViewReply r = ask(request());
    EXPECT_GT(r.tasks_elsewhere(), 0u);
    EXPECT_LT(r.tasks_elsewhere(), r.tasks());
    expect_same(alone, r);
  }
  msg::PlanViewRequest not_shared = request();
  not_shared.scatter(false);
  const msg::PlanViewReply r = ask(not_shared);
  EXPECT_EQ(r.tasks_elsewhere(), 0u);
  expect_same(alone, r);
}

TEST_F(NbvInstances, AgreeWhenOneIsKilledOnTheWay) {
  constexpr std::uint32_t kLong = 6000;
  start("fastdds");
  const msg::PlanViewReply alone = ask(request(kLong));
  for (const char* vendor : {"fastdds", "cyclonedds"}) {
    // Once the one that is killed helps, once it leads: calls go to the instances in turn.
    for (int i = 0; i < 2; ++i) {
      Program& doomed = start(vendor);
      ask_many(request());
      bool killed = false;
      dds::CallOptions options;
      options.progress = [&](double fraction, const std::string&) {
        if (fraction < 0.2 || killed) return;
        killed = true;
        doomed.signal(SIGKILL);
      };
      const msg::PlanViewReply r = ask(request(kLong), options);
      EXPECT_TRUE(killed);
      expect_same(alone, r);
      doomed.wait(10s);
      ASSERT_TRUE(eventually([&] { return client_.servers() == 1; }));
    }
  }
}

TEST_F(NbvInstances, WallClockLimitBringsTheBestSoFar) {
  start("fastdds");
  const msg::PlanViewReply whole = ask(request(6000));
  msg::PlanViewRequest q = request(6000);
  q.time_limit_s(0.02);
  const msg::PlanViewReply cut = ask(q);
  EXPECT_TRUE(cut.cut_short());
  EXPECT_GT(cut.evaluations(), 0u);
  EXPECT_LT(cut.evaluations(), whole.evaluations());
  EXPECT_GT(cut.predicted_gain_voxels(), 0);
  EXPECT_LE(cut.predicted_gain_voxels(), 1.02 * whole.predicted_gain_voxels());
  q.time_limit_s(600);
  expect_same(whole, ask(q));
}

}  // namespace
}  // namespace periplus::harness
