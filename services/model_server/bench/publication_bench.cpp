// What the model server sends of an object, how soon who comes late has it, and what its landmarks take.
//
// `views`: a sphere of 0.3 m in a box of 0.5 m, carved from twelve views of 320x240; time to split and pack the chunks of all twelve.
// `kB_view`: sent for a view on average; beside it `kB_all`, all chunks of the last revision, and `kB_planes`, its planes as they lie in
// memory, which is what one sample of the whole grid takes.
// `late`: from the subscription of a reader in another node until it holds the whole of the last revision. `one_sample` does the same with
// its planes in one sample of the same quality of service.
//
// `landmarks`: of views with 300 features each, 240 of them of spots that all views see; `anew` matches all pairs of views, `kept` those of
// the last view with the others.
#include <benchmark/benchmark.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/core/random.h"
#include "common/dds/codec_impl.h"
#include "common/dds/testing/eventually.h"
#include "common/dds/testing/test_domain.h"
#include "common/object_model/landmarks.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/wire/knowledge.h"
#include "common/wire/object_publisher.h"

namespace periplus::model {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kViews = 12;

// The grid after each view, the first all unknown.
const std::vector<voxel::OccupancyGrid>& revisions(int cells) {
  static std::map<int, std::vector<voxel::OccupancyGrid>> known;
  auto& grids = known[cells];
  if (!grids.empty()) return grids;
  const object_model::testing::Sphere sphere;
  const object_model::ObjectBox box = object_model::testing::box_around(sphere);
  object_model::ObjectModel model("sphere", box, box.size.x() / cells, {});
  grids.push_back(model.grid());
  for (int n = 0; n < kViews; ++n) {
    model.integrate(object_model::testing::ideal_view(sphere, n, kViews), {}, {});
    grids.push_back(model.grid());
  }
  return grids;
}

double kilobytes(const wire::ObjectOnWire& object) {
  std::size_t octets = dds::codec<msg::ObjectRevision>().size(&object.revision);
  for (const msg::ObjectChunk& chunk : object.chunks) octets += dds::codec<msg::ObjectChunk>().size(&chunk);
  return 1e-3 * static_cast<double>(octets);
}

void views(benchmark::State& state) {
  const auto& grids = revisions(static_cast<int>(state.range(0)));
  double sent = 0;
  for (auto _ : state) {
    state.PauseTiming();
    wire::ObjectSplitter splitter;
    splitter.split("sphere", grids[0]);
    state.ResumeTiming();
    sent = 0;
    for (std::size_t n = 1; n < grids.size(); ++n) {
      const wire::ObjectOnWire object = splitter.split("sphere", grids[n]);
      state.PauseTiming();
      sent += kilobytes(object);
      state.ResumeTiming();
    }
  }
  state.counters["kB_view"] = sent / kViews;
  state.counters["kB_all"] = kilobytes(wire::ObjectSplitter().split("sphere", grids.back()));
  state.counters["kB_planes"] = 3 * 8e-3 * static_cast<double>(grids.back().occupied().size());
}

std::shared_ptr<dds::Node> node(const dds::testing::TestDomain& domain, const char* vendor) {
  dds::NodeOptions options;
  options.name = "publication_bench";
  options.vendor = vendor;
  options.domain = domain.id();
  return dds::Node::create(options);
}

// Seconds that `join` takes in a new node of the vendor.
template <class Join>
void joining(benchmark::State& state, const dds::testing::TestDomain& domain, const char* vendor, Join&& join) {
  for (auto _ : state) {
    const auto late = node(domain, vendor);
    std::this_thread::sleep_for(std::chrono::seconds(1));  // participants have found each other
    const auto start = Clock::now();
    if (!join(*late)) return state.SkipWithError("the object did not arrive");
    state.SetIterationTime(std::chrono::duration<double>(Clock::now() - start).count());
  }
}

void late(benchmark::State& state, const char* writer, const char* reader) {
  const auto& grids = revisions(static_cast<int>(state.range(0)));
  const dds::testing::TestDomain domain;
  const auto server = node(domain, writer);
  wire::ObjectPublisher objects(*server);
  for (const auto& grid : grids) objects.publish("sphere", grid);
  joining(state, domain, reader, [&](dds::Node& node) {
    return wire::Knowledge(node).object("sphere", grids.back().revision, std::chrono::seconds(60)) != nullptr;
  });
}

void one_sample(benchmark::State& state, const char* writer, const char* reader) {
  const auto& grid = revisions(static_cast<int>(state.range(0))).back();
  const dds::testing::TestDomain domain;
  const auto server = node(domain, writer);
  dds::Publisher<msg::ModelFile> out(*server, "planes", dds::qos_latest());
  msg::ModelFile file;
  for (const auto* plane : {&grid.occupied(), &grid.known(), &grid.environment()}) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(plane->data());
    file.data().insert(file.data().end(), bytes, bytes + plane->size() * 8);
  }
  if (!out.publish(file)) return state.SkipWithError("could not be published");
  joining(state, domain, reader, [](dds::Node& node) {
    std::atomic<bool> here{false};
    const dds::Subscriber<msg::ModelFile> in(node, "planes", dds::qos_latest(), [&](const msg::ModelFile&) { here = true; });
    return dds::testing::eventually([&] { return here.load(); }, std::chrono::seconds(60));
  });
}

