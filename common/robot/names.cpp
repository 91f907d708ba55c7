#include "common/robot/names.h"

#include <algorithm>
#include <numeric>

namespace periplus::robot {

namespace {
// Levenshtein distance.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}
}  // namespace

std::string nearest_name(std::string_view wanted, const std::vector<std::string>& known) {
  // Long hostile names would cost quadratic time and have no near one.
  if (known.empty() || wanted.size() > 256) return {};
  return *std::min_element(known.begin(), known.end(), [&](const std::string& a, const std::string& b) {
    return edit_distance(wanted, a) < edit_distance(wanted, b);
  });
}

std::string unknown_name(std::string_view kind, std::string_view wanted, const std::vector<std::string>& known) {
  std::string text = "there is no " + std::string(kind) + " '" + std::string(wanted.substr(0, 256)) + "'";
  const std::string nearest = nearest_name(wanted, known);
  if (!nearest.empty()) text += "; did you mean '" + nearest + "'?";
  return text;
}

}  // namespace periplus::robot
