#include "integration-tests/thesis_comparisons/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/core/error.h"

namespace periplus::thesis_comparisons {
namespace {

constexpr double kWidth = 720, kHeight = 400, kLeft = 74, kRight = 16, kTop = 66, kBottom = 54;
// Distinct for the colour-blind as well (Okabe and Ito).
constexpr std::array kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return out;
}

std::string begin(double width, double height, const std::string& title) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"13\" role=\"img\" aria-label=\"{2}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
      "<text x=\"{3:.0f}\" y=\"24\" font-size=\"16\" fill=\"#222\">{2}</text>\n",
      width, height, escape(title), 16.0);
}

// Round numbers that span [low, high] in about five steps.
std::vector<double> ticks(double low, double high, bool logarithmic) {
  std::vector<double> all;
  if (logarithmic) {
    for (double t = std::pow(10, std::floor(std::log10(low))); t <= high * 1.0001; t *= 10) {
      if (t >= low * 0.9999) all.push_back(t);
    }
    return all;
  }
  const double raw = (high - low) / 5, power = std::pow(10, std::floor(std::log10(raw)));
  const double step = (raw / power < 1.5 ? 1 : raw / power < 3.5 ? 2 : raw / power < 7.5 ? 5 : 10) * power;
  for (double t = std::ceil(low / step - 1e-9) * step; t <= high + 1e-9 * step; t += step) all.push_back(std::abs(t) < 1e-12 ? 0 : t);
  return all;
}

struct Scale {
  double low, high, from, to;
  bool logarithmic;
  double operator()(double v) const {
    const auto t = [&](double x) { return logarithmic ? std::log10(x) : x; };
    return from + (to - from) * (t(v) - t(low)) / (t(high) - t(low));
  }
};

Scale scale_of(const std::vector<Series>& series, bool is_x, bool logarithmic, double from, double to) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Series& s : series) {
    for (const double v : is_x ? s.x : s.y) {
      require(std::isfinite(v) && (!logarithmic || v > 0), ErrorCode::bad_input, "a chart's numbers must be finite, and positive on a logarithmic axis");
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  if (low == high) {
    low = logarithmic ? low / 2 : low - 0.5;
    high = logarithmic ? high * 2 : high + 0.5;
  } else if (!logarithmic && !is_x) {
    const double room = 0.05 * (high - low);
    low -= room;
    high += room;
  }
  return {low, high, from, to, logarithmic};
}

}  // namespace

std::string line_chart(const std::string& title, const Axis& x_axis, const Axis& y_axis, const std::vector<Series>& series) {
  require(!series.empty() && series.size() <= kColours.size(), ErrorCode::bad_size, "a chart takes one to six series");
  for (const Series& s : series) {
    require(s.x.size() == s.y.size() && !s.x.empty(), ErrorCode::bad_size, "a series has as many x as y, one at least");
  }
  const Scale x = scale_of(series, true, x_axis.logarithmic, kLeft, kWidth - kRight);
  const Scale y = scale_of(series, false, y_axis.logarithmic, kHeight - kBottom, kTop);
  std::string svg = begin(kWidth, kHeight, title);
  for (const double t : ticks(y.low, y.high, y.logarithmic)) {
    svg += fmt::format("<line x1=\"{0:.0f}\" x2=\"{1:.0f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#ddd\"/><text x=\"{3:.0f}\" y=\"{4:.1f}\" "
                       "text-anchor=\"end\" fill=\"#444\">{5:g}</text>\n",
                       kLeft, kWidth - kRight, y(t), kLeft - 6, y(t) + 4, t);
  }
  for (const double t : ticks(x.low, x.high, x.logarithmic)) {
    svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.0f}\" y2=\"{2:.0f}\" stroke=\"#eee\"/><text x=\"{0:.1f}\" y=\"{3:.0f}\" "
                       "text-anchor=\"middle\" fill=\"#444\">{4:g}</text>\n",
                       x(t), kTop, kHeight - kBottom, kHeight - kBottom + 18, t);
  }
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\" text-anchor=\"middle\" fill=\"#222\">{}</text>\n", (kLeft + kWidth - kRight) / 2, kHeight - 12,
                     escape(x_axis.label));
  svg += fmt::format("<text transform=\"translate(18 {:.0f}) rotate(-90)\" text-anchor=\"middle\" fill=\"#222\">{}</text>\n",
                     (kTop + kHeight - kBottom) / 2, escape(y_axis.label));
  double legend = kLeft;
  for (std::size_t i = 0; i < series.size(); ++i) {
    const Series& s = series[i];
    std::string points;
    for (std::size_t k = 0; k < s.x.size(); ++k) {
      if (s.dots) {
        svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\"/>", x(s.x[k]), y(s.y[k]), kColours[i]);
      } else {
        points += fmt::format("{:.1f},{:.1f} ", x(s.x[k]), y(s.y[k]));
      }
    }
    if (!s.dots) svg += fmt::format("<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"2\" points=\"{}\"/>\n", kColours[i], points);
    svg += fmt::format("<rect x=\"{:.0f}\" y=\"38\" width=\"14\" height=\"4\" fill=\"{}\"/><text x=\"{:.0f}\" y=\"45\" fill=\"#222\">{}</text>\n", legend,
                       kColours[i], legend + 20, escape(s.name));
    legend += 44 + 7.2 * static_cast<double>(s.name.size());
  }
  return svg + "</svg>\n";
}

