// The comparisons as files: JSON with every figure, charts, and a page that sets the thesis' claims beside them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "integration-tests/nbv_benchmark/report.h"
#include "integration-tests/thesis_comparisons/comparisons.h"

namespace periplus::thesis_comparisons {

enum class Verdict { agrees, in_part, disagrees };
const char* to_string(Verdict verdict);

// What the thesis says, what was found, and whether both agree.
struct Claim {
  std::string section, thesis, here;
  Verdict verdict = Verdict::disagrees;
};
std::vector<Claim> claims(const Comparisons& c);

nlohmann::json to_json(const Comparisons& c, const ComparisonOptions& options, const nbv_benchmark::Provenance& made);

struct Figure {
  std::string file, svg;
};
std::vector<Figure> figures(const Comparisons& c);

// Markdown; the figures stand in `folder`, relative to the page.
std::string page(const Comparisons& c, const ComparisonOptions& options, const nbv_benchmark::Provenance& made, const std::string& folder);

}  // namespace periplus::thesis_comparisons
