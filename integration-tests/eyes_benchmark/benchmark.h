// All rows of the benchmark of the eyes; README.md says what each is.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/object_model/carving.h"
#include "integration-tests/eyes_benchmark/feature_measures.h"
#include "integration-tests/eyes_benchmark/label_measures.h"
#include "integration-tests/eyes_benchmark/model_measures.h"
#include "integration-tests/eyes_benchmark/stage.h"
#include "integration-tests/eyes_benchmark/stereo_measures.h"
#include "services/vision_server/perceive.h"

namespace periplus::eyes_benchmark {

struct BenchmarkOptions {
  vision::PerceiveSettings perceive;        // the product's
  object_model::CarvingSettings carving;    // the product's
  SensorSettings sensor;
  double longest_side = 0.5;                // of the objects [m]
  std::vector<std::string> objects = {"bunny", "elephant", "triceratops", "mug"};
  int threads = 2;                          // of OpenCV; results do not depend on it
  int repeats = 3;                          // of each timing
  std::size_t surface_samples = 60000;      // for coverage
  std::size_t touching_samples = 800000;    // for the voxels that the surface passes through
  double wrong_share = 0.2;                 // of the matched pixels, replaced by any disparity of the range
  double wrong_pose_m = 0.02;               // of one view, along (1, 1, 1) of its camera's frame
  std::vector<double> turns = {10, 20, 30, 60};  // of views whose features are matched with those of a first one [degrees]
  bool features = true;                     // places, matches and landmarks by kind of feature
  bool real = true;                         // Aloe and Motorcycle
  std::string pictures;                     // folder for pictures; empty: none
};

struct StereoRow {
  std::string object, paint;
  StereoQuality ours, plain;                // left eye, six views
  StereoQuality filled;                     // ours with its guesses (Algorithm 2), which never carve
  Spread normals;                           // angle to the true normal [rad]
  double normals_share = 0;                 // of the pixels with a depth that have a normal
  double textured = 0, shown_valid = 0;     // textured share and silhouette_valid_share, least of the views
  int refused = 0;                          // views without a perception
  double seconds = 0, plain_seconds = 0;    // of a pair, median: all of perceive(); plain matching of the left eye alone
  double processor_seconds = 0;             // of all threads together, of perceive(), median: little changed by what else the machine does
  std::vector<std::pair<std::string, double>> steps;  // of perceive(), medians
};

struct ModelRow {
  std::string object, paint, source;        // source: one of the names below
  double voxel_m = 0.01;
  object_model::CarvingMode mode = object_model::CarvingMode::conservative;
  ModelQuality quality;
  LabelQuality labels;
  double seconds = 0;                       // to integrate six views
};
inline constexpr const char* kStereo = "stereo";
inline constexpr const char* kTrueDepth = "true depth";
inline constexpr const char* kWrongDisparities = "stereo, wrong disparities";
inline constexpr const char* kWrongPose = "stereo, one wrong pose";

// Rich texture; the first view and those turned by BenchmarkOptions::turns.
struct FeatureRow {
  std::string object, detector, selection;  // names as in the vision server's configuration
  bool chosen = false;                      // what the configuration has
  double features = 0;                      // mean of a view
  Spread place;                             // distance from the true place along the ray [m]
  std::vector<MatchQuality> turns;
  LandmarkQuality landmarks;                // of all these views
  double seconds = 0;                       // to find the features of a pair, median
};

struct RealRow {
  std::string name, source;
  int first_column = 0;                     // numDisparities: further left plain matching finds nothing
  DisparityQuality ours, plain;
  DisparityQuality filled;                  // ours with its guesses (Algorithm 2)
  DisparityQuality ours_where_both, plain_where_both;  // over the pixels that ours and plain match
  double seconds = 0, plain_seconds = 0, filling_seconds = 0;
};

struct BenchmarkResult {
  std::vector<StereoRow> stereo;
  std::vector<ModelRow> models;
  std::vector<FeatureRow> features;
  std::vector<RealRow> real;
  double seconds = 0;
};

// Names of a row's pictures below BenchmarkOptions::pictures: <name>_depth.png, <name>_error.png, of the first view.
std::string model_picture(const ModelRow& row);
const char* to_string(object_model::CarvingMode mode);

// Same options, same result but for times. `say` is told of progress.
BenchmarkResult run_benchmark(const BenchmarkOptions& options, const std::function<void(const std::string&)>& say);

}  // namespace periplus::eyes_benchmark
