// The whole of the comparisons, small: same numbers for any number of threads, and each is what its name says.
#include "integration-tests/thesis_comparisons/comparisons.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "integration-tests/thesis_comparisons/chart.h"
#include "integration-tests/thesis_comparisons/page.h"

namespace periplus::thesis_comparisons {
namespace {

std::shared_ptr<const robot::RobotModel> robot_model() {
  const std::string robots = PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like";
  return robot::RobotModel::load_files(robots + ".urdf", robots + ".yaml");
}

// One generated object.
const World& arch() {
  static const World world = [] {
    nbv_benchmark::SubjectOptions o;
    o.voxels = 24;
    o.samples = 200;
    return on_table(nbv_benchmark::make_subject("arch", generated_shapes().back().second, "z", o), robot_model());
  }();
  return world;
}

TEST(Worlds, LooksCarveAndStartsSeeSomething) {
  const auto before = carved(arch(), 0, 2, 1), after = carved(arch(), 2, 2, 1);
  EXPECT_GT(before->situation.grid->counts().unknown, after->situation.grid->counts().unknown);
  EXPECT_EQ(before->situation.grid->counts().known, 0u);
  EXPECT_GT(after->situation.grid->counts().known, 100u);
  nbv::Evaluator::Workspace w;
  for (const Pose& start : after->starts) {
    const LocalOutcome o = outcome_of(*after, start, w);
    EXPECT_GT(o.evaluation.value, 0);
    EXPECT_EQ(o.evaluation.violation, nbv::Violation::none);
    EXPECT_TRUE(o.within);
    EXPECT_LE(o.f_free, o.f_e);
  }
}

TEST(LocalRuns, NeverWorseThanTheirStartAndWithinTheirBounds) {
  const auto state = carved(arch(), 2, 3, 2);
  nbv::Evaluator::Workspace w;
  for (const Pose& start : state->starts) {
    const LocalOutcome from = outcome_of(*state, start, w);
    for (const auto method : {nbv::LocalMethod::newuoa, nbv::LocalMethod::bobyqa, nbv::LocalMethod::nelder_mead}) {
      LocalOptions o;
      o.method = method;
      o.rho_end = 1e-3;
      const LocalOutcome once = search_locally(*state, start, o, w);
      o.runs = 4;
      const LocalOutcome iterated = search_locally(*state, start, o, w);
      const auto value = [&](const LocalOutcome& x) { return method == nbv::LocalMethod::newuoa ? x.f_e : x.f_free; };
      EXPECT_LE(value(once), value(from));
      EXPECT_LE(value(iterated), value(once));
      EXPECT_GE(iterated.evaluations, once.evaluations);
      EXPECT_GT(once.evaluations, 13);
      EXPECT_EQ(once.course.back().second, value(once));
      EXPECT_LE(once.evaluations_to(1e9), once.evaluations_to(0));
      EXPECT_LE(once.evaluations_to(0), once.evaluations);
      EXPECT_TRUE(once.within || method == nbv::LocalMethod::newuoa);
      // What is told of a result is what its pose is worth.
      EXPECT_EQ(outcome_of(*state, once.X_WC, w).f_e, once.f_e);
    }
  }
}

TEST(Comparisons, SameForAnyNumberOfThreads) {
  ComparisonOptions o;
  o.robot = robot_model();
  o.voxels = 12;
  o.starts = 1;
  o.line_steps = 3;
  o.large_objects = 0;
  o.generated = 1;
  std::string texts[2];
  for (const int threads : {1, 2}) {
    o.threads = threads;
    Comparisons c = run_comparisons(o, [](const std::string&) {});
    EXPECT_EQ(c.objects, std::vector<std::string>{"ring"});
    EXPECT_EQ(c.trust_region.cases, 1);
    EXPECT_EQ(c.sampling.cases, 3);
    c.quantifications.runs = {{"x", "pixels", 1, {0.5, 1}, {1, 1}, 2, 2}, {"x", "voxels", 1, {0.5, 1}, {1, 1}, 2, 2}, {"x", "mixed", 1, {1}, {1}, 1, 1}};
    texts[threads - 1] = to_json(c, o, {}).dump() + page(c, o, {}, "f");
    for (const Figure& f : figures(c)) texts[threads - 1] += f.svg;
  }
  EXPECT_EQ(texts[0], texts[1]);
  EXPECT_NE(texts[0].find("Mixed saves 50 % at 90 %"), std::string::npos);
}

TEST(Median, IsTheMiddleOne) {
  EXPECT_EQ(median({}), 0);
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
}

TEST(Charts, RefuseWhatCannotBeDrawn) {
  const std::string svg = line_chart("a < b & c", {"x"}, {"y"}, {{"s", {1, 2}, {3, 4}}});
  EXPECT_NE(svg.find("a &lt; b &amp; c"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  // The first point at the left of the drawing, the last at the right: 1 and 2 of 1..2.
  EXPECT_NE(svg.find("points=\"74.0,"), std::string::npos) << svg;
  EXPECT_NE(svg.find(" 704.0,"), std::string::npos) << svg;
  EXPECT_THROW(line_chart("t", {"x"}, {"y"}, {}), Error);
  EXPECT_THROW(line_chart("t", {"x"}, {"y"}, {{"s", {1, 2}, {3}}}), Error);
  EXPECT_THROW(line_chart("t", {"x"}, {"y"}, {{"s", {1}, {std::nan("")}}}), Error);
  EXPECT_THROW(line_chart("t", {"x", true}, {"y"}, {{"s", {0}, {1}}}), Error);
  EXPECT_THROW(shaded_table("t", "r", {"1"}, "c", {"1", "2"}, {{1}}, 1), Error);
  EXPECT_NE(shaded_table("t", "r", {"1"}, "c", {"1", "2"}, {{1, 2.25}}, 1).find(">2.2<"), std::string::npos);
}

}  // namespace
}  // namespace periplus::thesis_comparisons
