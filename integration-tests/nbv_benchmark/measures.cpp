#include "integration-tests/nbv_benchmark/measures.h"

#include <algorithm>
#include <numeric>

namespace periplus::nbv_benchmark {

double area_under(const std::vector<double>& curve) {
  if (curve.empty()) return 0;
  if (curve.size() == 1) return curve.front();
  double sum = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) sum += (curve[i - 1] + curve[i]) / 2;
  return sum / static_cast<double>(curve.size() - 1);
}

std::optional<int> views_to(const std::vector<double>& curve, double level) {
  const auto at = std::find_if(curve.begin(), curve.end(), [&](double c) { return c >= level; });
  if (at == curve.end()) return std::nullopt;
  return static_cast<int>(at - curve.begin()) + 1;
}

std::string views_to_text(const std::vector<double>& curve, const std::vector<std::vector<double>>& all, double level) {
  if (const auto n = views_to(curve, level)) return std::to_string(*n);
  const bool reached = std::any_of(all.begin(), all.end(), [&](const auto& c) { return views_to(c, level).has_value(); });
  return reached ? "> " + std::to_string(curve.size()) : "not reachable";
}

double mean(const std::vector<double>& values) {
  return values.empty() ? 0 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace periplus::nbv_benchmark
