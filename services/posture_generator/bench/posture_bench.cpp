// Time of one posture, feasible and hopeless. `ninja posture_bench && bin/posture_bench`
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "services/posture_generator/posture_generator.h"
#include "services/posture_generator/testing/object_on_table.h"

namespace periplus::posture {
namespace {

// Generates a posture for each of the views in turn; counters: share that was feasible, iterations for each.
void generate(benchmark::State& state, const std::vector<Pose>& views) {
  const Settings settings;
  const PostureGenerator generator(testing::hrp2like(), settings);
  const testing::ObjectOnTable room = testing::demonstration(settings);
  double feasible = 0, iterations = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    const Posture posture = generator.generate(views[i++ % views.size()], room.surroundings());
    feasible += posture.feasible ? 1 : 0;
    iterations += posture.iterations;
  }
  state.counters["feasible"] = benchmark::Counter(feasible, benchmark::Counter::kAvgIterations);
  state.counters["iterations"] = benchmark::Counter(iterations, benchmark::Counter::kAvgIterations);
}

void views_of_the_object(benchmark::State& state) {
  Random random(7);
  std::vector<Pose> views(200);
  std::generate(views.begin(), views.end(), [&] { return testing::view_of_object(random); });
  generate(state, views);
}
BENCHMARK(views_of_the_object)->Unit(benchmark::kMillisecond)->Iterations(200);

void hopeless(benchmark::State& state) { generate(state, {testing::hopeless_views()[static_cast<std::size_t>(state.range(0))].X_WC}); }
BENCHMARK(hopeless)->Unit(benchmark::kMillisecond)->DenseRange(0, 3)->Iterations(3);

}  // namespace
}  // namespace periplus::posture
