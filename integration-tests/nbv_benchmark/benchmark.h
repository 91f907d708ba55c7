// The benchmark itself: objects x settings x planners, each from the same first view.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "integration-tests/nbv_benchmark/arena.h"
#include "integration-tests/nbv_benchmark/planners.h"
#include "integration-tests/nbv_benchmark/reconstruction.h"
#include "integration-tests/nbv_benchmark/sensor.h"
#include "integration-tests/nbv_benchmark/subject.h"

namespace periplus::nbv_benchmark {

// Where, with what and by whom.
struct Setting {
  PoseSet set = PoseSet::free;
  SensorKind sensor = SensorKind::ideal;
  Camera camera = Camera::single;
  std::vector<std::string> planners;
  std::string name() const;   // "free/ideal/single"
};

struct BenchmarkOptions {
  std::vector<SubjectFile> objects;
  std::vector<Setting> settings;
  SubjectOptions subject;
  int views = 12;
  int candidates = 400;
  std::uint64_t seed = 1;
  int threads = 2;
  double distance = 0.005;                   // of the coverage by distance [m]
  // By camera: a voxel is known when a depth point fell into it, or some closely behind it; and the planner counts those that
  // it will see so well. Few where a voxel is only two or three pixels wide.
  struct Resolution {
    int known_points = 3, seen_points = 10, more_than_pixels = 2;
  };
  Resolution single{1, 3, 0}, pair{3, 10, 2};
  nbv::EvaluationSettings evaluation;        // but for more_than_pixels
  nbv::SearchSettings search;                // but for threads
  // Other parameters for the planners `ours:NAME` and `search:NAME`, so that a choice is compared within one run.
  struct Variant {
    nbv::EvaluationSettings evaluation;
    nbv::SearchSettings search;
  };
  std::map<std::string, Variant> variants;
  nbv::GainSettings gain;                    // of the literature
  std::shared_ptr<const robot::RobotModel> robot;
  std::string keep_folder;                   // poses and depth maps of each run; empty: not kept
  std::string record_folder;                 // a model file for each plan of `ours` and `search`; empty: none
};

struct ViewRecord {
  int candidate = -1;
  Pose X_OC = Pose::Identity();              // left eye, in the object's frame
  double all = 0, visible = 0, reachable = 0;          // coverage by distance: of all samples, of those that the set sees, that the robot can reach
  double voxels_all = 0, voxels_visible = 0;           // coverage by voxel
  double unknown = 0;                                  // unknown voxels left
  double predicted = 0;                                // of this view, before it
  double travel = 0;                                   // so far [m]
  double plan_seconds = 0, look_seconds = 0, model_seconds = 0;   // on one processor, one thread
};

struct Run {
  std::string object, planner;
  std::vector<ViewRecord> views;
  double error_mean = 0, error_p95 = 0;      // of the depth maps' points to the true surface [m]
};

struct ObjectResult {
  std::string object;
  std::string sha256;
  std::size_t triangles = 0, samples = 0, voxels = 0;
  int candidates = 0;
  double visible_share = 0, reachable_share = 0;       // of all samples
  std::vector<Run> runs;                     // in the order of Setting::planners
};

struct SettingResult {
  Setting setting;
  std::vector<ObjectResult> objects;         // in the order of BenchmarkOptions::objects
};

struct BenchmarkResult {
  std::vector<SettingResult> settings;
  double seconds = 0;                        // wall time of everything
};

// `progress` is called with a sentence after each object and setting, from any thread, one at a time.
// The same result for any number of threads, but for seconds. Throws Error with the object's name.
BenchmarkResult run_benchmark(const BenchmarkOptions& options, const std::function<void(const std::string&)>& progress = {});

}  // namespace periplus::nbv_benchmark
