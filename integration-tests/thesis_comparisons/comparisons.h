// The comparisons of thesis 3.4.1 to 3.4.5, run again.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "integration-tests/thesis_comparisons/local_runs.h"

namespace periplus::thesis_comparisons {

struct ComparisonOptions {
  std::vector<nbv_benchmark::SubjectFile> files;   // fetched objects
  std::size_t generated = 4;                       // so many of the generated ones on top
  std::shared_ptr<const robot::RobotModel> robot;
  double size = 0.5;          // longest side [m], but for the large objects
  int voxels = 64;            // along the box of such an object
  int starts = 3;             // for each object
  int line_steps = 101;       // start poses of Fig. 3.8
  double large_size = 4;      // [m] (3.4.1)
  int large_voxels = 100;
  int large_objects = 3, large_seeds = 2, large_views = 20, large_evaluations = 600;
  std::uint64_t seed = 1;
  int threads = 2;
};

// 3.4.2, Fig. 3.7: one run of NEWUOA for each pair of rhos, both times the object's size.
struct TrustRegion {
  std::vector<double> begin, end;
  int cases = 0;
  // By begin and end: mean of -f_e / largest N_u (at least -1), and mean number of evaluations.
  std::vector<std::vector<double>> quality, evaluations;
};
// 3.4.2, Fig. 3.8: the camera moved along y in front of an object, facing it along x.
struct StartLine {
  std::string object;
  std::vector<double> y, start, once, iterated;   // [m]; f_e
  double mean_runs = 0, share_at_most = 0;        // of ten runs allowed
  double farthest = 0, turned = 0;                // of a start from its result [m, rad]
  // From one start to the next, / largest N_u: the mean and the largest change of f_e at the start, the mean one of what a single
  // run of NEWUOA finds.
  double start_change = 0, largest_start_change = 0, found_change = 0;
};
// 3.4.3: scores and numbers at equal evaluations; quality as above.
struct Sampling {
  int cases = 0;
  int evaluations = 0;                            // mean, of each
  double newuoa = 0, fixed = 0, both = 0;         // mean quality: iterated NEWUOA, fixed sampling, sampling then NEWUOA
  double fixed_similar_or_better = 0;             // share of cases: no worse than NEWUOA by more than 2 % of the largest N_u
  double both_best = 0;                           // share of cases: no worse than the better of the two by as much
  double newuoa_evaluations = 0, local_samples = 0;  // median number to come within 2 % of the minimum that NEWUOA finds: its own, samples
  double not_reached = 0;                         // share of cases where the samples did not suffice
  int most_samples = 0;
};
// 3.4.4 and 3.4.5: single runs from the same starts with the same rhos.
struct Method {
  std::string name;
  double quality = 0;       // mean of -f_free / largest N_u
  double voxels = 0;        // mean N_u / largest N_u
  double evaluations = 0;   // mean
  double within = 0;        // share of results within the limits of height, pitch and roll
  double near_limit = 0;    // share of results in the outer tenth of the height's or pitch's range
};
struct Methods {
  int cases = 0;
  double rho_end = 0;
  std::vector<Method> methods;       // NEWUOA, BOBYQA, Nelder-Mead
  double bobyqa_similar = 0;         // share of cases: N_u within 10 % of NEWUOA's or better
  double fewer_than_newuoa = 0;      // median ratio of evaluations, NEWUOA / BOBYQA
  double bobyqa_better = 0, simplex_better = 0;  // shares of cases, by more than 1 % of the largest N_u
  double simplex_more = 0;           // median ratio of evaluations, simplex / BOBYQA
};
// 3.4.1: an object of some metres modelled with each quantification.
struct LargeRun {
  std::string object, quantification;
  std::uint64_t seed = 0;
  std::vector<double> known;         // share, after each pose, of the surface voxels that any run of this object came to know
  std::vector<double> distance;      // of each pose from the nearest voxel [m]
  int poses_to_90 = 0, poses_to_95 = 0;   // one more than there were poses: not reached
};
struct Quantifications {
  double level = 0;
  std::vector<LargeRun> runs;
};

struct Comparisons {
  std::vector<std::string> objects;
  TrustRegion trust_region;
  std::vector<StartLine> lines;
  Sampling sampling;
  std::vector<Methods> methods;      // for each rho_end
  Quantifications quantifications;
};

using Say = std::function<void(const std::string&)>;
// The same for any number of threads.
Comparisons run_comparisons(const ComparisonOptions& options, const Say& say);

double median(std::vector<double> values);   // of none: 0

}  // namespace periplus::thesis_comparisons
