#include "services/nbv_planner/tool/term_map.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/core/file.h"
#include "services/nbv_planner/testing/situations.h"

namespace periplus::nbv {
namespace {

Situation beside_an_obstacle() {
  scene::Scene scene;
  scene.solids.push_back(testing::box({1.2, 0, 1}, {0.4, 0.4, 2}));
  Situation s = testing::patch_at_plus_x(scene);
  s.forbidden.push_back(look_at({0, 1, 1.2}, {0, 0, 1.1}));
  return s;
}

TEST(TermMap, EachPlaceHasWhatTheEvaluatorSaysOfIt) {
  const Situation s = beside_an_obstacle();
  const Evaluator evaluator(s, {}, {});
  const TermMaps maps = map_terms_around(evaluator, {"N_u", "K_distance", "K_forbidden", "f_e"}, {.height = 1.2, .half_width = 1.5, .step = 0.25, .threads = 2});
  ASSERT_EQ(maps.count, 13);
  ASSERT_EQ(maps.maps.size(), 4u);
  EXPECT_NEAR(maps.first.x(), -1.5, 1e-12);
  const auto value = [&](int map, double x, double y) {
    return maps.maps[map].values[static_cast<std::size_t>(std::lround((y + 1.5) / 0.25)) * 13 + static_cast<std::size_t>(std::lround((x + 1.5) / 0.25))];
  };
  // Inside the obstacle and inside a voxel there is nothing; the patch faces +x, the obstacle hides it from behind.
  EXPECT_TRUE(std::isnan(value(0, 1.25, 0)));
  EXPECT_TRUE(std::isnan(value(0, 0, 0)));
  EXPECT_EQ(value(0, -1.5, 0), 0);
  EXPECT_GT(value(0, 0.75, 0), 100);
  EXPECT_EQ(value(0, 1.5, 0), 0);
  EXPECT_GT(value(2, 0, 1), value(2, 0, -1));
  // By hand at one place: the middle of the eyes at (0.75, 0.5, 1.2), looking at (0, 0, 1.1).
  Evaluator::Workspace workspace;
  const double yaw = std::atan2(-0.5, -0.75), pitch = std::atan2(0.1, std::hypot(0.75, 0.5));
  const Pose X = look_along({0.75, 0.5, 1.2}, yaw, pitch) * Pose(Eigen::Translation3d(-0.072, 0, 0));
  const Evaluation e = evaluator.evaluate(X, workspace, Detail::every_term);
  EXPECT_EQ(value(0, 0.75, 0.5), e.gain.voxels);
  EXPECT_NEAR(value(1, 0.75, 0.5), e.k_distance, 1e-12);
  EXPECT_NEAR(value(3, 0.75, 0.5), evaluator.score(e, maps.greatest), 1e-9);
  // K_d = exp(20 (0.6 - distance)), 3.8: the distance is to the nearest centre of the block's voxels.
  const Eigen::Vector3d eye = X.translation();
  EXPECT_NEAR(value(1, 0.75, 0.5), std::exp(20 * (0.6 - (eye - Eigen::Vector3d(0.14, 0.14, 1.2)).norm())), 0.02);
}

TEST(TermMap, AnyNumberOfThreadsGivesTheSame) {
  const Situation s = beside_an_obstacle();
  const Evaluator evaluator(s, {}, {});
  MapSettings settings{.height = 1.2, .half_width = 1, .step = 0.2, .threads = 1};
  const TermMaps one = map_terms_around(evaluator, map_terms(), settings);
  settings.threads = 3;
  const TermMaps three = map_terms_around(evaluator, map_terms(), settings);
  for (std::size_t m = 0; m < one.maps.size(); ++m) {
    bool any = false;
    for (std::size_t i = 0; i < one.maps[m].values.size(); ++i) {
      const double a = one.maps[m].values[i], b = three.maps[m].values[i];
      EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
      any |= std::isfinite(a);
    }
    EXPECT_TRUE(any) << one.maps[m].term;  // every name is one that the evaluator knows
  }
}

TEST(TermMap, RefusesWhatMakesNoMap) {
  const Situation s = beside_an_obstacle();
  const Evaluator evaluator(s, {}, {});
  const auto refusal = [&](const std::vector<std::string>& terms, const MapSettings& settings) -> std::string {
    try {
      map_terms_around(evaluator, terms, settings);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::bad_input);
      return e.what();
    }
    return "";
  };
  EXPECT_NE(refusal({"K_distence"}, {}).find("did you mean 'K_distance'"), std::string::npos);
  EXPECT_NE(refusal({}, {}), "");
  EXPECT_NE(refusal({"N_u"}, {.height = std::nan("")}), "");
  EXPECT_NE(refusal({"N_u"}, {.step = 0}), "");
  EXPECT_NE(refusal({"N_u"}, {.half_width = 50, .step = 0.01}).find("million"), std::string::npos);
}

TEST(TermMap, IsWrittenAsNumbersAndAsAPicture) {
  const Situation s = beside_an_obstacle();
  const Evaluator evaluator(s, {}, {});
  const TermMaps maps = map_terms_around(evaluator, {"f_e", "N_u"}, {.height = 1.2, .half_width = 1, .step = 0.5});
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("periplus_term_map_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  write_maps(folder / "map.csv", evaluator, maps, "", {});
  std::istringstream lines(read_file(folder / "map.csv"));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "x_m,y_m,z_m,f_e,N_u");
  int count = 0;
  while (std::getline(lines, line)) {
    double x = 0, y = 0, z = 0, f = 0, n = 0;
    const int numbers = std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &x, &y, &z, &f, &n);
    if (std::isfinite(maps.maps[1].values[count])) {
      EXPECT_EQ(numbers, 5);
      EXPECT_NEAR(n, maps.maps[1].values[count], 1e-6);
    } else {
      EXPECT_EQ(numbers, 3) << line;  // nothing stands there
    }
    ++count;
  }
  EXPECT_EQ(count, 25);
  for (const char* name : {"map.png", "map.svg"}) {
    write_maps(folder / name, evaluator, maps, "title", {look_at({1, 1, 1.2}, {0, 0, 1.1})});
    EXPECT_GT(std::filesystem::file_size(folder / name), 5000u);
  }
  std::filesystem::remove_all(folder);
}

