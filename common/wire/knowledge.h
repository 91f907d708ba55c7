// What the model server knows, as its readers see it: the environment, the robot and the newest revisions of objects,
// from the topics periplus/environment and periplus/object.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/dds/node.h"
#include "common/object_model/perception.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::wire {

// Immutable once published here.
struct KnownEnvironment {
  std::string scene_id, revision;
  scene::Scene scene;
  std::shared_ptr<const scene::CollisionWorld> collision;
  std::shared_ptr<const robot::RobotModel> robot;
};
struct KnownObject {
  std::string object_id;
  std::uint32_t revision = 0;
  std::shared_ptr<const voxel::OccupancyGrid> grid;
  std::vector<object_model::Landmark> landmarks;
};

// Thread-safe. Bad samples are logged and dropped.
class Knowledge {
 public:
  explicit Knowledge(dds::Node& node);
  ~Knowledge();

  // Waits up to `timeout`; nullptr if none arrived.
  std::shared_ptr<const KnownEnvironment> environment(std::chrono::milliseconds timeout = std::chrono::seconds(2)) const;
  // That very revision (the last four of each object are kept); nullptr if it did not arrive in time.
  std::shared_ptr<const KnownObject> object(const std::string& object_id, std::uint32_t revision,
                                            std::chrono::milliseconds timeout = std::chrono::seconds(2)) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::wire
