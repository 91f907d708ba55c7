// The robot, and a room with an unknown object on a table, for the posture generator's tests and benchmark.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "common/core/random.h"
#include "services/posture_generator/posture_problem.h"

namespace periplus::posture::testing {

inline std::shared_ptr<const robot::RobotModel> hrp2like() {
  const std::string folder = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/robots/";
  return robot::RobotModel::load_files(folder + "hrp2like.urdf", folder + "hrp2like.yaml");
}

inline scene::Solid solid(const std::string& name, scene::Shape shape, const Eigen::Vector3d& size, const Eigen::Vector3d& p_WS) {
  scene::Solid s;
  s.name = name;
  s.shape = shape;
  s.size = size;
  s.X_WS = make_pose(p_WS, Eigen::Matrix3d::Identity());
  return s;
}

// A table of 0.7 m with its middle at x = table_x, a box of 0.5 m of unknown voxels on it at x = object_x, `other` beside it.
class ObjectOnTable {
 public:
  ObjectOnTable(double table_x, double object_x, const scene::Solid& other, const Settings& settings) {
    scene_.solids = {solid("table", scene::Shape::box, {0.7, 0.7, 0.7}, {table_x, 0, 0.35}), other};
    world_ = std::make_unique<scene::CollisionWorld>(scene_);
    const Pose X_WB = make_pose({object_x, 0, 0.95}, Eigen::Matrix3d::Identity());
    object_ = ObjectObstacle(voxel::OccupancyGrid(voxel::GridGeometry::from_box(X_WB, {0.5, 0.5, 0.5}, 0.02)), settings.object_cell);
  }
  Surroundings surroundings() const { return {&scene_, world_.get(), &object_}; }
  const scene::CollisionWorld& world() const { return *world_; }

 private:
  scene::Scene scene_;
  std::unique_ptr<scene::CollisionWorld> world_;
  ObjectObstacle object_;
};

// As in the demonstration: the object stands at the origin, a screen behind it.
inline ObjectOnTable demonstration(const Settings& settings) {
  return {0, 0, solid("screen", scene::Shape::box, {0.1, 0.8, 1.6}, {1.1, 0, 0.8}), settings};
}

// A view of that object from outside: left eye at distance and height, looking at the box.
inline Pose view_of_object(Random& random) {
  const double around = random.uniform(0.9, 2 * std::numbers::pi - 0.9), distance = random.uniform(1.0, 1.6);
  const Eigen::Vector3d p(distance * std::cos(around), distance * std::sin(around), random.uniform(1.0, 1.35));
  const double x = random.uniform(-0.15, 0.15), y = random.uniform(-0.15, 0.15), z = random.uniform(0.8, 1.1);
  return look_at(p, {x, y, z});
}

struct Hopeless {
  Pose X_WC;
  std::string reason;  // failed_constraint; empty: any
};
inline std::vector<Hopeless> hopeless_views() {
  return {{look_along({-1.5, 0, 2.2}, 0, 0), "camera_pose"},     // over the head
          {look_along({-1.5, 0, 0.15}, 0, 0), ""},               // on the floor
          {look_along({-1.5, 0, 1.2}, 0, 0, 3.1), ""},           // upside down
          {look_along({0.25, 0, 1.45}, 3.1, 1.2), ""}};          // above the object, the table in the way
}

}  // namespace periplus::posture::testing