TEST(TermMap, EveryTermCanBeMappedQualityToo) {
  Situation s = testing::around_the_origin(15, [](int x, int y, int z) {
    const auto inside = [](int v) { return v > 1 && v < 13; };
    return !inside(x) || !inside(y) || !inside(z) ? voxel::VoxelState::empty : x == 12 ? voxel::VoxelState::unknown : voxel::VoxelState::known;
  });
  s.views = {look_at({-1, 2, 1.1}, {0, 0, 1.1})};
  EvaluationSettings settings;
  settings.quality_weight = 1;
  const Evaluator evaluator(s, settings, {});
  std::set<std::string> terms;
  for (const auto& [name, value] : evaluator.terms({}, 1))
    if (!name.starts_with("lambda_")) terms.insert(name);
  const std::vector<std::string> mapped = map_terms();
  EXPECT_EQ(terms, std::set<std::string>(mapped.begin(), mapped.end()));
  const TermMaps maps = map_terms_around(evaluator, {"quality"}, {.height = 1.1, .half_width = 1.2, .step = 0.3});
  // The view was in front of the faces at -x and +y, aslant: from straight before them much can be seen better, from +x, where
  // all is unknown, nothing.
  const auto at = [&](double x, double y) {
    const auto column = static_cast<int>(std::lround((x + 1.2) / 0.3)), row = static_cast<int>(std::lround((y + 1.2) / 0.3));
    return maps.maps.at(0).values.at(static_cast<std::size_t>(row * maps.count + column));
  };
  EXPECT_GT(at(-0.9, 0), 20);
  EXPECT_GT(at(0, 0.9), 20);
  EXPECT_LT(at(0.9, 0), 1);
}

}  // namespace
}  // namespace periplus::nbv
