#include "integration-tests/eyes_benchmark/benchmark.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <memory>
#include <optional>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/object_model/object_model.h"
#include "common/object_model/surface.h"
#include "integration-tests/eyes_benchmark/pictures.h"
#include "integration-tests/eyes_benchmark/plain_matcher.h"
#include "integration-tests/eyes_benchmark/real_pairs.h"
#include "services/vision_server/disparity_filter.h"
#include "services/vision_server/features.h"
#include "services/vision_server/match_range.h"

namespace periplus::eyes_benchmark {
namespace {

constexpr double kVoxel = 0.01, kFineVoxel = 0.005;  // [m]
constexpr object_model::CarvingMode kProbabilistic = object_model::CarvingMode::probabilistic;
constexpr int kNormalStep = 4;                       // [px]
constexpr double kWidestRange = 1e4;                 // [px]
constexpr double kDepthShown[2] = {0.85, 1.6}, kErrorShown = 0.01;  // [m]

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double processor() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double median(std::vector<double> values) { return spread(std::move(values)).median; }

std::string file_of(const std::string& object) { return object == "bunny" || object == "mug" ? object + ".obj" : object + ".off"; }

// What one look gave: the product's perception, and what its matcher found on the way.
struct Seen {
  std::optional<object_model::Perception> perception;   // nothing: refused
  vision::DisparityPair disparity;
  vision::DisparityRange range;
};

class Benchmark {
 public:
  Benchmark(const BenchmarkOptions& o, const std::function<void(const std::string&)>& say) : o_(o), say_(say) {}

  BenchmarkResult run() {
    const double begin = now();
    set_threads(o_.threads);
    for (const std::string& name : o_.objects) run_object(name);
    if (o_.real) run_real();
    result_.seconds = now() - begin;
    return std::move(result_);
  }

 private:
  void run_object(const std::string& name) {
    const Stage stage = make_stage(name, file_of(name), o_.longest_side);
    say_(name + ": visible surface");
    visible_ = visible_surface(stage, o_.surface_samples, o_.sensor.seed);
    run_paint(stage, Paint::rich);
    if (o_.features) run_features(stage);
    if (name == "bunny") {
      run_paint(stage, Paint::weak);
      run_paint(stage, Paint::none);
    }
    if (name == "mug") run_paint(stage, Paint::own);
  }

  void run_paint(const Stage& stage, Paint paint) {
    say_(stage.object + ", texture " + to_string(paint));
    const std::vector<Shot> shots = take_pictures(stage, file_of(stage.object), o_.longest_side, paint, o_.sensor, six_views(stage));
    std::vector<Seen> seen;
    result_.stereo.push_back(look(stage, paint, shots, seen));
    const std::vector<object_model::Perception> stereo = given(seen);
    carve(stage, paint, kVoxel, kStereo, stereo, shots);
    if (paint != Paint::rich) return;
    carve(stage, paint, kVoxel, kTrueDepth, true_perceptions(shots), shots);
    const std::vector<object_model::Perception> spoilt = wrong_disparities(stage, seen), astray = wrong_pose(stereo);
    carve(stage, paint, kVoxel, kWrongDisparities, spoilt, shots);
    carve(stage, paint, kVoxel, kWrongPose, astray, shots);
    carve(stage, paint, kVoxel, kStereo, stereo, shots, kProbabilistic);
    carve(stage, paint, kVoxel, kWrongDisparities, spoilt, shots, kProbabilistic);
    carve(stage, paint, kVoxel, kWrongPose, astray, shots, kProbabilistic);
    if (stage.object != "bunny") return;
    carve(stage, paint, kFineVoxel, kStereo, stereo, shots);
    carve(stage, paint, kFineVoxel, kTrueDepth, true_perceptions(shots), shots);
  }

