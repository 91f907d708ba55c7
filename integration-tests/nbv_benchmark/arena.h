// Where an object is explored: how it stands, what is around it, which cameras look at it and where they may be.
//
//   dome       the object floats; 48 views of the upper half of a sphere about it, all looking at its middle, as in Isler et al.
//              (ICRA 2016) and Delmerico et al. (2018)
//   free       the object floats; views from all sides, 0.6 to 2.5 m from its surface
//   reachable  the object stands on a table; views that the robot can take: its limits of height, pitch and distance, head and
//              body free of table and object
//
// World frame W, metres. A candidate pose is the left eye's, or the single camera's.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/camera.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/voxel/visibility.h"
#include "integration-tests/nbv_benchmark/depth_scene.h"
#include "integration-tests/nbv_benchmark/mask.h"
#include "integration-tests/nbv_benchmark/subject.h"
#include "integration-tests/nbv_benchmark/surface_coverage.h"
#include "services/nbv_planner/situation.h"

namespace periplus::nbv_benchmark {

enum class PoseSet { dome, free, reachable };
enum class Camera { single, pair };
const char* to_string(PoseSet set);
const char* to_string(Camera camera);

// 640 x 480, 60 degrees horizontally.
Pinhole single_camera();

struct ArenaOptions {
  PoseSet set = PoseSet::free;
  Camera camera = Camera::single;
  int dome_views = 48;
  double dome_distance = 1.0;     // from the object's middle [m]
  int candidates = 400;           // of the sets free and reachable
  std::uint64_t seed = 1;
  std::shared_ptr<const robot::RobotModel> robot;   // its pair, and its limits for the set reachable
};

struct Arena {
  PoseSet set = PoseSet::free;
  Pose X_WO = Pose::Identity();   // the object; a translation
  object_model::ObjectBox box;    // what is known of it beforehand
  StereoRig rig;                  // baseline 0: one camera
  bool pair = false;
  scene::Scene scene;
  std::shared_ptr<const scene::CollisionWorld> collision;
  robot::ViewLimits limits;
  robot::BodyBox body;
  DepthScene truth;               // object and solids
  std::vector<Pose> candidates;   // valid with the true object in its place
  Mask visible;                   // samples that at least one candidate sees, both eyes where it is a pair
  Mask visible_voxels;            // of Subject::voxel_points
};

// Throws Error(bad_input) if the robot is missing where it is needed, or if no pose is to be found.
Arena make_arena(const Subject& subject, const ArenaOptions& options);

// Height up to which a point is the table's rather than the object's, in the object's frame [m]; nothing where there is no table.
std::optional<double> table_height_object(const Arena& arena);
// The depth map without the points of the table.
ImageF without_table(const Arena& arena, const object_model::DepthMap& map);

// What the planner is told of an arena, with this grid.
nbv::Situation situation_of(const Arena& arena, std::shared_ptr<const voxel::OccupancyGrid> grid);

}  // namespace periplus::nbv_benchmark