std::string shaded_table(const std::string& title, const std::string& row_label, const std::vector<std::string>& rows, const std::string& column_label,
                         const std::vector<std::string>& columns, const std::vector<std::vector<double>>& values, int digits) {
  require(!rows.empty() && !columns.empty() && values.size() == rows.size(), ErrorCode::bad_size, "a table has rows and columns, and values for each row");
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& row : values) {
    require(row.size() == columns.size(), ErrorCode::bad_size, "a table has a value for each column");
    for (const double v : row) {
      require(std::isfinite(v), ErrorCode::bad_input, "a table's numbers must be finite");
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  constexpr double kCellWidth = 92, kCellHeight = 32, kHead = 120, kRowHead = 110;
  const double width = kRowHead + kCellWidth * static_cast<double>(columns.size()) + 16, height = kHead + kCellHeight * static_cast<double>(rows.size()) + 16;
  std::string svg = begin(std::max(width, 13 * 0.6 * static_cast<double>(title.size()) + 60), height, title);
  svg += fmt::format("<text x=\"{:.0f}\" y=\"66\" fill=\"#222\">{}</text><text x=\"16\" y=\"102\" fill=\"#222\">{}</text>\n", kRowHead, escape(column_label),
                     escape(row_label));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    svg += fmt::format("<text x=\"{:.0f}\" y=\"102\" text-anchor=\"middle\" fill=\"#444\">{}</text>", kRowHead + kCellWidth * (static_cast<double>(c) + 0.5),
                       escape(columns[c]));
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double y = kHead + kCellHeight * static_cast<double>(r);
    svg += fmt::format("<text x=\"16\" y=\"{:.0f}\" fill=\"#444\">{}</text>", y + 21, escape(rows[r]));
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const double share = high > low ? (values[r][c] - low) / (high - low) : 0.5;
      const auto mix = [&](double from, double to) { return static_cast<int>(std::lround(from + (to - from) * share)); };
      svg += fmt::format("<rect x=\"{:.0f}\" y=\"{:.0f}\" width=\"{:.0f}\" height=\"{:.0f}\" fill=\"#{:02x}{:02x}{:02x}\"/><text x=\"{:.0f}\" y=\"{:.0f}\" "
                         "text-anchor=\"middle\" fill=\"{}\">{:.{}f}</text>\n",
                         kRowHead + kCellWidth * static_cast<double>(c), y, kCellWidth - 2, kCellHeight - 2, mix(237, 8), mix(243, 81), mix(250, 156),
                         kRowHead + kCellWidth * (static_cast<double>(c) + 0.5) - 1, y + 20, share > 0.5 ? "#fff" : "#222", values[r][c], digits);
    }
  }
  return svg + "</svg>\n";
}

}  // namespace periplus::thesis_comparisons
