#include "integration-tests/thesis_comparisons/comparisons.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <numbers>

#include "common/core/random.h"
#include "services/nbv_planner/task_runner.h"
#include "services/nbv_planner/view_search.h"

namespace periplus::thesis_comparisons {
namespace {

using nbv::LocalMethod;
using Workspace = nbv::Evaluator::Workspace;
using Cases = std::vector<std::pair<const State*, Pose>>;

constexpr double kSimilar = 0.02;  // of the largest N_u

double quality(const State& state, double f) { return std::max(-1.0, -f / state.greatest); }

// f(i, workspace) for i < count.
void each(int count, int threads, const std::function<void(int, Workspace&)>& f) {
  std::atomic<int> next{0};
  std::vector<Workspace> workspaces(static_cast<std::size_t>(std::max(threads, 1)));
  nbv::on_threads(std::min(threads, count), [&](int worker) {
    for (int i; (i = next++) < count;) f(i, workspaces[static_cast<std::size_t>(worker)]);
  });
}

TrustRegion compare_trust_regions(const Cases& cases, int threads) {
  TrustRegion t;
  t.begin = {0.02, 0.05, 0.1, 0.2, 0.5, 1, 2};
  t.end = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5};
  t.cases = static_cast<int>(cases.size());
  const std::size_t nb = t.begin.size(), ne = t.end.size();
  std::vector<LocalOutcome> outcomes(cases.size() * nb * ne);
  each(static_cast<int>(outcomes.size()), threads, [&](int i, Workspace& w) {
    const auto& [state, start] = cases[static_cast<std::size_t>(i) / (nb * ne)];
    LocalOptions o;
    o.rho_beg = t.begin[static_cast<std::size_t>(i) / ne % nb] * state->size;
    o.rho_end = std::min(t.end[static_cast<std::size_t>(i) % ne] * state->size, o.rho_beg);
    outcomes[static_cast<std::size_t>(i)] = search_locally(*state, start, o, w);
  });
  t.quality.assign(nb, std::vector<double>(ne, 0));
  t.evaluations = t.quality;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const std::size_t b = i / ne % nb, e = i % ne;
    t.quality[b][e] += quality(*cases[i / (nb * ne)].first, outcomes[i].f_e) / static_cast<double>(cases.size());
    t.evaluations[b][e] += outcomes[i].evaluations / static_cast<double>(cases.size());
  }
  return t;
}

StartLine compare_starts(const State& state, int steps, int threads) {
  constexpr int kMostRuns = 10;
  StartLine line;
  line.object = state.object;
  const Eigen::Vector3d middle = state.situation.grid->geometry().X_WG * (state.situation.grid->geometry().size.cast<double>() *
                                                                         state.situation.grid->geometry().voxel_size / 2).eval();
  // In front: on the side of the last look's opposite, where most is unknown; as far as the first is from the axis.
  const Eigen::Vector3d away = middle - state.last.translation();
  const double side = std::atan2(away.y(), away.x());
  std::vector<LocalOutcome> start(static_cast<std::size_t>(steps)), once = start, iterated = start;
  for (int i = 0; i < steps; ++i) line.y.push_back(-1 + 2.0 * i / std::max(1, steps - 1));
  each(steps, threads, [&](int i, Workspace& w) {
    const auto k = static_cast<std::size_t>(i);
    const Eigen::Vector3d p = Eigen::Vector3d(middle.x(), middle.y(), 1.2) + Eigen::Vector3d(1.2 * std::cos(side), 1.2 * std::sin(side), 0) +
                              line.y[k] * Eigen::Vector3d(-std::sin(side), std::cos(side), 0);
    const Pose X = look_along(p, side + std::numbers::pi, std::atan2(1.2 - middle.z(), 1.2));
    start[k] = outcome_of(state, X, w);
    once[k] = search_locally(state, X, {}, w);
    LocalOptions many;
    many.runs = kMostRuns;
    iterated[k] = search_locally(state, X, many, w);
  });
  double runs = 0;
  int most = 0;
  for (std::size_t k = 0; k < start.size(); ++k) {
    line.start.push_back(start[k].f_e);
    line.once.push_back(once[k].f_e);
    line.iterated.push_back(iterated[k].f_e);
    runs += iterated[k].runs;
    most += iterated[k].runs == kMostRuns;
    line.farthest = std::max(line.farthest, (iterated[k].X_WC.translation() - start[k].X_WC.translation()).norm());
    line.turned = std::max(line.turned, angle_between(iterated[k].X_WC, start[k].X_WC));
    if (k == 0) continue;
    const double change = std::abs(start[k].f_e - start[k - 1].f_e) / state.greatest;
    line.start_change += change / (steps - 1);
    line.largest_start_change = std::max(line.largest_start_change, change);
    line.found_change += std::abs(once[k].f_e - once[k - 1].f_e) / state.greatest / (steps - 1);
  }
  line.mean_runs = runs / steps;
  line.share_at_most = static_cast<double>(most) / steps;
  return line;
}

