#include "services/nbv_planner/gain.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/core/error.h"
#include "common/voxel/distance.h"
#include "common/voxel/ray_traversal.h"

namespace periplus::nbv {
namespace {

using voxel::VoxelState;

double entropy(double p) { return p <= 0 || p >= 1 ? 0 : -p * std::log(p) - (1 - p) * std::log(1 - p); }

// One ray's voxels go to voxel(), one after the other, then the ray ends: `surface` if in known surface of the object.
class RayGain : public InformationGain {
 public:
  RayGain(const char* name, const Situation& situation, const GainSettings& settings)
      : situation_(situation), settings_(settings), name_(name), X_GW_(situation.grid->geometry().X_WG.inverse()) {
    probability_[int(VoxelState::empty)] = settings.p_empty;
    probability_[int(VoxelState::unknown)] = settings.p_unknown;
    probability_[int(VoxelState::known)] = probability_[int(VoxelState::environment)] = settings.p_known;
    for (int i = 0; i < 4; ++i) entropy_[i] = entropy(probability_[i]);
  }

  const char* name() const override { return name_; }
  double evaluate(const Pose& X_WC) const override;

 protected:
  struct Sums {
    double gain = 0;                                        // of finished rays
    double ray = 0, visible = 1, count = 0, ray_count = 0;  // of the ray under way
    double surface = 0, occlusion = 0, other = 0;           // rays by what they meet first
    bool unknown_before = false, registered = false;
  };
  virtual void voxel(const Eigen::Vector3i& v, VoxelState state, Sums& sums) const = 0;
  virtual void end(bool /*surface*/, Sums& /*sums*/) const {}
  virtual double result(const Sums& sums) const { return sums.gain; }

  double probability(VoxelState s) const { return probability_[int(s)]; }
  double entropy_of(VoxelState s) const { return entropy_[int(s)]; }

  const Situation& situation_;
  GainSettings settings_;

 private:
  const char* name_;
  Pose X_GW_;
  std::array<double, 4> probability_{}, entropy_{};
};

double RayGain::evaluate(const Pose& X_WC) const {
  require(is_finite(X_WC), ErrorCode::not_finite, "a viewpoint must be finite");
  const voxel::OccupancyGrid& grid = *situation_.grid;
  const voxel::GridGeometry& g = grid.geometry();
  const Pinhole& camera = situation_.rig.camera;
  const double half_base = situation_.rig.baseline / 2;
  const Eigen::Vector3d eye = X_WC * Eigen::Vector3d(half_base, 0, 0);
  const Eigen::Vector3d middle = g.X_WG * (g.size.cast<double>() * g.voxel_size / 2);
  const double depth = std::max((middle - eye).dot(X_WC.linear().col(2)), 0.1);
  const Eigen::Vector3d o = X_GW_ * eye;
  const double range = situation_.limits.distance_max + g.voxel_size * g.size.cast<double>().norm();
  const int step = settings_.pixel_step;
  Sums sums;
  for (int row = step / 2; row < camera.height; row += step) {
    for (int column = step / 2; column < camera.width; column += step) {
      const Eigen::Vector3d d_C = camera.back_project(column, row, 1);
      // What the left eye has to its right by `half_base`, and the right eye to its left.
      const double shift = half_base / depth * camera.fx;
      if (column - shift < 0 || column + shift > camera.width - 1) continue;
      const Eigen::Vector3d d_W = X_WC.linear() * d_C.normalized();
      const double free = range * situation_.collision->first_hit(eye, eye + range * d_W).value_or(1);
      sums.ray = sums.ray_count = 0;
      sums.visible = 1;
      sums.unknown_before = sums.registered = false;
      bool surface = false;
      voxel::traverse_ray(g, o, X_GW_.linear() * d_W, free, [&](const Eigen::Vector3i& v, double, double) {
        const VoxelState state = grid.state(v);
        surface = state == VoxelState::known;
        this->voxel(v, state, sums);
        return state == VoxelState::empty || state == VoxelState::unknown;
      });
      end(surface, sums);
    }
  }
  return result(sums);
}

class OcclusionAware final : public RayGain {
 public:
  using RayGain::RayGain;

 private:
  void voxel(const Eigen::Vector3i&, VoxelState s, Sums& sums) const override {
    sums.gain += sums.visible * entropy_of(s);
    sums.visible *= 1 - probability(s);
  }
};

class Unobserved final : public RayGain {
 public:
  using RayGain::RayGain;

 private:
  void voxel(const Eigen::Vector3i&, VoxelState s, Sums& sums) const override {
    if (s == VoxelState::unknown) sums.gain += sums.visible * entropy_of(s);
    sums.visible *= 1 - probability(s);
  }
};

class RearSide final : public RayGain {
 public:
  using RayGain::RayGain;

 private:
  void voxel(const Eigen::Vector3i&, VoxelState s, Sums& sums) const override {
    if (s == VoxelState::known && sums.unknown_before) sums.gain += 1;
    sums.unknown_before = s == VoxelState::unknown;
  }
};

class RearSideEntropy final : public RayGain {
 public:
  using RayGain::RayGain;

