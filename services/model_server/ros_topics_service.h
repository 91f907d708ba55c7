// Models as ROS 2 tools know them: rt/octomap_binary (octomap_msgs/msg/Octomap) and rt/object_points (sensor_msgs/msg/PointCloud2), of
// the object that changed last, in frame `world`, stamped with its newest view. Reliable, transient-local, and out again when another reader
// comes, so that a tool that comes late has the newest even if it asks for volatile samples.
#pragma once

#include <memory>

#include "common/object_model/object_model.h"

namespace periplus::dds {
class Node;
}

namespace periplus::model {

// Makes a message on a thread of its own, only while somebody reads it, and of the newest model only: who integrates never waits.
class RosTopics {
 public:
  explicit RosTopics(dds::Node& node);
  ~RosTopics();
  void offer(std::shared_ptr<const object_model::ObjectModel> model);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::model
