// The terms of the evaluation function over the floor, as in the thesis' Fig. 3.4: the middle between the eyes stands at each place of a
// horizontal grid, at one height, and the pair looks at the object's centre.
#pragma once

#include <string>
#include <vector>

#include "services/nbv_planner/evaluation.h"
#include "services/nbv_planner/tool/canvas.h"
#include "services/nbv_planner/tool/view_picture.h"

namespace periplus::nbv {

struct MapSettings {
  double height = 1.3;      // of the eyes [m]
  double half_width = 2.5;  // from the object's centre along x and y [m]
  double step = 0.05;       // from place to place [m]
  int threads = 2;
};

struct TermMap {
  std::string term;
  std::vector<double> values;  // row by row, y upwards; NaN inside an obstacle or a voxel
};

struct TermMaps {
  int count = 0;               // places along each axis
  Eigen::Vector2d first{0, 0}; // the least x and y [m]
  double step = 0, height = 0;
  double greatest = 0;         // the largest value met on the map: the scale of 3.2.1.5
  std::vector<TermMap> maps;
};

// Every term that a map can show, by the names of Evaluator::terms.
std::vector<std::string> map_terms();

// Throws Error(bad_input): no such term (naming the nearest), a height or width that makes no map, more than 10^6 places.
TermMaps map_terms_around(const Evaluator& evaluator, const std::vector<std::string>& terms, const MapSettings& settings);

// A file whose name ends in .csv: x, y, z and the terms of each place. Otherwise a picture: the object first where there are
// several terms, then each map with its scale. Colours stop at the bounds of the scale, which says so.
void write_maps(const std::string& file, const Evaluator& evaluator, const TermMaps& maps, const std::string& title,
                const std::vector<Pose>& seen_from);

}  // namespace periplus::nbv
