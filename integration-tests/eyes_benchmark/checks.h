// What the eyes and the carving are held against.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "integration-tests/eyes_benchmark/benchmark.h"

namespace periplus::eyes_benchmark {

struct Check {
  std::string name;        // stereo.bunny.valid, carved.mug.covered, ...
  std::string unit;        // of value and limit
  double value = 0;
  std::string comparison;  // ">=" or "<="
  double limit = 0;
  bool ok = false;
  bool known = true;       // false: there is no such row; then it is not ok either
  bool judged = true;      // false: the value is shown beside its limit, and decides nothing
};

// For the objects asked for. Rich texture:
//   stereo   valid >= 91 %, bad_1 <= 3 %, bad_2 <= 1.3 %, median <= 1.7 mm, p95 <= 7 mm, behind <= 0.01 %, normals (median) <= 10 degrees,
//            textured >= 50 % in every view
//   carved   1 cm: covered (1.5 voxels) >= 98.5 %, mug 96.5; error mean <= 2 mm, p95 <= 5 mm; inside emptied: none; touching emptied <= 0.4 %
//            bunny, 5 mm: covered >= 98 %, error mean <= 1.3 mm
// Mug with its own plain texture: inside emptied <= 0.05 %, textured < 50 % in some view. Time of a pair <= 350 ms, which decides nothing: machines differ.
// `real` pairs: filled map covers >= 95 % (Aloe), 98 % (Motorcycle), bad_2 <= 14, 11 %; over the pixels that ours and plain
// match, bad_2 of ours is at most plain's.
// `features` as configured: place (median) <= 2 mm; turned by 20 degrees >= 95 % of the matches right and >= 40 % of the shared found;
// >= 95 % of the joined landmarks pure.
std::vector<Check> check_limits(const BenchmarkResult& result, const std::vector<std::string>& objects, bool real, bool features);
nlohmann::json to_json(const std::vector<Check>& checks);

}  // namespace periplus::eyes_benchmark
