// A path of the half-sitting bounding box over the floor: two rapidly-exploring random trees that grow towards each
// other (Kuffner and LaValle, RRT-Connect, 2000; thesis 5.2.3), then shortened. The robot may step forward, backward,
// sideways and turn in place, so every segment (straight in x, y and yaw) can be walked. Deterministic for a seed.
#pragma once

#include <cstdint>
#include <vector>

#include "common/geometry/pose.h"
#include "services/walk_planner/floor_space.h"

namespace periplus::walk {

struct PathSettings {
  double yaw_weight = 0.35;      // what a turn counts against a way [m/rad]
  double extension = 0.40;       // longest branch of a tree [m]
  double check_distance = 0.03;  // poses checked along a segment: at most this far apart [m]
  double check_angle = 0.07;     // and turned by at most this [rad]
  int samples = 8000;            // random poses before giving up
  int shortcuts = 200;           // attempts to shorten
  // The robot's own posture was found free at both ends, where the box is only a coarse hull: within `end_radius` [m]
  // of start and goal its sides move inwards by `end_shrink` [m].
  double end_radius = 0.45;
  double end_shrink = 0.10;

  void check() const;  // throws Error(bad_input)
};

struct Path {
  std::vector<Pose2> poses;  // corners, start and goal included; yaw takes the shorter way round
  int samples = 0;           // random poses drawn
  double length() const;     // on the floor [m]
};

// `floor` as it is for a robot that stands at `start` (FloorSpace::left_from, moved inwards by `end_shrink`).
// Throws Error(walk_start_in_collision | walk_goal_in_collision | walk_no_path) with what was hit and where.
Path plan_path(const FloorSpace& floor, const Pose2& start, const Pose2& goal, std::uint64_t seed,
               const PathSettings& settings = {});

// Pose at share t in 0..1 of the straight segment.
Pose2 interpolate(const Pose2& a, const Pose2& b, double t);
// About how many steps the segment takes: forward 0.20, backward 0.15, sideways 0.035 m, turning 0.2 rad a step.
double steps_of(const Pose2& a, const Pose2& b);

}  // namespace periplus::walk
