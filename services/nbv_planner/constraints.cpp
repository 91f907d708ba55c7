#include "services/nbv_planner/constraints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

namespace periplus::nbv {
namespace {

constexpr int kRegion = 32;          // voxels along each axis
constexpr double kFloorSlack = 0.10;  // an object box that begins lower than this stands on the floor [m]

}  // namespace

const char* to_string(Violation violation) {
  switch (violation) {
    case Violation::none: return "none";
    case Violation::not_finite: return "not finite";
    case Violation::height: return "height";
    case Violation::pitch: return "pitch";
    case Violation::roll: return "roll";
    case Violation::yaw: return "yaw";
    case Violation::room: return "outside the room";
    case Violation::too_near: return "too near to the object";
    case Violation::too_far: return "too far from the object";
    case Violation::head: return "head in collision";
    case Violation::body: return "body in collision";
    case Violation::forbidden: return "forbidden";
  }
  return "unknown";
}

double yaw_share(const robot::ViewLimits& limits, double yaw) {
  const double half = (limits.yaw_max - limits.yaw_min) / 2;
  if (half >= std::numbers::pi - 1e-9) return 0;
  return std::abs(wrap_angle(yaw - (limits.yaw_min + half))) / std::max(half, 1e-3);
}

Constraints::Constraints(const Situation& situation, const voxel::VisibilityScene& visibility,
                         const ConstraintSettings& settings)
    : situation_(situation), settings_(settings) {
  const voxel::GridGeometry& g = situation.grid->geometry();
  X_GW_ = g.X_WG.inverse();
  std::map<std::array<int, 6>, Cluster> bricks;  // by region, then by brick
  Cluster* cluster = nullptr;
  Eigen::Vector3i brick(-1, -1, -1);
  for (std::uint32_t at : visibility.surface()) {  // brick by brick
    const Eigen::Vector3i v = visibility.voxel(at), b = v / 8, r = v / kRegion;
    const Eigen::Vector3d center = (v.cast<double>().array() + 0.5) * g.voxel_size;
    if (b != brick) {
      brick = b;
      cluster = &bricks.try_emplace({r.x(), r.y(), r.z(), b.x(), b.y(), b.z()}, Cluster{{center, center}, {}}).first->second;
    }
    cluster->include({center, center});
    cluster->centers_G.push_back(center);
  }
  std::array<int, 3> region{-1, -1, -1};
  for (auto& [at, voxels] : bricks) {
    if (const std::array<int, 3> own{at[0], at[1], at[2]}; own != region) {
      regions_.push_back({{voxels.lower, voxels.upper}, clusters_.size(), clusters_.size()});
      region = own;
    }
    regions_.back().include(voxels);
    clusters_.push_back(std::move(voxels));
    regions_.back().end = clusters_.size();
  }
  double lowest = std::numeric_limits<double>::infinity();
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d corner(c & 1, c >> 1 & 1, c >> 2 & 1);
    lowest = std::min(lowest, (g.X_WG * (corner.cwiseProduct(g.size.cast<double>()) * g.voxel_size)).z());
  }
  on_floor_ = lowest < kFloorSlack;
}

double Constraints::Box::squared_distance(const Eigen::Vector3d& p) const { return (lower - p).cwiseMax(p - upper).cwiseMax(0.0).squaredNorm(); }

void Constraints::Box::include(const Box& other) {
  lower = lower.cwiseMin(other.lower);
  upper = upper.cwiseMax(other.upper);
}

template <class Far, class Call>
bool Constraints::any_cluster(const Far& far, const Call& call) const {
  for (const Region& r : regions_) {
    if (far(r)) continue;
    for (std::size_t i = r.first; i < r.end; ++i) {
      if (!far(clusters_[i]) && call(clusters_[i])) return true;
    }
  }
  return false;
}

double Constraints::nearest_voxel(const Eigen::Vector3d& p_W) const {
  const Eigen::Vector3d p = X_GW_ * p_W;
  double best = std::numeric_limits<double>::infinity();
  const auto scan = [&](const Cluster& c) {
    for (const auto& q : c.centers_G) best = std::min(best, (q - p).squaredNorm());
    return false;
  };
  const auto nearest = [&](auto begin, auto end) {
    return std::min_element(begin, end, [&](const Box& a, const Box& b) { return a.squared_distance(p) < b.squared_distance(p); });
  };
  // The nearest box first: then few others are left.
  if (const auto r = nearest(regions_.begin(), regions_.end()); r != regions_.end()) {
    scan(*nearest(clusters_.begin() + static_cast<std::ptrdiff_t>(r->first), clusters_.begin() + static_cast<std::ptrdiff_t>(r->end)));
  }
  any_cluster([&](const Box& b) { return b.squared_distance(p) >= best; }, scan);
  return std::sqrt(best);
}

bool Constraints::in_room(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d& size = situation_.scene.room.size;
  const double r = settings_.head_radius;
  return std::abs(p.x()) + r <= size.x() / 2 && std::abs(p.y()) + r <= size.y() / 2 && p.z() >= r &&
         p.z() + r <= size.z();
}

bool Constraints::forbidden(const Pose& X_WC) const {
  for (const Pose& F : situation_.forbidden) {
    if ((F.translation() - X_WC.translation()).norm() <= settings_.forbidden_distance &&
        angle_between(F, X_WC) <= settings_.forbidden_angle) {
      return true;
    }
  }
  return false;
}