 private:
  void voxel(const Eigen::Vector3i&, VoxelState s, Sums& sums) const override {
    const double seen = sums.visible * entropy_of(s);
    if (s == VoxelState::unknown) sums.ray += seen;
    else if (s == VoxelState::known && sums.unknown_before) sums.gain += sums.ray + seen;
    else sums.ray = 0;
    sums.unknown_before = s == VoxelState::unknown;
    sums.visible *= 1 - probability(s);
  }
};

class ProximityCount final : public RayGain {
 public:
  ProximityCount(const char* name, const Situation& situation, const GainSettings& settings)
      : RayGain(name, situation, settings),
        distance_(voxel::distance_to_state(*situation.grid, VoxelState::known, settings.proximity_reach)) {}

 private:
  void voxel(const Eigen::Vector3i& v, VoxelState s, Sums& sums) const override {
    const Eigen::Vector3i size = situation_.grid->geometry().size;
    const float d = distance_[(static_cast<std::size_t>(v.x()) * size.y() + v.y()) * size.z() + v.z()];
    if (s == VoxelState::unknown && d < settings_.proximity_reach) sums.gain += settings_.proximity_reach - d;
  }
  std::vector<float> distance_;
};

class AverageEntropy final : public RayGain {
 public:
  using RayGain::RayGain;

 private:
  void voxel(const Eigen::Vector3i&, VoxelState s, Sums& sums) const override {
    sums.ray += entropy_of(s);
    sums.ray_count += 1;
  }
  void end(bool surface, Sums& sums) const override {
    if (!surface) return;
    sums.gain += sums.ray;
    sums.count += sums.ray_count;
  }
  double result(const Sums& sums) const override { return sums.count == 0 ? 0 : sums.gain / sums.count; }
};

class AreaFactor final : public RayGain {
 public:
  using RayGain::RayGain;

 private:
  void voxel(const Eigen::Vector3i& v, VoxelState s, Sums& sums) const override {
    if (sums.registered || s == VoxelState::empty) return;
    sums.registered = true;
    if (s == VoxelState::known) sums.surface += 1;
    else if (s == VoxelState::unknown && next_to_empty(v)) sums.occlusion += 1;
    else sums.other += 1;
  }
  void end(bool, Sums& sums) const override { sums.other += !sums.registered; }
  double result(const Sums& sums) const override {
    const double rays = sums.surface + sums.occlusion + sums.other;
    if (rays == 0) return 0;
    return factor(sums.surface / rays, settings_.desired_known) + factor(sums.occlusion / rays, settings_.desired_occlusion);
  }
  bool next_to_empty(const Eigen::Vector3i& v) const {
    for (int k = 0; k < 6; ++k) {
      Eigen::Vector3i n = v;
      n[k / 2] += k % 2 == 0 ? -1 : 1;
      if (situation_.grid->geometry().contains(n) && situation_.grid->state(n) == VoxelState::empty) return true;
    }
    return false;
  }
  // Cubic with f(0) = 0, f(a) = 1, f(1) = 0 and level at all three.
  static double factor(double x, double a) {
    const double t = x <= a ? x / a : (1 - x) / (1 - a);
    return t * t * (3 - 2 * t);
  }
};

}  // namespace

const std::vector<std::string>& information_gain_names() {
  static const std::vector<std::string> names{"occlusion_aware", "unobserved",      "rear_side",  "rear_side_entropy",
                                              "proximity_count", "average_entropy", "area_factor"};
  return names;
}

std::unique_ptr<InformationGain> make_information_gain(const std::string& name, const Situation& s, const GainSettings& settings) {
  check(s);
  const auto share = [](double p) { return p > 0 && p < 1; };
  require(settings.pixel_step >= 1 && share(settings.p_unknown) && share(settings.p_known) && share(settings.p_empty) &&
              settings.proximity_reach > 0 && share(settings.desired_known) && share(settings.desired_occlusion),
          ErrorCode::bad_input, "a gain's pixel step must be 1 or more, its reach positive, its probabilities and shares between 0 and 1");
  if (name == "occlusion_aware") return std::make_unique<OcclusionAware>("occlusion_aware", s, settings);
  if (name == "unobserved") return std::make_unique<Unobserved>("unobserved", s, settings);
  if (name == "rear_side") return std::make_unique<RearSide>("rear_side", s, settings);
  if (name == "rear_side_entropy") return std::make_unique<RearSideEntropy>("rear_side_entropy", s, settings);
  if (name == "proximity_count") return std::make_unique<ProximityCount>("proximity_count", s, settings);
  if (name == "average_entropy") return std::make_unique<AverageEntropy>("average_entropy", s, settings);
  if (name == "area_factor") return std::make_unique<AreaFactor>("area_factor", s, settings);
  std::string known;
  for (const std::string& n : information_gain_names()) known += (known.empty() ? "" : ", ") + n;
  throw_error(ErrorCode::bad_input, "there is no gain '" + name + "'; those that are: " + known);
}

}  // namespace periplus::nbv