  StereoRow look(const Stage& stage, Paint paint, const std::vector<Shot>& shots, std::vector<Seen>& seen) {
    StereoRow row;
    row.object = stage.object;
    row.paint = to_string(paint);
    StereoTally ours, plain, filled;
    NormalErrors normals;
    std::vector<double> seconds, processor_seconds, plain_seconds;
    std::map<std::string, std::vector<double>> steps;
    std::vector<std::string> order;
    row.textured = row.shown_valid = 1;
    const StereoRig rig = robot_eyes();
    const voxel::GridGeometry grid = voxel::GridGeometry::from_box(stage.box.X_WB, stage.box.size, kVoxel);
    const int side = 2 * static_cast<int>(std::lround((rig.camera.fx * kVoxel / kDistance - 1) / 2)) + 1;
    for (std::size_t i = 0; i < shots.size(); ++i) {
      const Shot& shot = shots[i];
      const vision::DepthRange depths = vision::depth_range(rig, shot.pair.X_WC, stage.box, &stage.scene, o_.perceive.least_depth_m, o_.perceive.default_far_m);
      Seen s;
      s.range = vision::disparity_range(rig, depths);
      s.disparity = vision::match(shot.pair.left_grey, shot.pair.right_grey, s.range, o_.perceive.match);
      ImageF by_plain;
      for (int r = 0; r < o_.repeats; ++r) {
        double begin = now();
        by_plain = plain_match(shot.pair.left_grey, shot.pair.right_grey, s.range);
        plain_seconds.push_back(now() - begin);
        vision::PerceiveReport report;
        const double processor_begin = processor();
        begin = now();
        try {
          s.perception = vision::perceive(shot.pair, stage.box, {&stage.scene, stage.solids.get()}, o_.perceive, now, report);
        } catch (const Error& e) {
          if (e.code() != ErrorCode::vision_no_depth) throw;
          continue;
        }
        row.textured = std::min(row.textured, report.textured_share);
        row.shown_valid = std::min(row.shown_valid, s.perception->silhouette_valid_share);
        seconds.push_back(now() - begin);
        processor_seconds.push_back(processor() - processor_begin);
        for (const auto& [step, time] : report.seconds) {
          if (!steps.contains(step)) order.push_back(step);
          steps[step].push_back(time);
        }
      }
      plain.add(by_plain, {}, {}, shot.left.depth, shot.left.object, rig);
      if (s.perception) {
        s.perception->view_id = "view-" + std::to_string(i);
        const object_model::DepthMap& map = s.perception->depth.front();
        const bool closes_gaps = s.perception->silhouette_valid_share >= o_.carving.cautious_share;
        const ImageF carved = least_within(object_model::pixel_limits(map, grid, o_.carving, closes_gaps, nullptr).limit, side);
        ours.add(s.disparity.left, map.depth, carved, shot.left.depth, shot.left.object, rig);
        filled.add(s.perception->disparity, {}, {}, shot.left.depth, shot.left.object, rig);
        add_normal_errors(map.depth, shot.left.object, rig.camera, map.X_WC, stage.mesh_W, *stage.tree, kNormalStep, normals);
      } else {
        ++row.refused;
        ours.add(s.disparity.left, {}, {}, shot.left.depth, shot.left.object, rig);
      }
      if (i == 0) {
        ImageF depth = s.disparity.left;
        for (float& d : depth.data) d = d > 0 ? static_cast<float>(rig.depth(d)) : 0;
        draw(row.object + "_" + row.paint, depth, shot.left);
      }
      seen.push_back(std::move(s));
    }
    row.ours = ours.quality();
    row.plain = plain.quality();
    row.filled = filled.quality();
    row.normals_share = normals.tried == 0 ? 0 : static_cast<double>(normals.angles.size()) / static_cast<double>(normals.tried);
    row.normals = spread(std::move(normals.angles));
    row.seconds = median(std::move(seconds));
    row.processor_seconds = median(std::move(processor_seconds));
    row.plain_seconds = median(std::move(plain_seconds));
    for (const std::string& step : order) row.steps.emplace_back(step, median(steps[step]));
    return row;
  }

  static std::vector<object_model::Perception> given(const std::vector<Seen>& seen) {
    std::vector<object_model::Perception> out;
    for (const Seen& s : seen)
      if (s.perception) out.push_back(*s.perception);
    return out;
  }

