// Situations recorded from runs, as one file: what the planner was asked after so many looks.
//
// Text lines, each a key and its values, with two kinds of blocks of octets between them:
//   periplus-situations-1
//   situation NAME LOOKS            begins one
//   limits HEIGHT_MIN HEIGHT_MAX PITCH_MIN PITCH_MAX ROLL_MAX DISTANCE_MIN DISTANCE_MAX   [m, rad]
//   body LOWER UPPER                six numbers [m]
//   rig WIDTH HEIGHT FX FY CX CY BASELINE   [px, m]
//   grid VOXEL SX SY SZ X Y Z       axes along the world's, least corner at X Y Z [m]
//   scene OCTETS, newline, a scene YAML
//   planes OCTETS, newline, occupied, known and environment planes, each xor the last situation's of the file where the sizes
//                                   are the same, packed (common/object_model/compression.h)
#pragma once

#include <string>
#include <vector>

#include "services/nbv_planner/situation.h"

namespace periplus::nbv::bench {

struct RecordedSituation {
  std::string name;
  int looks = 0;        // integrated before
  std::string scene;    // YAML
  Situation situation;
};

std::string write_situations(const std::vector<RecordedSituation>& situations);
// Throws Error(bad_input) saying at which octet the file is not what it should be.
std::vector<RecordedSituation> read_situations(const std::string& file);
std::vector<RecordedSituation> load_situations(const std::string& path);

}  // namespace periplus::nbv::bench
