// The poses and depth maps of each run, kept so that others may recompute the measures; and the recomputing.
//
//   FOLDER/<set>-<sensor>-<camera>/<object>/
//     samples.npy.gz          float64, n x 8: point, normal (object's frame, metres), 1 if visible from the pose set, 1 if reachable
//     <planner>/run.json      camera, distance, the views' poses (three rows of X_OC: camera in the object's frame), coverages reported
//     <planner>/view-01-left.npy.gz   float32, height x width: depth along the optical axis [m], 0 where there is none; -right with a pair
//
// .npy.gz: numpy.load(gzip.open(name)). Points of the table (run.json, table_m) are no points of the object.
#pragma once

#include <string>
#include <vector>

#include "integration-tests/nbv_benchmark/arena.h"
#include "integration-tests/nbv_benchmark/mask.h"
#include "integration-tests/nbv_benchmark/sensor.h"

namespace periplus::nbv_benchmark {

struct ViewRecord;

// Where the files of one object in one setting stand.
class KeptObject {
 public:
  // Writes the samples. With an empty `root` this and everything below does nothing. Throws Error(io).
  KeptObject(const std::string& root, const std::string& setting, const Subject& subject, const Arena& arena, const Mask& reachable, double distance);
  void add_look(const std::string& planner, int view, const Look& look) const;
  void finish(const std::string& planner, const std::vector<ViewRecord>& views) const;

 private:
  std::string folder_;
  const Arena& arena_;
  double distance_;
};

struct Recomputed {
  int runs = 0, views = 0;
  double largest = 0;                    // difference of a coverage
  std::vector<std::string> differences;  // a sentence for each coverage that is off by more than a sample
};
// All runs below `root`, by another way than the benchmark's: every depth point against a hash of the samples, in the object's
// frame. Throws Error(io | bad_input) for a folder without runs and for damaged files.
Recomputed recompute(const std::string& root);

}  // namespace periplus::nbv_benchmark