  static std::vector<object_model::Perception> true_perceptions(const std::vector<Shot>& shots) {
    std::vector<object_model::Perception> out;
    for (const Shot& shot : shots) {
      object_model::Perception p;
      p.view_id = "view-" + std::to_string(out.size());
      p.rig = shot.pair.rig;
      p.X_WC = shot.pair.X_WC;
      p.silhouette_valid_share = 1;
      for (const EyeTruth* eye : {&shot.left, &shot.right})
        p.depth.push_back({p.rig.camera, eye->X_WC, eye->depth, eye->depth, ImageF(p.rig.camera.width, p.rig.camera.height)});
      out.push_back(std::move(p));
    }
    return out;
  }

  std::vector<object_model::Perception> wrong_disparities(const Stage& stage, const std::vector<Seen>& seen) const {
    std::vector<object_model::Perception> out;
    Random random(o_.sensor.seed);
    vision::DepthSettings unfiltered = o_.perceive.depth;
    unfiltered.flying_range_px = kWidestRange;  // every wrong depth reaches the model
    const auto spoilt = [&](ImageF disparity, const vision::DisparityRange& range) {
      for (float& d : disparity.data)
        if (d > 0 && random.uniform() < o_.wrong_share) d = static_cast<float>(random.uniform(std::max(1, range.least), range.least + range.count));
      return disparity;
    };
    for (const Seen& s : seen) {
      if (!s.perception) continue;
      object_model::Perception p = *s.perception;
      const double distance = (p.X_WC.inverse() * stage.box.X_WB.translation()).z();
      const Pose X_WR = p.depth[1].X_WC;
      p.depth = {vision::make_depth(spoilt(s.disparity.left, s.range), p.rig, p.X_WC, unfiltered, distance),
                 vision::make_depth(spoilt(s.disparity.right, s.range), p.rig, X_WR, unfiltered, distance)};
      out.push_back(std::move(p));
    }
    return out;
  }

  std::vector<object_model::Perception> wrong_pose(std::vector<object_model::Perception> perceptions) const {
    if (perceptions.size() < 3) return perceptions;
    object_model::Perception& p = perceptions[2];
    const Eigen::Translation3d wrong(Eigen::Vector3d::Constant(o_.wrong_pose_m / std::sqrt(3)));
    p.X_WC = p.X_WC * wrong;
    for (object_model::DepthMap& map : p.depth) map.X_WC = map.X_WC * wrong;
    return perceptions;
  }

  void carve(const Stage& stage, Paint paint, double voxel_m, const char* source, const std::vector<object_model::Perception>& perceptions,
             const std::vector<Shot>& shots, object_model::CarvingMode mode = object_model::CarvingMode::conservative) {
    object_model::CarvingSettings settings = o_.carving;
    settings.mode = mode;
    ModelRow row;
    row.mode = mode;
    row.object = stage.object;
    row.paint = to_string(paint);
    row.source = source;
    row.voxel_m = voxel_m;
    object_model::ObjectModel model(stage.object, stage.box, voxel_m, stage.surroundings);
    const double begin = now();
    for (const object_model::Perception& p : perceptions) model.integrate(p, stage.surroundings, settings);
    row.seconds = now() - begin;
    const voxel::GridGeometry& g = model.grid().geometry();
    const auto [it, fresh] = voxels_.try_emplace({stage.object, voxel_m});
    if (fresh) it->second = {voxel_truth(stage.mesh_W, g, o_.touching_samples, o_.sensor.seed), reached_voxels(shots, g)};
    row.quality.covered_1_5 = covered_share(model.grid(), visible_, 1.5 * voxel_m);
    row.quality.covered_1 = covered_share(model.grid(), visible_, voxel_m);
    const object_model::SurfaceMesh surface = object_model::extract_surface(model.grid(), model.state().tsdf, o_.carving.truncation_voxels * voxel_m);
    row.quality.error = surface_error(surface, *stage.tree, kTable + kTableSkin);
    count_voxels(model.grid(), it->second.truth, row.quality);
    row.labels = label_quality(model.grid(), it->second.reached, *stage.tree, shots, perceptions);
    draw_surface(row, surface, shots.front().left);
    result_.models.push_back(std::move(row));
  }

