#include "integration-tests/eyes_benchmark/checks.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "integration-tests/eyes_benchmark/real_pairs.h"
#include "integration-tests/eyes_benchmark/report.h"

namespace periplus::eyes_benchmark {
namespace {

// Every value just within its limit.
BenchmarkResult good() {
  BenchmarkResult r;
  for (const char* object : {"bunny", "mug"}) {
    StereoRow s;
    s.object = object;
    s.paint = "rich";
    s.ours.valid = 0.911;
    s.ours.bad_1 = 0.029;
    s.ours.bad_2 = 0.012;
    s.ours.error = {0.002, 0.0016, 0.0069, 10};
    s.ours.behind = 0.00009;
    s.normals.median = 9.9 / kDegrees;
    s.seconds = 0.349;
    s.textured = 0.51;
    r.stereo.push_back(s);
    ModelRow m;
    m.object = object;
    m.paint = "rich";
    m.source = kStereo;
    m.quality.covered_1_5 = s.object == "mug" ? 0.966 : 0.986;
    m.quality.error = {0.0019, 0.001, 0.0049, 10};
    m.quality.inside = m.quality.touching = 1000;
    m.quality.touching_emptied = 3;
    m.labels = {1000, 100, 1000, 9, 0};
    r.models.push_back(m);
    FeatureRow other;
    other.object = object;
    other.detector = "orb";
    other.selection = "left_alone";
    r.features.push_back(other);
    FeatureRow f = other;
    f.chosen = true;
    f.place.median = 0.0019;
    f.turns = {{10, 100, 0, 0}, {20, 100, 96, 239}};
    f.landmarks = {100, 50, 48, 120};
    r.features.push_back(f);
    for (const char* source : {kWrongDisparities, kWrongPose}) {
      ModelRow spoilt = m;
      spoilt.source = source;
      spoilt.mode = object_model::CarvingMode::probabilistic;
      spoilt.quality.covered_1_5 = 0.96 * m.quality.covered_1_5;
      spoilt.quality.error.p95 = 0.019;
      r.models.push_back(spoilt);
    }
  }
  ModelRow fine = r.models[0];
  fine.voxel_m = 0.005;
  fine.quality.covered_1_5 = 0.981;
  fine.quality.error.mean = 0.0012;
  r.models.push_back(fine);
  for (const std::size_t n : {std::size_t{0}, std::size_t{3}}) {
    ModelRow by_truth = r.models[n];
    by_truth.source = kTrueDepth;
    by_truth.labels = {10000, 9, 1000, 0, 0};
    r.models.push_back(by_truth);
  }
  ModelRow own = r.models[3];
  own.paint = "own";
  own.quality.inside = 10000;
  own.quality.inside_emptied = 4;
  r.models.push_back(own);
  StereoRow plain = r.stereo[1];
  plain.paint = "own";
  plain.textured = 0.49;
  r.stereo.push_back(plain);
  for (const char* pair : {"Aloe", "Motorcycle"}) {
    RealRow real;
    real.name = pair;
    real.filled = {1000, real.name == "Aloe" ? 0.951 : 0.981, 0.2, real.name == "Aloe" ? 0.139 : 0.109};
    real.ours_where_both.bad_2 = real.plain_where_both.bad_2 = 0.02;
    r.real.push_back(real);
  }
  return r;
}

std::string failing(const BenchmarkResult& r) {
  std::string out;
  for (const Check& c : check_limits(r, {"bunny", "mug"}, true, true))
    if (!c.ok) out += c.name + " ";
  return out;
}

TEST(Checks, AllHoldJustWithin) { EXPECT_EQ(failing(good()), ""); }

TEST(Checks, EachFailsJustBeyond) {
  const auto with = [](auto change) {
    BenchmarkResult r = good();
    change(r);
    return failing(r);
  };
  EXPECT_EQ(with([](auto& r) { r.stereo[0].ours.valid = 0.909; }), "stereo.bunny.valid ");
  EXPECT_EQ(with([](auto& r) { r.stereo[0].ours.bad_1 = 0.031; }), "stereo.bunny.bad_1 ");
  EXPECT_EQ(with([](auto& r) { r.stereo[1].ours.bad_2 = 0.0131; }), "stereo.mug.bad_2 ");
  EXPECT_EQ(with([](auto& r) { r.stereo[1].ours.error.median = 0.00171; }), "stereo.mug.median ");
  EXPECT_EQ(with([](auto& r) { r.stereo[1].ours.error.p95 = 0.0071; }), "stereo.mug.p95 ");
  EXPECT_EQ(with([](auto& r) { r.stereo[1].ours.behind = 0.00011; }), "stereo.mug.behind ");
  EXPECT_EQ(with([](auto& r) { r.stereo[1].normals.median = 10.1 / kDegrees; }), "stereo.mug.normals ");
  EXPECT_EQ(with([](auto& r) { r.stereo[1].textured = 0.49; }), "stereo.mug.textured ");
  EXPECT_EQ(with([](auto& r) { r.stereo[2].textured = 0.51; }), "stereo.plain_mug.textured ");
  EXPECT_EQ(with([](auto& r) { r.models[0].quality.covered_1_5 = 0.984; }), "carved.bunny.covered ");
  EXPECT_EQ(with([](auto& r) { r.models[3].quality.covered_1_5 = 0.964; }), "carved.mug.covered ");
  EXPECT_EQ(with([](auto& r) { r.models[0].quality.error.mean = 0.0021; }), "carved.bunny.error_mean ");
  EXPECT_EQ(with([](auto& r) { r.models[0].quality.error.p95 = 0.0051; }), "carved.bunny.error_p95 ");
  EXPECT_EQ(with([](auto& r) { r.models[0].quality.inside_emptied = 1; }), "carved.bunny.inside_emptied ");
  EXPECT_EQ(with([](auto& r) { r.models[0].quality.touching_emptied = 5; }), "carved.bunny.touching_emptied ");
  EXPECT_EQ(with([](auto& r) { r.models[6].quality.covered_1_5 = 0.979; }), "carved_5mm.bunny.covered ");
  EXPECT_EQ(with([](auto& r) { r.models[6].quality.error.mean = 0.00131; }), "carved_5mm.bunny.error_mean ");
  EXPECT_EQ(with([](auto& r) { r.models[9].quality.inside_emptied = 6; }), "carved.plain_mug.inside_emptied ");
  EXPECT_EQ(with([](auto& r) { r.features[1].place.median = 0.0021; }), "features.bunny.place ");
  EXPECT_EQ(with([](auto& r) { r.features[3].turns[1].matches = 102; }), "features.mug.turned_20_right ");
  EXPECT_EQ(with([](auto& r) { r.features[3].turns[1].possible = 241; }), "features.mug.turned_20_found ");
  EXPECT_EQ(with([](auto& r) { r.features[3].turns.pop_back(); }), "features.mug.turned_20_right features.mug.turned_20_found ");
  EXPECT_EQ(with([](auto& r) { r.features[1].landmarks.pure = 47; }), "features.bunny.pure_landmarks ");
  EXPECT_EQ(with([](auto& r) { r.real[0].filled.covered = 0.949; }), "real.Aloe.filled_covered ");
  EXPECT_EQ(with([](auto& r) { r.real[0].filled.bad_2 = 0.141; }), "real.Aloe.filled_bad_2 ");
  EXPECT_EQ(with([](auto& r) { r.real[1].filled.covered = 0.979; }), "real.Motorcycle.filled_covered ");
  EXPECT_EQ(with([](auto& r) { r.real[1].filled.bad_2 = 0.111; }), "real.Motorcycle.filled_bad_2 ");
  EXPECT_EQ(with([](auto& r) { r.real[1].ours_where_both.bad_2 = 0.021; }), "real.Motorcycle.bad_2_beside_plain ");
  EXPECT_EQ(with([](auto& r) { r.models[1].quality.covered_1_5 = 0.94 * r.models[0].quality.covered_1_5; }), "wrong_disparities.bunny.covered ");
  EXPECT_EQ(with([](auto& r) { r.models[5].quality.error.p95 = 0.021; }), "wrong_pose.mug.error_p95 ");
  EXPECT_EQ(with([](auto& r) { r.models[7].labels.known_hidden = 11; }), "labels.bunny.hidden_by_true_depth ");
  EXPECT_EQ(with([](auto& r) { r.models[3].labels.plain_unknown = 11; }), "labels.mug.missed ");
}

TEST(Checks, TimeIsShownAndDecidesNothing) {
  BenchmarkResult r = good();
  r.stereo[0].seconds = 0.4;
  for (const Check& c : check_limits(r, {"bunny", "mug"}, true, true)) {
    EXPECT_EQ(c.judged, !c.name.ends_with(".pair"));
    if (c.name == "stereo.bunny.pair") {
      EXPECT_FALSE(c.ok);
    }
  }
}

TEST(Checks, MissingRowsAreNotOk) {
  BenchmarkResult r = good();
  r.models.pop_back();
  EXPECT_EQ(failing(r), "carved.plain_mug.inside_emptied ");
  EXPECT_TRUE(to_json(check_limits(r, {"bunny", "mug"}, false, true)).end()[-2].at("value").is_null());
  r.real.clear();
  EXPECT_NE(failing(r).find("real.Aloe.filled_covered"), std::string::npos);
}

TEST(Report, HoldsEveryRow) {
  BenchmarkResult r = good();
  r.real[0].ours = {1000, 0.8, 0.05, 0.03};
  r.real[0].plain = {1000, 0.7, 0.06, 0.04};
  const auto checks = check_limits(r, {"bunny", "mug"}, true, true);
  const auto json = to_json(r, {}, checks, nbv_benchmark::provenance("--check"));
  EXPECT_EQ(json.at("stereo").size(), 3u);
  EXPECT_EQ(json.at("carved").size(), 10u);
  EXPECT_EQ(json.at("real").at(0).at("ours").at("covered"), 0.8);
  EXPECT_EQ(json.at("checks").size(), checks.size());
  EXPECT_EQ(json.at("features").size(), 4u);
  EXPECT_EQ(json.at("features").at(1).at("turns").at(1).at("right"), 96);
  EXPECT_EQ(json.at("made").at("command"), "--check");
  EXPECT_EQ(json.at("parameters").at("seed"), 1);
  EXPECT_EQ(json.at("real").at(1).at("filled").at("covered"), 0.981);
  const std::string csv = to_csv(r);
  EXPECT_NE(csv.find("stereo,bunny,rich,,ours,valid,0.911\n"), std::string::npos);
  EXPECT_NE(csv.find("carved,bunny,rich,0.005,\"stereo, conservative\",error_m.mean,0.0012\n"), std::string::npos);
  EXPECT_NE(csv.find("real,Aloe,,,plain,bad_2,0.04\n"), std::string::npos);
  EXPECT_NE(csv.find("features,mug,rich,,orb left_alone,turned_20.matches,100\n"), std::string::npos);
  const std::string page = to_markdown(r, {}, checks, nbv_benchmark::provenance(""), "pictures/");
  EXPECT_NE(page.find("| mug | own | 10 | stereo | conservative | 96.6 / 0.0 | 1.90 / 4.90 | 4 of 10000 | 0.30 |"), std::string::npos) << page;
  EXPECT_NE(page.find("pictures/bunny_rich_5mm_stereo_error.png"), std::string::npos);
}

TEST(RealPairs, NumbersOfANumpyFile) {
  std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }";
  header.resize(70, ' ');
  const float values[] = {1.5f, std::numeric_limits<float>::infinity(), 3.25f};
  const std::string file = std::string("\x93NUMPY\x01\x00\x46\x00", 10) + header + std::string(reinterpret_cast<const char*>(values), sizeof values);
  const ImageF image = parse_npy(file, 3, 1);
  EXPECT_EQ(image.data, (std::vector<float>{1.5f, 0, 3.25f}));
  EXPECT_THROW(parse_npy(file, 1, 3), Error);
  EXPECT_THROW(parse_npy(file.substr(0, file.size() - 1), 3, 1), Error);
  EXPECT_THROW(parse_npy("", 3, 1), Error);
}

}  // namespace
}  // namespace periplus::eyes_benchmark