std::vector<std::shared_ptr<const object_model::View>> views_of_spots(int count) {
  Random random(1);
  std::vector<object_model::Feature> spots(240);
  const auto draw = [&](object_model::Feature& f) {
    f.p_W = {random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(0.8, 1.2)};
    f.normal_W = {0, 0, 1};
    f.size_m = 0.006;
    f.descriptor.resize(128);
    for (auto& octet : f.descriptor) octet = static_cast<std::uint8_t>(random.below(90));
  };
  for (object_model::Feature& f : spots) draw(f);
  std::vector<std::shared_ptr<const object_model::View>> out;
  for (int n = 0; n < count; ++n) {
    object_model::View view;
    view.X_WC = look_at({0.3 * std::cos(n), 0.3 * std::sin(n), 2}, {0, 0, 1});
    view.features = spots;
    view.features.resize(300);
    for (std::size_t f = 0; f < view.features.size(); ++f) {
      if (f >= spots.size()) draw(view.features[f]);
      view.features[f].u = static_cast<float>(f);
      view.features[f].size = 4;
    }
    out.push_back(std::make_shared<const object_model::View>(std::move(view)));
  }
  return out;
}

void landmarks_anew(benchmark::State& state) {
  const auto views = views_of_spots(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(object_model::merge_landmarks(views));
}

void landmarks_kept(benchmark::State& state) {
  const auto views = views_of_spots(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    state.PauseTiming();
    object_model::KeptMatches kept;
    object_model::merge_landmarks(std::span(views).first(views.size() - 1), {}, &kept);
    state.ResumeTiming();
    benchmark::DoNotOptimize(object_model::merge_landmarks(views, {}, &kept));
  }
}

BENCHMARK(landmarks_anew)->ArgName("views")->Arg(12)->Arg(24)->Unit(benchmark::kMillisecond);
BENCHMARK(landmarks_kept)->ArgName("views")->Arg(12)->Arg(24)->Unit(benchmark::kMillisecond);
BENCHMARK(views)->ArgName("cells")->Arg(64)->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond);
#define LATE(what, from, to) \
  BENCHMARK_CAPTURE(what, from##_to_##to, #from, #to)->ArgName("cells")->Arg(128)->Arg(256)->UseManualTime()->Iterations(3)->Unit(benchmark::kMillisecond)
LATE(late, fastdds, fastdds);
LATE(one_sample, fastdds, fastdds);
LATE(late, cyclonedds, cyclonedds);
LATE(one_sample, cyclonedds, cyclonedds);
LATE(late, fastdds, cyclonedds);
LATE(one_sample, fastdds, cyclonedds);
LATE(late, cyclonedds, fastdds);
LATE(one_sample, cyclonedds, fastdds);

}  // namespace
}  // namespace periplus::model