  void run_features(const Stage& stage) {
    say_(stage.object + ", features");
    std::vector<double> degrees{0};
    degrees.insert(degrees.end(), o_.turns.begin(), o_.turns.end());
    const std::vector<Shot> shots = take_pictures(stage, file_of(stage.object), o_.longest_side, Paint::rich, o_.sensor, turned_views(stage, degrees));
    std::vector<object_model::Perception> seen;
    for (const Shot& shot : shots) {
      vision::PerceiveReport report;
      seen.push_back(vision::perceive(shot.pair, stage.box, {&stage.scene, stage.solids.get()}, o_.perceive, now, report));
    }
    for (const auto& [detector, kind] : {std::pair{"sift", vision::DescriptorKind::root_sift}, std::pair{"akaze", vision::DescriptorKind::akaze}, std::pair{"orb", vision::DescriptorKind::orb}})
      for (const auto& [selection, method] : {std::pair{"descriptor_first", vision::FeatureSelection::descriptor_first},
                                              std::pair{"geometry_first", vision::FeatureSelection::geometry_first},
                                              std::pair{"left_alone", vision::FeatureSelection::left_alone}}) {
        vision::FeatureSettings settings = o_.perceive.features;
        settings.detector.kind = kind;
        settings.selection.method = method;
        FeatureRow row;
        row.object = stage.object;
        row.detector = detector;
        row.selection = selection;
        row.chosen = kind == o_.perceive.features.detector.kind && method == o_.perceive.features.selection.method;
        measure_features(stage, shots, degrees, seen, settings, row);
        result_.features.push_back(std::move(row));
      }
  }

  void measure_features(const Stage& stage, const std::vector<Shot>& shots, const std::vector<double>& degrees, const std::vector<object_model::Perception>& seen,
                        const vision::FeatureSettings& settings, FeatureRow& row) const {
    std::vector<std::shared_ptr<const object_model::View>> views;
    std::vector<std::vector<Eigen::Vector3d>> truth;
    std::vector<double> seconds, errors;
    for (std::size_t i = 0; i < shots.size(); ++i) {
      const vision::RectifiedPair& pair = shots[i].pair;
      object_model::View view;
      view.view_id = "turned-" + std::to_string(i);
      view.rig = pair.rig;
      view.X_WC = pair.X_WC;
      const double begin = now();
      view.features = vision::find_features(pair.left_grey, pair.right_grey, pair.rig, seen[i].depth, {seen[i].disparity, seen[i].disparity_filled}, stage.box,
                                            stage.solids.get(), settings);
      seconds.push_back(now() - begin);
      truth.push_back(true_places(view.features, pair.rig.camera, pair.X_WC, *stage.tree));
      for (std::size_t f = 0; f < view.features.size(); ++f)
        if (truth.back()[f].allFinite()) errors.push_back((view.features[f].p_W - truth.back()[f]).norm());
      row.features += static_cast<double>(view.features.size()) / static_cast<double>(shots.size());
      views.push_back(std::make_shared<object_model::View>(std::move(view)));
    }
    for (std::size_t i = 1; i < views.size(); ++i) {
      const auto &a = views[0]->features, &b = views[i]->features;
      row.turns.push_back(match_quality(a, truth[0], b, truth[i], object_model::match_views(a, b)));
      row.turns.back().degrees = degrees[i];
    }
    row.landmarks = landmark_quality(object_model::merge_landmarks(views), truth);
    row.place = spread(std::move(errors));
    row.seconds = median(std::move(seconds));
  }

