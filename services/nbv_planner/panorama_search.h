// Our search: orientation is nearly free (orientation.h), so that only three dimensions are left to search.
//
// 1. Places around the object. From each a panorama lists the visible unknown voxels; a histogram over azimuth and elevation
//    gives the best window, a compass search on the list refines it.
// 2. Rounds of places around the best ones, each round nearer.
// 3. The best, some distance apart: wide renderings of both eyes, and the orientation on the list of what both see.
// 4. Simplex searches over x, y, z alone, each position with its own orientation; the best of them once more.
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
  int wide = 30;               // places looked at with both eyes
  int starts = 20;             // of the simplex searches over positions
  int position_evaluations = 7;
  int finalists = 8;           // searched again
  int final_evaluations = 12;
  int final_rounds = 3;        // of that, each from half as many with a smaller step
  int exact = 2;               // of the searches in all degrees of freedom
  int exact_evaluations = 60; // of each
  // With more voxels that have a free face than this, starts, finalists and exact are taken down in proportion, to 0.3 at
  // least; 0: never.
  int full_effort_voxels = 45000;

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
