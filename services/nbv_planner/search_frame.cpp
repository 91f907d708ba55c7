#include "services/nbv_planner/search_frame.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/core/error.h"
#include "services/nbv_planner/line_of_sight.h"

namespace periplus::nbv {
namespace {

constexpr int kDrawsPerPlace = 200;
constexpr double kFarthestPlace = 2.4;  // from the face or the box [m]
constexpr double kLeastSlant = 0.1;     // cosine of the greatest angle from a face's normal to the place
constexpr int kDrawsPerFace = 25;       // places that see a face in a corner are rare: none is given up too early
constexpr std::size_t kFacesKept = 4096;

}  // namespace

double bounded_score(const Evaluator& evaluator, const Evaluation& evaluation, double greatest, Bounds bounds) {
  Evaluation e = evaluation;
  if (bounds != Bounds::none) e.k_height = e.k_roll = e.k_pitch = e.k_yaw = 0;
  if (bounds == Bounds::all) e.k_distance = e.k_far = 0;
  return evaluator.score(e, greatest);
}

double position_distance(const Pose& a, const Pose& b) { return (a.translation() - b.translation()).norm(); }

SearchFrame::SearchFrame(const Evaluator& e, std::uint64_t seed, const SearchSettings& s, TaskRunner& r, Bounds b,
                         const std::function<void(double)>& poll)
    : evaluator(e), situation(e.situation()), settings(s), runner(r), bounds(b), workspaces(r.workers()), seed_(seed), poll_(poll) {
  for (Evaluator::Workspace& w : workspaces) w.visibility.simd = s.simd;
  faces = e.visibility().unknown_faces(std::max<std::size_t>(1, e.visibility().unknown_face_count() / kFacesKept));
}

Random SearchFrame::random(int stage, int i) const {
  return Random(seed_ + 0x632be59bd9b4e019ULL * static_cast<std::uint64_t>(i + 1) + 0xd1b54a32d192ed03ULL * static_cast<std::uint64_t>(stage));
}

double SearchFrame::score(const Evaluation& e) const {
  return bounded_score(evaluator, e, greatest, bounds);
}

bool SearchFrame::better(const Candidate& a, const Candidate& b) const {
  const bool gain_a = a.evaluation.value > 0, gain_b = b.evaluation.value > 0;
  if (gain_a != gain_b) return gain_a;
  return score(a.evaluation) < score(b.evaluation);
}

void SearchFrame::offer(const Candidate& c, std::optional<Candidate>& to) const {
  if (c.evaluation.violation != Violation::none) return;
  if (!to || better(c, *to)) to = c;
}

std::vector<Candidate> SearchFrame::evaluate(const std::vector<Pose>& poses, int at_least) {
  const int count = std::clamp(left(), at_least, std::max(at_least, static_cast<int>(poses.size())));
  const auto results = runner.map<Candidate>(
      std::min(count, static_cast<int>(poses.size())),
      [&](int i, int worker) { return Candidate{poses[i], evaluator.evaluate(poses[i], workspaces[worker])}; }, at_least);
  std::vector<Candidate> candidates;
  for (const auto& c : results) {
    if (c) candidates.push_back(*c);
  }
  evaluations += static_cast<int>(candidates.size());
  return candidates;
}

void SearchFrame::note(const Pose& X_WC, double f_e, const char* stage) {
  if (settings.keep_candidates) result_.candidates.push_back({X_WC, f_e, stage});
}

void SearchFrame::end_stage(const char* name, double share_done) {
  const auto now = std::chrono::steady_clock::now();
  result_.seconds.emplace_back(name, std::chrono::duration<double>(now - stage_start_).count());
  stage_start_ = now;
  if (poll_) poll_(share_done);
}

PlannedView SearchFrame::finish() {
  // Every candidate was checked when it was evaluated; this is the last word before the robot goes there.
  PERIPLUS_ASSERT(best.has_value() && evaluator.constraints().check(best->X_WC) == Violation::none);
  result_.X_WC = best->X_WC;
  result_.evaluation = best->evaluation;
  result_.f_e = score(best->evaluation);
  result_.gain_scale = greatest;
  result_.terms = evaluator.terms(best->evaluation, greatest);
  for (auto& [name, value] : result_.terms) {
    if (name == "f_e") value = result_.f_e;
  }
  result_.evaluations = evaluations;
  result_.landmark_term = evaluator.landmark_term();
  result_.cut_short = runner.out_of_time();
  if (poll_) poll_(1);
  return std::move(result_);
}

void SearchFrame::throw_unreachable() const {
  throw_error(ErrorCode::nbv_no_reachable_view,
              "no place around the object satisfies the view's constraints: check the height, pitch and distance limits, the "
              "obstacles around the object, and the forbidden poses (" +
                  std::to_string(situation.forbidden.size()) + ")");
}

void SearchFrame::move_back(Eigen::Vector3d& p_W, double yaw) const {
  constexpr double kSlack = 0.002;  // [m]
  const double d = evaluator.constraints().nearest_voxel(p_W), least = situation.limits.distance_min;
  if (d < least) p_W.head<2>() -= (least - d + kSlack) * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
}

// The list of faces is in the order of the bricks: steps of the golden ratio fall evenly on the surface.
const voxel::VisibilityScene::Face& SearchFrame::face_in_turn(int i) const {
  const double at = std::numbers::phi * i + static_cast<double>(seed_ % 1024) / 1024;
  return faces[static_cast<std::size_t>((at - std::floor(at)) * static_cast<double>(faces.size()))];
}

std::optional<SearchFrame::Place> SearchFrame::draw_place(int i, const PlaceSampling& sampling, Random& random) const {
  constexpr double kTurn = std::numbers::pi;
  const voxel::GridGeometry& g = evaluator.visibility().geometry();
  const Eigen::Vector3d half = g.size.cast<double>() * g.voxel_size / 2;
  const Eigen::Vector3d middle = g.X_WG * half;
  const robot::ViewLimits& l = situation.limits;
  const double farthest = std::max(l.distance_min, std::min(l.distance_max, kFarthestPlace));
  const double height = (l.height_min + l.height_max) / 2, reach = (l.height_max - l.height_min) / 2 * sampling.height_share;
  voxel::VisibilityScene::Face face;
  for (int draw = 0; draw < kDrawsPerPlace; ++draw) {
    // Many of the best views lie at the bounds of the height: draw wider and clamp.
    const double z = height + std::clamp(random.uniform(-1.6, 1.6), -1.0, 1.0) * reach;
    const double angle = random.uniform(-kTurn, kTurn);
    const double distance = l.distance_min + (farthest - l.distance_min) * std::pow(random.uniform(), sampling.nearness);
    Place place{Eigen::Vector3d(0, 0, z), middle};
    if (!faces.empty() && i % 4 != 3) {
      if (draw % kDrawsPerFace == 0) {
        face = sampling.ordered && draw == 0 ? face_in_turn(i) : faces[random.below(faces.size())];
      }
      place.from = g.center_world(evaluator.visibility().voxel(face.voxel));
      place.p_W.head<2>() = place.from.head<2>() + distance * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const double sign = face.direction % 2 == 0 ? -1 : 1;
      const Eigen::Vector3d outward = sign * g.X_WG.linear().col(face.direction / 2);
      if (outward.dot(place.p_W - place.from) < kLeastSlant * distance) continue;
      // Places from which the face is hidden are of little use; where there seem to be no others they must do.
      if (draw < kDrawsPerPlace / 2 && !in_sight(evaluator.judged(), place.p_W, place.from + 0.51 * g.voxel_size * outward)) continue;
    } else {
      // From the middle on: inside a large object too.
      const double radius = distance + std::hypot(half.x(), half.y()) * random.uniform();
      place.p_W.head<2>() = middle.head<2>() + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    const double yaw = std::atan2(place.from.y() - place.p_W.y(), place.from.x() - place.p_W.x());
    if (sampling.ordered) move_back(place.p_W, yaw);
    if (evaluator.constraints().check_position(place.p_W, yaw) == Violation::none) return place;
  }
  return std::nullopt;
}

}  // namespace periplus::nbv