bool Constraints::body_meets_voxels(const Pose& X_WB, const Eigen::Vector3d& half) const {
  const Pose X_BG = X_WB.inverse() * situation_.grid->geometry().X_WG;
  const double reach = situation_.grid->geometry().voxel_size / 2;
  const Eigen::Vector3d grown = half.array() + reach;
  const auto far = [&](const Box& b) {
    const Eigen::Vector3d middle = X_BG * ((b.lower + b.upper) / 2);
    return ((middle.cwiseAbs() - grown).array() > (b.upper - b.lower).norm() / 2).any();
  };
  return any_cluster(far, [&](const Cluster& c) {
    return std::any_of(c.centers_G.begin(), c.centers_G.end(), [&](const Eigen::Vector3d& q) { return ((X_BG * q).cwiseAbs().array() <= grown.array()).all(); });
  });
}

bool Constraints::body_meets_grid_box(const Pose& X_WB, const Eigen::Vector3d& half) const {
  // Separating axes of two boxes: their face normals (edge pairs left out, which only makes the answer more careful).
  const voxel::GridGeometry& g = situation_.grid->geometry();
  const Eigen::Vector3d other = g.size.cast<double>() * g.voxel_size / 2;
  const Pose X_BO = X_WB.inverse() * g.X_WG * Pose(Eigen::Translation3d(other));
  const Eigen::Matrix3d R = X_BO.linear().cwiseAbs();
  const Eigen::Vector3d t = X_BO.translation(), t_O = X_BO.linear().transpose() * t;
  if ((t.cwiseAbs().array() > (half + R * other).array()).any()) return false;
  return !(t_O.cwiseAbs().array() > (other + R.transpose() * half).array()).any();
}

bool Constraints::body_free(const Eigen::Vector3d& p_W, double yaw) const {
  const Eigen::Array3d shrink(settings_.body_shrink, settings_.body_shrink, 0);
  const Eigen::Vector3d lower = situation_.body.lower.array() + shrink, upper = situation_.body.upper.array() - shrink;
  if ((lower.array() >= upper.array()).any()) return true;
  const Pose2 base{p_W.x() - settings_.base_behind_eyes * std::cos(yaw), p_W.y() - settings_.base_behind_eyes * std::sin(yaw),
                   yaw};
  const Pose X_WB = to_pose(base) * Pose(Eigen::Translation3d((lower + upper) / 2));
  const Eigen::Vector3d size = upper - lower;
  if (situation_.collision->box_collides(X_WB, size)) return false;
  if (body_meets_voxels(X_WB, size / 2)) return false;
  return !(on_floor_ && body_meets_grid_box(X_WB, size / 2));
}

Violation Constraints::check_position(const Eigen::Vector3d& p_W, double yaw) const {
  if (!p_W.allFinite() || !std::isfinite(yaw)) return Violation::not_finite;
  const robot::ViewLimits& l = situation_.limits;
  if (p_W.z() < l.height_min || p_W.z() > l.height_max) return Violation::height;
  if (!in_room(p_W)) return Violation::room;
  const double d = nearest_voxel(p_W);
  if (d < std::max(l.distance_min, settings_.head_radius)) return Violation::too_near;
  if (std::isfinite(d) && d > l.distance_max) return Violation::too_far;
  const double r = settings_.head_radius;
  if (situation_.collision->capsule_distance(p_W, p_W, r, r).distance <= 0) return Violation::head;
  return body_free(p_W, yaw) ? Violation::none : Violation::body;
}

Violation Constraints::check(const Pose& X_WC, double* distance) const {
  if (!is_finite(X_WC)) return Violation::not_finite;
  const Eigen::Vector3d left = X_WC.translation();
  const Eigen::Vector3d right = X_WC * Eigen::Vector3d(situation_.rig.baseline, 0, 0);
  const double d = nearest_voxel(left);
  if (distance != nullptr) *distance = d;
  const robot::ViewLimits& l = situation_.limits;
  const Eigen::Vector3d ypr = camera_yaw_pitch_roll(X_WC);
  constexpr double kRound = 1e-9;
  if (left.z() < l.height_min - kRound || left.z() > l.height_max + kRound) return Violation::height;
  if (ypr.y() < l.pitch_min - kRound || ypr.y() > l.pitch_max + kRound) return Violation::pitch;
  if (std::abs(ypr.z()) > l.roll_max + kRound) return Violation::roll;
  if (yaw_share(l, ypr.x()) > 1 + kRound) return Violation::yaw;
  if (!in_room(left) || !in_room(right)) return Violation::room;
  if (d < std::max(l.distance_min, settings_.head_radius)) return Violation::too_near;
  if (std::isfinite(d) && d > l.distance_max) return Violation::too_far;
  const double r = settings_.head_radius;
  if (nearest_voxel(right) < r) return Violation::head;
  if (situation_.collision->capsule_distance(left, right, r, r).distance <= 0) return Violation::head;
  if (!body_free((left + right) / 2, ypr.x())) return Violation::body;
  return forbidden(X_WC) ? Violation::forbidden : Violation::none;
}

}  // namespace periplus::nbv
