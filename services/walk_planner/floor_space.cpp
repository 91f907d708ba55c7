#include "services/walk_planner/floor_space.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "common/core/error.h"

namespace periplus::walk {
namespace {

// Lowest corner of the box above the floor, so that the floor's own decoration (a carpet) does not block [m].
constexpr double kFloorClearance = 0.02;

}  // namespace

struct FloorSpace::Standing {
  Pose X_WB = Pose::Identity();  // middle of the box
  Eigen::Vector3d size{0, 0, 0};
  double cosine = 1, sine = 0;   // of its yaw
};

FloorSpace::FloorSpace(std::shared_ptr<const scene::CollisionWorld> world, const robot::BodyBox& body,
                       const voxel::OccupancyGrid* object, const Eigen::Vector2d& lower, const Eigen::Vector2d& upper)
    : world_(std::move(world)), body_(body), lower_(lower), upper_(upper) {
  require(world_ != nullptr, ErrorCode::bad_input, "a collision world is needed to plan a walk");
  require((lower.array() < upper.array()).all(), ErrorCode::bad_input,
          "the floor to walk on is empty; give the room a size");
  if (object == nullptr) return;

  const voxel::GridGeometry& geometry = object->geometry();
  const double voxel = geometry.voxel_size;
  // A voxel's shadow on the floor, however the grid is turned, lies within half its diagonal.
  column_radius_ = 0.5 * std::sqrt(3.0) * voxel;
  std::map<std::pair<int, int>, std::size_t> column_of;
  const std::size_t voxels_per_word = 64;
  const std::vector<std::uint64_t>& occupied = object->occupied();
  const std::vector<std::uint64_t>& environment = object->environment();
  const std::vector<std::uint64_t>& known = object->known();
  const Eigen::Vector3i bricks = geometry.bricks();
  for (std::size_t w = 0; w < occupied.size(); ++w) {
    const std::uint64_t bits = occupied[w] & ~environment[w];
    if (bits == 0) continue;
    const std::size_t brick = w / 8;
    const int bz = static_cast<int>(brick % bricks.z());
    const int by = static_cast<int>(brick / bricks.z() % bricks.y());
    const int bx = static_cast<int>(brick / bricks.z() / bricks.y());
    for (std::size_t b = 0; b < voxels_per_word; ++b) {
      if ((bits >> b & 1) == 0) continue;
      const Eigen::Vector3i v(bx * 8 + static_cast<int>(w % 8), by * 8 + static_cast<int>(b / 8),
                              bz * 8 + static_cast<int>(b % 8));
      const Eigen::Vector3d p = geometry.center_world(v);
      if (p.z() < body_.lower.z() - column_radius_ || p.z() > body_.upper.z() + column_radius_) continue;
      // Voxels above each other share a column: one point a cell of half a voxel is enough.
      const std::pair<int, int> cell(static_cast<int>(std::floor(p.x() / (0.5 * voxel))),
                                     static_cast<int>(std::floor(p.y() / (0.5 * voxel))));
      const auto [at, fresh] = column_of.try_emplace(cell, columns_.size());
      if (fresh) columns_.push_back({{p.x(), p.y()}, false});
      if ((known[w] >> b & 1) != 0) columns_[at->second].known = true;
    }
  }
  if (columns_.empty()) return;
  column_radius_ += 0.5 * voxel;  // what the cells round off
  for (const Column& c : columns_) object_center_ += c.center / static_cast<double>(columns_.size());
  for (const Column& c : columns_) object_radius_ = std::max(object_radius_, (c.center - object_center_).norm());
  object_radius_ += column_radius_;
}

FloorSpace::Standing FloorSpace::standing(const Pose2& body, double shrink) const {
  Eigen::Vector3d low = body_.lower, high = body_.upper;
  low.head<2>().array() += shrink;
  high.head<2>().array() -= shrink;
  low.z() = std::max(low.z(), kFloorClearance);
  const Eigen::Vector3d middle = 0.5 * (low + high);
  return {to_pose(body) * Pose(Eigen::Translation3d(middle)), (high - low).cwiseMax(1e-3), std::cos(body.yaw), std::sin(body.yaw)};
}

bool FloorSpace::touches(const Standing& standing, const Column& column) const {
  const Eigen::Vector2d d = column.center - standing.X_WB.translation().head<2>();
  const double outside_x = std::abs(standing.cosine * d.x() + standing.sine * d.y()) - 0.5 * standing.size.x();
  const double outside_y = std::abs(-standing.sine * d.x() + standing.cosine * d.y()) - 0.5 * standing.size.y();
  return std::hypot(std::max(outside_x, 0.0), std::max(outside_y, 0.0)) < column_radius_;
}

Blocked FloorSpace::blocked(const Pose2& body, double shrink) const {
  const Standing box = standing(body, shrink);
  if (object_radius_ > 0) {
    const Eigen::Vector2d to_object = object_center_ - box.X_WB.translation().head<2>();
    if (to_object.norm() < object_radius_ + 0.5 * box.size.head<2>().norm() &&
        std::any_of(columns_.begin(), columns_.end(), [&](const Column& c) { return touches(box, c); }))
      return Blocked::by_object;
  }
  return world_->box_collides(box.X_WB, box.size) ? Blocked::by_scene : Blocked::no;
}

FloorSpace FloorSpace::left_from(const Pose2& body, double shrink) const {
  FloorSpace out = *this;
  const Standing box = standing(body, shrink);
  std::erase_if(out.columns_, [&](const Column& c) { return !c.known && touches(box, c); });
  return out;
}

}  // namespace periplus::walk