  void run_real() {
    say_("real pairs");
    for (const RealPair& pair : load_real_pairs()) {
      RealRow row;
      row.name = pair.name;
      row.source = pair.source;
      row.first_column = pair.range.count;
      std::vector<double> seconds, filling_seconds, plain_seconds;
      vision::DisparityPair ours;
      vision::FilledDisparity filled;
      ImageF plain;
      for (int r = 0; r < o_.repeats; ++r) {
        double begin = now();
        ours = vision::match(pair.left, pair.right, pair.range, o_.perceive.match);
        seconds.push_back(now() - begin);
        begin = now();
        filled = vision::fill_disparity(ours.left, pair.left);
        filling_seconds.push_back(now() - begin);
        begin = now();
        plain = plain_match(pair.left, pair.right, pair.range);
        plain_seconds.push_back(now() - begin);
      }
      row.ours = disparity_quality(ours.left, pair.truth, row.first_column);
      row.plain = disparity_quality(plain, pair.truth, row.first_column);
      row.filled = disparity_quality(filled.disparity, pair.truth, row.first_column);
      row.ours_where_both = quality_where_both(ours.left, plain, pair.truth, row.first_column);
      row.plain_where_both = quality_where_both(plain, ours.left, pair.truth, row.first_column);
      row.seconds = median(std::move(seconds));
      row.filling_seconds = median(std::move(filling_seconds));
      row.plain_seconds = median(std::move(plain_seconds));
      if (!o_.pictures.empty()) {
        // Disparities as they are: drawn like depths, but near is what is large.
        const float most = static_cast<float>(pair.range.count);
        const ImageU8 all(pair.truth.width, pair.truth.height, 1, 255);
        write_depth(o_.pictures + "/" + pair.name + "_disparity.png", ours.left, most, 0);
        write_depth(o_.pictures + "/" + pair.name + "_filled.png", filled.disparity, most, 0);
        ImageU8 known = all;
        for (std::size_t i = 0; i < known.data.size(); ++i) known.data[i] = pair.truth.data[i] > 0 ? 255 : 0;
        write_error(o_.pictures + "/" + pair.name + "_error.png", ours.left, pair.truth, known, 4);
      }
      result_.real.push_back(std::move(row));
    }
  }

  void draw(const std::string& name, const ImageF& depth, const EyeTruth& truth) const {
    if (o_.pictures.empty()) return;
    write_depth(o_.pictures + "/" + name + "_depth.png", depth, kDepthShown[0], kDepthShown[1]);
    write_error(o_.pictures + "/" + name + "_error.png", depth, truth.depth, truth.object, kErrorShown);
  }

  void draw_surface(const ModelRow& row, const object_model::SurfaceMesh& surface, const EyeTruth& truth) const {
    if (o_.pictures.empty() || surface.triangles.empty()) return;
    mesh::TriangleMesh mesh;
    for (const Eigen::Vector3f& p : surface.vertices) mesh.vertices.push_back(p.cast<double>());
    for (const auto& t : surface.triangles) mesh.triangles.emplace_back(static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2]));
    nbv_benchmark::DepthScene scene;
    scene.add(mesh, Pose::Identity());
    draw(model_picture(row), scene.render(truth.X_WC, robot_eyes().camera, 0), truth);
  }

  const BenchmarkOptions& o_;
  const std::function<void(const std::string&)>& say_;
  BenchmarkResult result_;
  std::vector<Eigen::Vector3d> visible_;
  // Of an object and a size of voxels; the eyes stand where they do whatever the texture.
  struct GridTruth {
    VoxelTruth truth;
    std::vector<std::uint8_t> reached;
  };
  std::map<std::pair<std::string, double>, GridTruth> voxels_;
};

}  // namespace

std::string model_picture(const ModelRow& row) {
  std::string source = row.source;
  std::erase(source, ',');
  std::replace(source.begin(), source.end(), ' ', '_');
  return row.object + "_" + row.paint + "_" + std::to_string(std::lround(1000 * row.voxel_m)) + "mm_" + source + (row.mode == kProbabilistic ? "_probabilistic" : "");
}

const char* to_string(object_model::CarvingMode mode) { return mode == kProbabilistic ? "probabilistic" : "conservative"; }

BenchmarkResult run_benchmark(const BenchmarkOptions& options, const std::function<void(const std::string&)>& say) { return Benchmark(options, say).run(); }

}  // namespace periplus::eyes_benchmark