// A fixed sampling of the six dimensions around a pose, with limits and numbers set by hand as in 3.4.3: 5 x 5 places of up to 0.8 m
// about it, 3 heights, 5 yaws (turned towards the object), 3 pitches, no roll.
std::vector<Pose> fixed_sampling(const State& state, const Pose& last) {
  const robot::ViewLimits& l = state.situation.limits;
  const Eigen::Vector3d middle = state.situation.grid->geometry().X_WG * (state.situation.grid->geometry().size.cast<double>() *
                                                                         state.situation.grid->geometry().voxel_size / 2).eval();
  std::vector<Pose> poses;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = 0; z < 3; ++z) {
        const Eigen::Vector3d p(last.translation().x() + 0.4 * x, last.translation().y() + 0.4 * y, l.height_min + (l.height_max - l.height_min) * (z + 0.5) / 3);
        const Eigen::Vector3d d = middle - p;
        const double yaw = std::atan2(d.y(), d.x()), pitch = std::atan2(-d.z(), std::hypot(d.x(), d.y()));
        for (int a = -2; a <= 2; ++a) {
          for (int b = -1; b <= 1; ++b) {
            poses.push_back(look_along(p, yaw + 0.12 * a, std::clamp(pitch + 0.12 * b, l.pitch_min, l.pitch_max)));
          }
        }
      }
    }
  }
  return poses;
}

Sampling compare_sampling(const std::vector<std::unique_ptr<State>>& states, const ComparisonOptions& options) {
  Sampling s;
  s.cases = static_cast<int>(states.size());
  s.most_samples = 4000;
  struct Case {
    double newuoa = 0, fixed = 0, both = 0;
    int evaluations = 0;
    double newuoa_evaluations = 0, samples = 0;
    bool reached = false;
  };
  std::vector<Case> cases(states.size());
  each(s.cases, options.threads, [&](int i, Workspace& w) {
    const State& state = *states[static_cast<std::size_t>(i)];
    Case& c = cases[static_cast<std::size_t>(i)];
    const std::vector<Pose> poses = fixed_sampling(state, state.last);
    c.evaluations = static_cast<int>(poses.size());
    double best = 1e300;
    for (const Pose& X : poses) best = std::min(best, outcome_of(state, X, w).f_e);
    c.fixed = quality(state, best);
    LocalOptions o;
    o.runs = 10;
    o.evaluations = c.evaluations;
    c.newuoa = quality(state, search_locally(state, state.last, o, w).f_e);
    nbv::SearchSettings search;
    search.method = nbv::SearchMethod::thesis;
    search.thesis.local = nbv::ThesisLocal::newuoa;
    search.max_evaluations = c.evaluations;
    nbv::ThreadRunner alone(1);
    c.both = quality(state, outcome_of(state, nbv::plan_view(*state.evaluator, options.seed, search, alone).X_WC, w).f_e);

    // How many poses of a growing sampling of the space between start and minimum reach what one run of NEWUOA found.
    const LocalOutcome minimum = search_locally(state, state.starts.front(), {}, w);
    const Eigen::Vector3d reach = (minimum.X_WC.translation() - state.starts.front().translation()).cwiseAbs().cwiseMax(0.1);
    const Eigen::Vector3d from = camera_yaw_pitch_roll(state.starts.front()), to = camera_yaw_pitch_roll(minimum.X_WC);
    Eigen::Vector3d turn;
    for (int k = 0; k < 3; ++k) turn[k] = std::max(0.05, std::abs(wrap_angle(to[k] - from[k])));
    Random random(options.seed + 77u * static_cast<std::uint64_t>(i));
    c.newuoa_evaluations = minimum.evaluations_to(kSimilar * state.greatest);
    for (int n = 1; n <= s.most_samples && !c.reached; ++n) {
      Eigen::Vector3d p = state.starts.front().translation(), a = from;
      for (int k = 0; k < 3; ++k) {
        p[k] += random.uniform(-reach[k], reach[k]);
        a[k] += random.uniform(-turn[k], turn[k]);
      }
      c.samples = n;
      c.reached = outcome_of(state, look_along(p, a.x(), a.y(), a.z()), w).f_e <= minimum.f_e + kSimilar * state.greatest;
    }
  });
  std::vector<double> own, samples;
  const double n = s.cases;
  for (const Case& c : cases) {
    s.evaluations = c.evaluations;
    s.newuoa += c.newuoa / n;
    s.fixed += c.fixed / n;
    s.both += c.both / n;
    s.fixed_similar_or_better += (c.fixed >= c.newuoa - kSimilar) / n;
    s.both_best += (c.both >= std::max(c.fixed, c.newuoa) - kSimilar) / n;
    s.not_reached += !c.reached / n;
    own.push_back(c.newuoa_evaluations);
    samples.push_back(c.samples);
  }
  s.newuoa_evaluations = median(own);
  s.local_samples = median(samples);
  return s;
}

