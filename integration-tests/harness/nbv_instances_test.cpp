// Several planners of one domain share a request: the same view, bit for bit, as one alone, whoever dies on the way.
#include <gtest/gtest.h>
#include <signal.h>

#include <thread>

#include "common/dds/codec_impl.h"
#include "common/dds/testing/eventually.h"
#include "integration-tests/harness/planner_bench.h"

namespace periplus::harness {
namespace {

using namespace std::chrono_literals;
using dds::testing::eventually;

class NbvInstances : public ::testing::Test {
 protected:
  msg::PlanViewReply ask(const msg::PlanViewRequest& q, const dds::CallOptions& options = {}) {
    msg::PlanViewReply r;
    const dds::RpcResult result = bench_.ask(q, r, options);
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

  PlannerBench bench_{"nbv-instances"};
};

TEST_F(NbvInstances, ShareARequestAndAgree) {
  bench_.start("fastdds");
  const msg::PlanViewReply alone = ask(bench_.request());
  EXPECT_EQ(alone.tasks_elsewhere(), 0u);
  EXPECT_GT(alone.tasks(), 50u);
  EXPECT_GT(alone.predicted_gain_voxels(), 50);

  // One that would compute something else is not listened to.
  Program& unlike = bench_.start("fastdds", {"--set", "evaluation.forbidden_slope=2"});
  std::this_thread::sleep_for(1s);
  for (int i = 0; i < 2; ++i) {
    const msg::PlanViewReply r = ask(bench_.request());
    EXPECT_EQ(r.tasks_elsewhere(), 0u);
    expect_same(alone, r);
  }
  unlike.signal(SIGTERM);
  unlike.wait(10s);
  ASSERT_TRUE(eventually([&] { return bench_.planners() == 1; }));

  bench_.start("cyclonedds");
  bench_.start("fastdds");
  expect_same(alone, ask_many(bench_.request()));
  for (int i = 0; i < 3; ++i) {  // whoever leads
    const msg::PlanViewReply r = ask(bench_.request());
    EXPECT_GT(r.tasks_elsewhere(), 0u);
    EXPECT_LT(r.tasks_elsewhere(), r.tasks());
    expect_same(alone, r);
  }
  msg::PlanViewRequest not_shared = bench_.request();
  not_shared.scatter(false);
  const msg::PlanViewReply r = ask(not_shared);
  EXPECT_EQ(r.tasks_elsewhere(), 0u);
  expect_same(alone, r);
}

TEST_F(NbvInstances, AgreeWhenOneIsKilledOnTheWay) {
  constexpr std::uint32_t kLong = 6000;
  bench_.start("fastdds");
  const msg::PlanViewReply alone = ask(bench_.request(kLong));
  for (const char* vendor : {"fastdds", "cyclonedds"}) {
    // Once the one that is killed helps, once it leads: calls go to the instances in turn.
    for (int i = 0; i < 2; ++i) {
      Program& doomed = bench_.start(vendor);
      ask_many(bench_.request());
      bool killed = false;
      dds::CallOptions options;
      options.progress = [&](double fraction, const std::string&) {
        if (fraction < 0.2 || killed) return;
        killed = true;
        doomed.signal(SIGKILL);
      };
      const msg::PlanViewReply r = ask(bench_.request(kLong), options);
      EXPECT_TRUE(killed);
      expect_same(alone, r);
      doomed.wait(10s);
      ASSERT_TRUE(eventually([&] { return bench_.planners() == 1; }));
    }
  }
}

TEST_F(NbvInstances, WallClockLimitBringsTheBestSoFar) {
  bench_.start("fastdds");
  const msg::PlanViewReply whole = ask(bench_.request(6000));
  msg::PlanViewRequest q = bench_.request(6000);
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
