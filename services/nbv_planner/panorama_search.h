// Our search: orientation is nearly free (orientation.h), so that only three dimensions are left to search.
//
// 1. Places around the object. From each a panorama lists the visible unknown voxels; a histogram over azimuth and elevation
//    gives the best window, a compass search on the list refines it. Where much is unknown, up to step 4 in a grid of half the
//    resolution.
// 2. Rounds of places around the best ones, each round nearer.
// 3. The best, some distance apart: wide renderings of both eyes, and the orientation on the list of what both see.
// 4. Simplex searches over x, y, z alone, each position with its own orientation; the best of them once more, also from as high
//    as what they look at: a level view shows whole layers of the grid.
// 5. The best are evaluated exactly; from the very best ones simplex searches in all degrees of freedom.
//
// The limits of height, pitch, roll and distance are bounds here: their terms are left out of f_e. Landmarks and forbidden
// poses act on every choice.
#pragma once

#include <cstdint>
#include <functional>

#include "services/nbv_planner/evaluation.h"

namespace periplus::nbv {

struct PlannedView;
struct SearchSettings;
class TaskRunner;

struct PanoramaSettings {
  int positions = 200;         // panoramas of the first stage
  int rounds = 2;              // of perturbation ...
  int kept = 20;               // ... around so many ...
  int each = 4;                // ... places around each
  double radius = 0.18;        // of the first round [m]; each further one 0.55 of it
  int wide = 40;               // places looked at with both eyes
  int starts = 30;             // of the simplex searches over positions
  int position_evaluations = 14;
  int finalists = 8;           // searched again
  int final_evaluations = 18;
  int final_rounds = 1;        // of that, each from half as many with a smaller step
  int exact = 2;               // of the searches in all degrees of freedom
  int exact_evaluations = 34;  // of each
  // With at least so many free faces of unknown voxels all but the last stages look at a grid of half the resolution; with more
  // than five times as many wide, starts and finalists fall in proportion, to half at least. With fewer, renderings take little
  // and what is left is seen from few places: up to four times the positions, twice exact and final_rounds,
  // three times exact_evaluations. Boxes of more than 1.2 m across have up to twice the positions, kept, wide, starts and finalists.
  int much_from = 12000;

  bool operator==(const PanoramaSettings&) const = default;

  static PanoramaSettings fast();
  static PanoramaSettings thorough();
};

// Throws Error(bad_input) naming a number that cannot be.
void check(const PanoramaSettings& settings);

// Budget, threads and time: view_search.h, as are the errors.
PlannedView panorama_search(const Evaluator& evaluator, std::uint64_t seed, const SearchSettings& search, const PanoramaSettings& settings,
                            TaskRunner& runner, const std::function<void(double)>& poll);

}  // namespace periplus::nbv
