#include "services/nbv_planner/evaluation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/core/error.h"
#include "common/object_model/object_model.h"
#include "services/nbv_planner/likely_surface.h"

namespace periplus::nbv {
namespace {

// 3.7 with alpha and mu such that the bounds of the interval give 1.
double interval(double v, double low, double high, int exponent) {
  const double half = std::max((high - low) / 2, 1e-3);
  return std::pow((v - (low + high) / 2) / half, exponent);
}

// exp() that stays finite far outside, so that sums and differences of penalties do.
double penalty(double exponent) { return std::exp(std::min(exponent, 40.0)); }

double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

int threshold(const Situation& s, const EvaluationSettings& settings) {
  if (settings.quantification == Quantification::voxels) return 0;
  const double face = s.rig.camera.fx * s.grid->geometry().voxel_size / settings.pair.depth_max;
  return std::max(settings.pair.more_than_pixels, static_cast<int>(settings.pixels_per_voxel_share * face * face));
}

}  // namespace

voxel::VisibilityScene Evaluator::make_visibility(const Situation& s, const voxel::OccupancyGrid& grid,
                                                  const std::vector<SurfaceVoxel>& surface) {
  std::vector<Eigen::Vector3i> watched;
  for (const auto& l : s.landmarks) {
    if (l.p_W.allFinite()) watched.push_back(s.grid->geometry().voxel_of(l.p_W));
  }
  for (const SurfaceVoxel& v : surface) watched.push_back(s.grid->geometry().voxel_of(v.p_W));
  return voxel::VisibilityScene(grid, object_model::occluders_of(s.scene), watched);
}

Evaluator::Evaluator(const Situation& situation, const EvaluationSettings& settings, const ConstraintSettings& constraints)
    : situation_(situation), settings_(settings), surface_((check(situation), settings.quality_weight > 0 && !situation.views.empty() ? known_surface(*situation.grid)
                                                                                    : std::vector<SurfaceVoxel>())),
      whole_(make_visibility(situation, *situation.grid, surface_)),
      constraints_(situation, whole_, constraints) {
  const voxel::GridGeometry& g = situation.grid->geometry();
  settings_.pair.more_than_pixels = threshold(situation, settings);
  if (settings.likely_within > 0) {
    likely_situation_ = situation;
    likely_situation_.grid = std::make_shared<voxel::OccupancyGrid>(likely_surface(*situation.grid, settings.likely_within));
    likely_ = make_visibility(situation, *likely_situation_.grid, surface_);
  }
  const std::size_t voxels = static_cast<std::size_t>(g.size.x()) * g.size.y() * g.size.z();
  if (!situation.landmarks.empty()) mark_of_voxel_.assign(voxels, -1);
  // One landmark a voxel, the largest: several features on one spot are one thing to see.
  std::vector<double> size;
  for (const auto& l : situation.landmarks) {
    if (!l.p_W.allFinite() || !l.normal_W.allFinite() || !(l.size_m > 0)) continue;
    const Eigen::Vector3i v = g.voxel_of(l.p_W);
    if (!g.contains(v) || situation.grid->state(v) == voxel::VoxelState::empty) continue;
    std::int32_t& at = mark_of_voxel_[whole_.index(v)];
    if (at < 0) {
      at = static_cast<std::int32_t>(marks_.size());
      marks_.push_back({});
      size.push_back(-1);
    }
    if (l.size_m <= size[at]) continue;
    size[at] = l.size_m;
    // pmin: the disc as the far end of the pair's range shows it face on, at most half of its voxel's face there.
    const double scale = situation.rig.camera.fx / settings.pair.depth_max;
    const double disc = std::numbers::pi / 4 * l.size_m * l.size_m, face = g.voxel_size * g.voxel_size / 2;
    marks_[at].least_pixels = std::min(disc, face) * scale * scale;
    const double norm = l.normal_W.norm();
    marks_[at].normal = norm > 0.5 ? Eigen::Vector3d(l.normal_W / norm) : Eigen::Vector3d::Zero();
  }
  if (!surface_.empty()) {
    quality_ = quality_so_far(surface_, situation, whole_, settings_.pair, settings.quality_reference);
    surface_of_voxel_.assign(voxels, -1);
    for (std::size_t i = 0; i < surface_.size(); ++i) surface_of_voxel_[surface_[i].voxel] = static_cast<std::int32_t>(i);
  }
  landmark_term_ = settings.landmarks && marks_.size() >= 2 * static_cast<std::size_t>(std::max(1, settings.least_landmarks));
}

const Evaluator::Mark* Evaluator::mark(std::uint32_t voxel) const {
  if (mark_of_voxel_.empty()) return nullptr;
  const std::int32_t at = mark_of_voxel_[voxel];
  return at < 0 ? nullptr : &marks_[at];
}

double Evaluator::landmark_facing(const Eigen::Vector3d& view, const Eigen::Vector3d& normal) const {
  // Where the normal is not known the visible surface alone decides.
  return normal.isZero() ? 1 : sigmoid(-settings_.landmark_slope * (view.dot(normal) + settings_.landmark_cosine));
}

double Evaluator::landmark_visibility(double pixels, double least_pixels, const Eigen::Vector3d& view,
                                      const Eigen::Vector3d& normal) const {
  return sigmoid(pixels - least_pixels) * landmark_facing(view, normal);
}

double Evaluator::landmark_penalty(double visible) const {
  const double lv = visible - settings_.least_landmarks;
  // The reward ends at twice the least number: hundreds of features in view would otherwise outweigh the unknown,
  // against what 3.12 is meant for.
  if (lv > 0) return -settings_.landmark_reward * std::min(lv, double(settings_.least_landmarks));
  const double pixels = double(situation_.rig.camera.width) * situation_.rig.camera.height;
  const double share = lv / std::max(1, settings_.least_landmarks);
  return 2 * pixels * share * share;
}

void Evaluator::pose_terms(const Pose& X_WC, Evaluation& e) const {
  const Eigen::Vector3d ypr = camera_yaw_pitch_roll(X_WC);
  for (const Pose& F : situation_.forbidden) {
    const Eigen::Vector3d other = camera_yaw_pitch_roll(F);
    double sum = (F.translation() - X_WC.translation()).lpNorm<1>();
    for (int i = 0; i < 3; ++i) sum += std::abs(wrap_angle(other[i] - ypr[i]));
    e.k_forbidden += std::exp(-settings_.forbidden_slope * sum);
  }
  if (situation_.X_WC_now) {
    e.k_motion = settings_.motion_per_m * (X_WC.translation() - situation_.X_WC_now->translation()).norm() +
                 settings_.motion_per_rad * angle_between(X_WC, *situation_.X_WC_now);
  }
  if (situation_.reachability) {
    e.k_reach = 1 - std::clamp(situation_.reachability->of(X_WC), 0.0, 1.0);
  }
}

Evaluation Evaluator::evaluate(const Pose& X_WC, Workspace& workspace, Detail detail) const {
  require(is_finite(X_WC), ErrorCode::not_finite, "a viewpoint must be finite");
  const robot::ViewLimits& l = situation_.limits;
  const bool every_term = detail == Detail::every_term;
  Evaluation e;
  double distance = 0;
  e.violation = constraints_.check(X_WC, &distance);
  const Eigen::Vector3d ypr = camera_yaw_pitch_roll(X_WC);
  const int p = settings_.interval_exponent;
  e.k_height = interval(X_WC.translation().z(), l.height_min, l.height_max, p);
  e.k_roll = interval(ypr.z(), -l.roll_max, l.roll_max, p);
  e.k_pitch = interval(ypr.y(), l.pitch_min, l.pitch_max, p);
  e.k_yaw = std::pow(yaw_share(l, ypr.x()), p);
  if (std::isfinite(distance)) {
    e.k_distance = penalty(settings_.distance_slope * (l.distance_min - distance));
    e.k_far = penalty(settings_.distance_slope * (distance - l.distance_max));
  }
  pose_terms(X_WC, e);
  const Eigen::Vector3d view = X_WC.linear().col(2);
  if (every_term) {
    for (const Mark& m : marks_) e.sum_ln += landmark_facing(view, m.normal);
  }
  const bool ruled_out = e.violation == Violation::head || e.violation == Violation::body ||
                         e.violation == Violation::room || e.violation == Violation::forbidden;
  if (ruled_out && !every_term) {
    if (landmark_term_) e.k_landmarks = landmark_penalty(0);
    return e;
  }
  voxel::VisibilityWorkspace& w = workspace.visibility;
  e.gain = visibility().evaluate_pair(X_WC, situation_.rig, settings_.pair, w);
  e.value = value_of(w.both, e.gain);
  if (!surface_.empty()) {
    e.quality = better_looks(X_WC, w);
    e.value += settings_.quality_weight * e.quality;
  }
  if (every_term && likely_) e.gain = whole_.evaluate_pair(X_WC, situation_.rig, settings_.pair, w);
  if (landmark_term_ || every_term) {
    for (const voxel::VoxelPixels& v : w.left.watched) {
      const Mark* m = mark(v.voxel);
      if (m == nullptr) continue;
      e.visible_landmarks += landmark_visibility(v.pixels, m->least_pixels, view, m->normal);
      if (every_term) e.sum_ls += sigmoid(v.pixels - m->least_pixels);
    }
  }
  if (landmark_term_) e.k_landmarks = landmark_penalty(e.visible_landmarks);
  return e;
}

double Evaluator::better_looks(const Pose& X_WC, voxel::VisibilityWorkspace& w) const {
  double sum = 0;
  for_each_watched(w, situation_.rig, settings_.pair.more_than_pixels, [&](std::uint32_t voxel) {
    const std::int32_t i = surface_of_voxel_[voxel];
    if (i < 0) return;
    const SurfaceVoxel& s = surface_[static_cast<std::size_t>(i)];
    sum += std::max(0.0, look_quality(s, X_WC, situation_.rig.baseline, settings_.quality_reference) - double(quality_[static_cast<std::size_t>(i)]));
  });
  return sum;
}

double Evaluator::value_of(const voxel::VoxelList& both, const voxel::PairGain& gain) const {
  const bool pixels = settings_.quantification == Quantification::pixels;
  if (!weighted()) return pixels ? static_cast<double>(gain.pixels) : gain.voxels;
  const auto threshold = static_cast<std::uint32_t>(settings_.pair.more_than_pixels);
  double value = 0;
  for (const voxel::VoxelPixels& v : both) {
    if (pixels) value += double(weight(v.voxel)) * v.pixels;
    else if (v.pixels > threshold) value += weight(v.voxel);
  }
  return value;
}

Evaluator::Lambdas Evaluator::lambdas(double greatest) const {
  const EvaluationSettings& s = settings_;
  Lambdas l;
  l.motion = s.lambda_motion * greatest;
  l.reach = s.lambda_reach * greatest;
  l.interval = l.distance = l.forbidden = greatest;
  switch (s.lambda_rule) {
    case LambdaRule::capped:
      l.distance = s.lambda_distance;
      l.landmarks = s.lambda_landmarks;
      l.forbidden = std::min(s.lambda_forbidden, greatest);
      break;
    case LambdaRule::scaled: l.landmarks = greatest / std::max(landmark_penalty(0), 1.0); break;
    case LambdaRule::fixed:
      if (s.lambda_interval > 0) l.interval = s.lambda_interval;
      l.distance = s.lambda_distance;
      l.landmarks = s.lambda_landmarks;
      l.forbidden = s.lambda_forbidden;
      break;
  }
  return l;
}

double Evaluator::score(const Evaluation& e, double greatest) const {
  const Lambdas l = lambdas(greatest);
  double f = l.interval * (e.k_height + e.k_roll + e.k_pitch + e.k_yaw) + l.distance * (e.k_distance + e.k_far) +
             l.landmarks * e.k_landmarks + l.forbidden * e.k_forbidden + l.motion * e.k_motion + l.reach * e.k_reach - e.value;
  // What has no smooth term of its own costs as much as the best value.
  if (e.violation != Violation::none) f += greatest;
  return f;
}

std::vector<std::pair<std::string, double>> Evaluator::terms(const Evaluation& e, double greatest) const {
  const Lambdas l = lambdas(greatest);
  return {{"f_e", score(e, greatest)},
          {"value", e.value},
          {"N_u", e.gain.voxels},
          {"quality", e.quality},
          {"pixels", static_cast<double>(e.gain.pixels)},
          {"K_height", e.k_height},
          {"K_roll", e.k_roll},
          {"K_pitch", e.k_pitch},
          {"K_yaw", e.k_yaw},
          {"K_distance", e.k_distance},
          {"K_far", e.k_far},
          {"K_landmarks", e.k_landmarks},
          {"K_forbidden", e.k_forbidden},
          {"K_motion", e.k_motion},
          {"K_reach", e.k_reach},
          {"visible_landmarks", e.visible_landmarks},
          {"sum_ls", e.sum_ls},
          {"sum_ln", e.sum_ln},
          {"lambda_interval", l.interval},
          {"lambda_distance", l.distance},
          {"lambda_landmarks", l.landmarks},
          {"lambda_forbidden", l.forbidden},
          {"lambda_motion", l.motion},
          {"lambda_reach", l.reach}};
}

}  // namespace periplus::nbv
