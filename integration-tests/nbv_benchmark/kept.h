// The poses and depth maps of each run, kept so that others may recompute the measures; and the recomputing.
//
//   FOLDER/<set>-<sensor>-<camera>/<object>/<planner>/
//     run.json              cameras, the views' poses (rows of X_OC: camera in the object's frame, metres), measures as reported
//     view-01-left.npy.gz   depth along the optical axis [m], float32, 0 where there is none; and -right with a pair
//   FOLDER/<set>-<sensor>-<camera>/<object>/samples.npz.. see samples.npy.gz
//     samples.npy.gz        float64, n x 8: point, normal (object's frame), visible from the pose set 0/1, reachable by the robot 0/1
#pragma once

#include <string>
#include <vector>

#include "integration-tests/nbv_benchmark/arena.h"
#include "integration-tests/nbv_benchmark/sensor.h"

namespace periplus::nbv_benchmark {

struct Setting;
struct ViewRecord;
struct Run;

// Writes one run. With an empty folder everything is a no-op.
class KeptRun {
 public:
  KeptRun(const std::string& folder, const Setting& setting, const Arena& arena, const Subject& subject, const std::string& planner);
  void add(const ViewRecord& record, const Look& look);
  void finish(const Run& run);

 private:
  std::string folder_;
};

}  // namespace periplus::nbv_benchmark