bool near_limit(const State& state, const Pose& X_WC) {
  const robot::ViewLimits& l = state.situation.limits;
  const auto outer = [](double v, double low, double high) { return std::abs(2 * v - low - high) > 0.9 * (high - low); };
  return outer(X_WC.translation().z(), l.height_min, l.height_max) || outer(camera_yaw_pitch_roll(X_WC).y(), l.pitch_min, l.pitch_max);
}

Methods compare_methods(const Cases& cases, double rho_end, int threads) {
  Methods m;
  m.cases = static_cast<int>(cases.size());
  m.rho_end = rho_end;
  const std::vector<std::pair<std::string, LocalMethod>> all{
      {"NEWUOA", LocalMethod::newuoa}, {"BOBYQA", LocalMethod::bobyqa}, {"Nelder-Mead", LocalMethod::nelder_mead}};
  std::vector<LocalOutcome> outcomes(cases.size() * all.size());
  each(static_cast<int>(outcomes.size()), threads, [&](int i, Workspace& w) {
    const auto k = static_cast<std::size_t>(i);
    LocalOptions o;
    o.method = all[k % 3].second;
    o.rho_end = rho_end;
    outcomes[k] = search_locally(*cases[k / 3].first, cases[k / 3].second, o, w);
  });
  const double n = m.cases;
  for (std::size_t method = 0; method < all.size(); ++method) {
    Method r;
    r.name = all[method].first;
    for (std::size_t c = 0; c < cases.size(); ++c) {
      const LocalOutcome& o = outcomes[3 * c + method];
      r.quality += quality(*cases[c].first, o.f_free) / n;
      r.voxels += o.evaluation.value / cases[c].first->greatest / n;
      r.evaluations += o.evaluations / n;
      r.within += o.within / n;
      r.near_limit += near_limit(*cases[c].first, o.X_WC) / n;
    }
    m.methods.push_back(r);
  }
  std::vector<double> fewer, more;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const State& state = *cases[c].first;
    const LocalOutcome &newuoa = outcomes[3 * c], &bobyqa = outcomes[3 * c + 1], &simplex = outcomes[3 * c + 2];
    m.bobyqa_similar += (bobyqa.evaluation.value >= 0.9 * newuoa.evaluation.value) / n;
    const double ahead = quality(state, bobyqa.f_free) - quality(state, simplex.f_free);
    m.bobyqa_better += (ahead > 0.01) / n;
    m.simplex_better += (ahead < -0.01) / n;
    fewer.push_back(static_cast<double>(newuoa.evaluations) / bobyqa.evaluations);
    more.push_back(static_cast<double>(simplex.evaluations) / bobyqa.evaluations);
  }
  m.fewer_than_newuoa = median(fewer);
  m.simplex_more = median(more);
  return m;
}

LargeRun model_large(const World& world, nbv::Quantification quantification, const char* name, std::uint64_t seed, const ComparisonOptions& o,
                     std::vector<nbv_benchmark::Mask>& known) {
  LargeRun run;
  run.object = world.subject.file.name;
  run.quantification = name;
  run.seed = seed;
  nbv_benchmark::Reconstruction model(world.arena, world.subject, {});
  nbv::EvaluationSettings evaluation = thesis_evaluation();
  evaluation.quantification = quantification;
  nbv::SearchSettings search;
  search.method = nbv::SearchMethod::thesis;
  search.max_evaluations = o.large_evaluations;
  nbv::ThreadRunner runner(o.threads);
  for (int view = 0; view < o.large_views; ++view) {
    const nbv::Situation situation = nbv_benchmark::situation_of(world.arena, std::make_shared<voxel::OccupancyGrid>(model.grid()));
    const nbv::Evaluator evaluator(situation, evaluation, {});
    Pose X;
    try {
      X = view == 0 ? pose_around(evaluator, world, static_cast<double>(seed), seed) : nbv::plan_view(evaluator, seed + static_cast<std::uint64_t>(view), search, runner).X_WC;
    } catch (const Error& e) {
      if (e.code() != ErrorCode::nbv_no_reachable_view) throw;
      break;
    }
    run.distance.push_back(evaluator.constraints().nearest_voxel(X.translation()));
    model.integrate(look(world, X));
    known.push_back(model.known(world.subject));
  }
  return run;
}

