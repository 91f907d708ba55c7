// A modelling task: which robot, scene and object, how fine, when to stop. One YAML file, schema 1 (deploy/tasks).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "common/object_model/perception.h"

namespace periplus::config {
class Node;
}

namespace periplus::supervisor {

struct StopSettings {
  double least_gain_voxels = 20;   // complete when the best view promises fewer unknown voxels than this
  int discount_looks = 2;          // promises count by the share that this many last looks found of theirs; 0: as they stand
  double variation_voxels = 2;     // complete when the last three promises differ by less (thesis 5.1.2); 0: off
  int most_looks = 12;
  double most_time_s = 600;
};

struct Task {
  std::string name;                // [A-Za-z0-9_.-]{1,40}
  std::string robot;               // robot YAML; its URDF stands beside it under the same name
  std::string scene;               // scene YAML
  std::string object_id;
  object_model::ObjectBox box;     // where the object is looked for, in the world
  double voxel_m = 0.01;
  StopSettings stop;
  std::uint64_t seed = 1;
  std::string motion_mode = "ideal";
  bool truth = true;               // have the simulator publish the truth, for the report only
  int most_forbidden = 10;         // forbidden poses at one look before giving up
  std::map<std::string, std::string> dds;   // service -> fastdds | cyclonedds; "default" for the others
  std::map<std::string, int> instances;     // service -> how many are started; 1 for the others, and only those without state may be more
  std::string output = "runs";     // folder of the run folders

  // Vendor of a service ("vision_server").
  std::string vendor(const std::string& service) const;
  int instances_of(const std::string& service) const;
  // YAML text that parse_task() reads back to the same task.
  std::string yaml() const;
};

// Throws Error(bad_input) with file, line, key and what is expected. Relative paths of robot and scene are resolved against
// `folder` upwards: the folder itself, then each parent (so that a task works from wherever it is run). Without a folder they
// stay as they are and need not exist: the task comes from another computer.
Task parse_task(std::string_view yaml, std::string_view name, const std::optional<std::string>& folder);
Task load_task(const std::string& path);
// As above, from a configuration whose values know their places in the file.
Task read_task(const config::Node& root, const std::optional<std::string>& folder);

}  // namespace periplus::supervisor
