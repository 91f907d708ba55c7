#include "integration-tests/eyes_benchmark/checks.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

namespace periplus::eyes_benchmark {
namespace {

constexpr double kPercent = 100, kMillimetres = 1000;

class Limits {
 public:
  explicit Limits(std::vector<Check>& checks) : checks_(checks) {}

  // `row` null: missing.
  template <class Row, class Value>
  void at_least(const Row* row, const std::string& name, const char* unit, Value value, double limit) {
    add(row != nullptr, name, unit, row ? value(*row) : 0, ">=", limit);
  }
  template <class Row, class Value>
  void at_most(const Row* row, const std::string& name, const char* unit, Value value, double limit, bool judged = true) {
    add(row != nullptr, name, unit, row ? value(*row) : 0, "<=", limit);
    checks_.back().judged = judged;
  }

 private:
  void add(bool known, const std::string& name, const char* unit, double value, const char* comparison, double limit) {
    const bool holds = comparison[0] == '>' ? value >= limit : value <= limit;
    checks_.push_back({name, unit, value, comparison, limit, known && holds, known, true});
  }

  std::vector<Check>& checks_;
};

void stereo(const StereoRow* row, const std::string& prefix, Limits& limits) {
  limits.at_least(row, prefix + "valid", "%", [](const StereoRow& r) { return kPercent * r.ours.valid; }, 91);
  limits.at_most(row, prefix + "bad_1", "%", [](const StereoRow& r) { return kPercent * r.ours.bad_1; }, 3);
  limits.at_most(row, prefix + "bad_2", "%", [](const StereoRow& r) { return kPercent * r.ours.bad_2; }, 1.3);
  limits.at_most(row, prefix + "median", "mm", [](const StereoRow& r) { return kMillimetres * r.ours.error.median; }, 1.7);
  limits.at_most(row, prefix + "p95", "mm", [](const StereoRow& r) { return kMillimetres * r.ours.error.p95; }, 7);
  limits.at_most(row, prefix + "behind", "%", [](const StereoRow& r) { return kPercent * r.ours.behind; }, 0.01);
  limits.at_most(row, prefix + "normals", "deg", [](const StereoRow& r) { return kDegrees * r.normals.median; }, 10);
  limits.at_least(row, prefix + "textured", "%", [](const StereoRow& r) { return kPercent * r.textured; }, 50);
  limits.at_most(row, prefix + "pair", "ms", [](const StereoRow& r) { return 1000 * r.seconds; }, 350, false);
}

void carved(const ModelRow* row, const std::string& prefix, double coverage, Limits& limits) {
  limits.at_least(row, prefix + "covered", "%", [](const ModelRow& r) { return kPercent * r.quality.covered_1_5; }, coverage);
  limits.at_most(row, prefix + "error_mean", "mm", [](const ModelRow& r) { return kMillimetres * r.quality.error.mean; }, 2);
  limits.at_most(row, prefix + "error_p95", "mm", [](const ModelRow& r) { return kMillimetres * r.quality.error.p95; }, 5);
  limits.at_most(row, prefix + "inside_emptied", "voxels", [](const ModelRow& r) { return static_cast<double>(r.quality.inside_emptied); }, 0);
  limits.at_most(row, prefix + "touching_emptied", "%", [](const ModelRow& r) { return kPercent * r.quality.touching_emptied_share(); }, 0.4);
}

void real_pair(const RealRow* row, const std::string& prefix, double coverage, double bad, Limits& limits) {
  limits.at_least(row, prefix + "filled_covered", "%", [](const RealRow& r) { return kPercent * r.filled.covered; }, coverage);
  limits.at_most(row, prefix + "filled_bad_2", "%", [](const RealRow& r) { return kPercent * r.filled.bad_2; }, bad);
  limits.at_most(row, prefix + "bad_2_beside_plain", "%", [](const RealRow& r) { return kPercent * r.ours_where_both.bad_2; },
                 row ? kPercent * row->plain_where_both.bad_2 : 0);
}

void features_of(const FeatureRow* row, const std::string& prefix, Limits& limits) {
  constexpr double kTurn = 20;
  const MatchQuality* turned = nullptr;
  if (row)
    for (const MatchQuality& q : row->turns)
      if (q.degrees == kTurn) turned = &q;
  limits.at_most(row, prefix + "place", "mm", [](const FeatureRow& r) { return kMillimetres * r.place.median; }, 2);
  limits.at_least(turned, prefix + "turned_20_right", "%", [](const MatchQuality& q) { return kPercent * q.precision(); }, 95);
  limits.at_least(turned, prefix + "turned_20_found", "%", [](const MatchQuality& q) { return kPercent * q.recall(); }, 40);
  limits.at_least(row, prefix + "pure_landmarks", "%", [](const FeatureRow& r) { return kPercent * r.landmarks.purity(); }, 95);
}

}  // namespace

std::vector<Check> check_limits(const BenchmarkResult& result, const std::vector<std::string>& objects, bool real, bool features) {
  const auto seen = [&](const std::string& object, const char* paint) -> const StereoRow* {
    const auto it = std::find_if(result.stereo.begin(), result.stereo.end(), [&](const StereoRow& r) { return r.object == object && r.paint == paint; });
    return it == result.stereo.end() ? nullptr : &*it;
  };
  const auto model = [&](const std::string& object, const char* paint, double voxel_m, const char* source = kStereo,
                         object_model::CarvingMode mode = object_model::CarvingMode::conservative) -> const ModelRow* {
    const auto it = std::find_if(result.models.begin(), result.models.end(), [&](const ModelRow& r) {
      return r.object == object && r.paint == paint && r.source == source && r.voxel_m == voxel_m && r.mode == mode;
    });
    return it == result.models.end() ? nullptr : &*it;
  };
  std::vector<Check> checks;
  Limits limits(checks);
  for (const std::string& object : objects) {
    stereo(seen(object, "rich"), "stereo." + object + ".", limits);
    carved(model(object, "rich", 0.01), "carved." + object + ".", object == "mug" ? 96.5 : 98.5, limits);
    if (features) {
      const auto it = std::find_if(result.features.begin(), result.features.end(), [&](const FeatureRow& r) { return r.object == object && r.chosen; });
      features_of(it == result.features.end() ? nullptr : &*it, "features." + object + ".", limits);
    }
    const ModelRow* clean = model(object, "rich", 0.01);
    for (const auto& [source, name] : {std::pair{kWrongDisparities, "wrong_disparities."}, std::pair{kWrongPose, "wrong_pose."}}) {
      const ModelRow* spoilt = clean ? model(object, "rich", 0.01, source, object_model::CarvingMode::probabilistic) : nullptr;
      limits.at_least(spoilt, name + object + ".covered", "% of the clean run's", [&](const ModelRow& r) { return kPercent * r.quality.covered_1_5 / clean->quality.covered_1_5; }, 95);
      limits.at_most(spoilt, name + object + ".error_p95", "voxels", [](const ModelRow& r) { return r.quality.error.p95 / r.voxel_m; }, 2);
    }
    if (object == "bunny") {
      const ModelRow* fine = model(object, "rich", 0.005);
      limits.at_least(fine, "carved_5mm.bunny.covered", "%", [](const ModelRow& r) { return kPercent * r.quality.covered_1_5; }, 98);
      limits.at_most(fine, "carved_5mm.bunny.error_mean", "mm", [](const ModelRow& r) { return kMillimetres * r.quality.error.mean; }, 1.3);
    }
    // Labels: exact where depth is; stereo's noise may miss a few voxels.
    limits.at_most(model(object, "rich", 0.01, kTrueDepth), "labels." + object + ".hidden_by_true_depth", "%", [](const ModelRow& r) { return kPercent * r.labels.hidden_share(); }, 0.1);
    limits.at_most(clean, "labels." + object + ".missed", "%", [](const ModelRow& r) { return kPercent * r.labels.plain_unknown_share(); }, 1);
    if (object == "mug") {
      limits.at_most(model(object, "own", 0.01), "carved.plain_mug.inside_emptied", "%", [](const ModelRow& r) { return kPercent * r.quality.inside_emptied_share(); }, 0.05);
      limits.at_most(seen(object, "own"), "stereo.plain_mug.textured", "%", [](const StereoRow& r) { return kPercent * r.textured; }, 50);
    }
  }
  if (!real) return checks;
  for (const auto& [name, coverage, bad] : {std::tuple{"Aloe", 95, 14}, std::tuple{"Motorcycle", 98, 11}}) {
    const auto it = std::find_if(result.real.begin(), result.real.end(), [name = name](const RealRow& r) { return r.name == name; });
    real_pair(it == result.real.end() ? nullptr : &*it, std::string("real.") + name + ".", coverage, bad, limits);
  }
  return checks;
}

nlohmann::json to_json(const std::vector<Check>& checks) {
  nlohmann::json out = nlohmann::json::array();
  for (const Check& c : checks) {
    out.push_back({{"name", c.name}, {"unit", c.unit}, {"comparison", c.comparison}, {"limit", c.limit}, {"ok", c.ok}, {"judged", c.judged}});
    if (c.known)
      out.back()["value"] = c.value;
    else
      out.back()["value"] = nullptr;
  }
  return out;
}

}  // namespace periplus::eyes_benchmark