Quantifications compare_quantifications(const std::vector<World>& worlds, const ComparisonOptions& o, const Say& say) {
  Quantifications q;
  const std::vector<std::pair<const char*, nbv::Quantification>> all{
      {"pixels", nbv::Quantification::pixels}, {"voxels", nbv::Quantification::voxels}, {"mixed", nbv::Quantification::mixed}};
  for (const World& world : worlds) {
    std::vector<std::vector<nbv_benchmark::Mask>> known;
    const std::size_t first = q.runs.size();
    for (const auto& [name, quantification] : all) {
      for (int seed = 1; seed <= o.large_seeds; ++seed) {
        known.emplace_back();
        q.runs.push_back(model_large(world, quantification, name, static_cast<std::uint64_t>(seed), o, known.back()));
      }
      say("3.4.1 quantification: " + world.subject.file.name + ", " + name);
    }
    nbv_benchmark::Mask reached(world.subject.voxel_points.size());
    for (const auto& run : known) {
      if (!run.empty()) reached |= run.back();
    }
    for (std::size_t i = first; i < q.runs.size(); ++i) {
      LargeRun& run = q.runs[i];
      for (const auto& mask : known[i - first]) run.known.push_back(nbv_benchmark::share(mask, reached));
      const auto poses_to = [&](double level) {
        const auto at = std::find_if(run.known.begin(), run.known.end(), [&](double k) { return k >= level; });
        return static_cast<int>(at - run.known.begin()) + 1;
      };
      run.poses_to_90 = poses_to(0.90);
      run.poses_to_95 = poses_to(0.95);
    }
  }
  return q;
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

Comparisons run_comparisons(const ComparisonOptions& o, const Say& say) {
  Comparisons out;
  nbv_benchmark::SubjectOptions small, large;
  small.longest_side = o.size;
  small.voxels = o.voxels;
  small.samples = large.samples = 2000;
  large.longest_side = o.large_size;
  large.voxels = o.large_voxels;
  std::vector<World> worlds;
  for (const auto& file : o.files) worlds.push_back(on_table(nbv_benchmark::load_subject(file, small), o.robot));
  auto shapes = generated_shapes();
  shapes.resize(std::min(shapes.size(), o.generated));
  for (auto& [name, mesh] : shapes) worlds.push_back(on_table(nbv_benchmark::make_subject(name, std::move(mesh), "z", small), o.robot));
  std::vector<std::unique_ptr<State>> twice, growing;
  Cases cases;
  for (const World& world : worlds) {
    out.objects.push_back(world.subject.file.name);
    twice.push_back(carved(world, 2, o.starts, o.seed + twice.size()));
    for (const Pose& start : twice.back()->starts) cases.emplace_back(twice.back().get(), start);
    for (int views = 1; views <= 3; ++views) growing.push_back(carved(world, views, 1, o.seed + growing.size()));
  }
  say(std::to_string(worlds.size()) + " objects, " + std::to_string(cases.size()) + " starts");
  out.trust_region = compare_trust_regions(cases, o.threads);
  say("3.4.2 trust region");
  for (std::size_t i = 0; i < std::min<std::size_t>(3, twice.size()); ++i) out.lines.push_back(compare_starts(*twice[i], o.line_steps, o.threads));
  say("3.4.2 starting pose");
  out.sampling = compare_sampling(growing, o);
  say("3.4.3 sampling");
  for (const double rho_end : {1e-3, 1e-4, 1e-5}) out.methods.push_back(compare_methods(cases, rho_end, o.threads));
  say("3.4.4 BOBYQA, 3.4.5 simplex");
  std::vector<World> large_worlds;
  for (std::size_t i = 0; i < o.files.size() && static_cast<int>(i) < o.large_objects; ++i) {
    large_worlds.push_back(on_floor(nbv_benchmark::load_subject(o.files[i], large), o.robot));
  }
  out.quantifications = compare_quantifications(large_worlds, o, say);
  return out;
}

}  // namespace periplus::thesis_comparisons
