// What a run is judged by, from its coverage after each view.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace periplus::nbv_benchmark {

// Of the visible surface: how many views it takes to get there is told of each.
inline constexpr double kLevels[] = {0.90, 0.95, 0.99};

// Shares 0..1 after view 1, 2, ... : mean of the curve, the area under it from the first view to the last, divided by its
// length (trapezoids). One view: its share. None: 0.
double area_under(const std::vector<double>& curve);

// Number of the first view (from 1) after which the share is at least `level`; nothing if none is.
std::optional<int> views_to(const std::vector<double>& curve, double level);

// As a table tells it: the number; "> N" where this planner did not get there and another one did; "not reachable" where none
// of `all` curves did.
std::string views_to_text(const std::vector<double>& curve, const std::vector<std::vector<double>>& all, double level);

// Least, mean.
double mean(const std::vector<double>& values);

}  // namespace periplus::nbv_benchmark
