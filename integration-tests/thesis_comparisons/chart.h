// Charts as SVG texts, made by the program itself: lines over an axis, and a table whose cells are shaded.
#pragma once

#include <string>
#include <vector>

namespace periplus::thesis_comparisons {

struct Series {
  std::string name;
  std::vector<double> x, y;   // as many of each
  bool dots = false;          // single points, not joined
};
struct Axis {
  std::string label;
  bool logarithmic = false;   // of positive numbers alone
};
// Up to six series. Throws Error(bad_size) for series of unlike lengths or none, Error(bad_input) for a number that cannot be drawn.
std::string line_chart(const std::string& title, const Axis& x, const Axis& y, const std::vector<Series>& series);

// `values[row][column]`, each written into its cell; the darker the greater. Errors as above.
std::string shaded_table(const std::string& title, const std::string& row_label, const std::vector<std::string>& rows,
                         const std::string& column_label, const std::vector<std::string>& columns,
                         const std::vector<std::vector<double>>& values, int digits);

}  // namespace periplus::thesis_comparisons
