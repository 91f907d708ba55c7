// What sharing a request between planners gains: wall time of one planner alone and of two and three that share it, one thread
// each, on this host. The view is compared too. Prints a line for each; the first is the baseline.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

#include "common/core/error.h"
#include "common/dds/codec_impl.h"
#include "integration-tests/harness/planner_bench.h"

int main() {
  using namespace periplus;
  using Clock = std::chrono::steady_clock;
  constexpr int kCalls = 15;
  try {
    harness::PlannerBench bench("nbv-instances-bench");
    std::printf("%u cores; median of %d calls\n%9s %10s %8s %16s %10s\n", std::thread::hardware_concurrency(), kCalls, "planners", "wall [ms]", "gain", "tasks elsewhere",
                "same view");
    double alone = 0;
    msg::PlanViewReply first;
    for (int planners = 1; planners <= 3; ++planners) {
      bench.start("fastdds");
      std::this_thread::sleep_for(std::chrono::seconds(2));  // until they know each other
      std::vector<double> ms;
      double elsewhere = 0;
      bool same = true;
      for (int i = 0; i < kCalls; ++i) {
        msg::PlanViewReply reply;
        const auto begin = Clock::now();
        bench.ask(bench.request(0), reply).throw_if_failed("nbv/plan");
        ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
        elsewhere += static_cast<double>(reply.tasks_elsewhere()) / reply.tasks() / kCalls;
        if (planners == 1 && i == 0) first = reply;
        same = same && reply.pose_world_camera() == first.pose_world_camera() && reply.score() == first.score() && reply.evaluations() == first.evaluations();
      }
      std::sort(ms.begin(), ms.end());
      if (planners == 1) alone = ms[kCalls / 2];
      std::printf("%9d %10.0f %7.2fx %14.0f %% %10s\n", planners, ms[kCalls / 2], alone / ms[kCalls / 2], 100 * elsewhere, same ? "yes" : "NO");
      std::fflush(stdout);
      if (!same) return 1;
    }
    return 0;
  } catch (const Error& e) {
    std::fprintf(stderr, "nbv_instances_bench: %s\n", e.what());
    return 2;
  }
}
