#include "services/supervisor/cli/run_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace periplus::supervisor::cli {
namespace {

std::string number_or_dash(const RunEvent& event, const std::string& name) {
  const auto at = event.numbers.find(name);
  return at == event.numbers.end() ? "-" : grouped(at->second);
}

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

}  // namespace

std::string grouped(double number) {
  if (!std::isfinite(number)) return "-";
  std::string digits = fmt::format("{:.0f}", std::abs(number));
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) digits.insert(static_cast<std::size_t>(at), " ");
  return (std::round(number) < 0 ? "-" : "") + digits;
}

std::string meaning_of(int exit_status) {
  switch (exit_status) {
    case 0: return "complete";
    case 2: return "bad input";
    case 3: return "looks or time spent";
    case 4: return "no reachable view";
    case 5: return "a service was lost";
    case 6: return "robot fault";
    case 130: return "aborted";
    default: return "failed";
  }
}

std::string RunView::header() {
  return fmt::format("{:>4}  {:>14}  {:>12}  {:>11}  {:>11}  {:>8}  {}\n", "look", "predicted [px]", "found [px]", "known [vx]", "unknown [vx]", "time [s]",
                     "steps [s]");
}

void RunView::close_step(std::int64_t now_ns) {
  if (state_.empty()) return;
  const double seconds = std::max<double>(0, static_cast<double>(now_ns - entered_ns_) * 1e-9);
  const auto again = std::find_if(steps_.begin(), steps_.end(), [this](const auto& step) { return step.first == state_; });
  if (again == steps_.end()) {
    steps_.emplace_back(state_, seconds);
  } else {
    again->second += seconds;
  }
  entered_ns_ = now_ns;
}

std::string RunView::row(const RunEvent& look) const {
  double total = 0;
  std::string steps;
  for (const auto& [state, seconds] : steps_) {
    total += seconds;
    if (seconds >= 0.05) steps += (steps.empty() ? "" : " · ") + spaced(state) + fmt::format(" {:.1f}", seconds);
  }
  return fmt::format("{:>4}  {:>14}  {:>12}  {:>11}  {:>11}  {:>8.1f}  {}\n", look.look, number_or_dash(look, "predicted_gain_px"),
                     number_or_dash(look, "found_gain_px"), number_or_dash(look, "known"), number_or_dash(look, "unknown"), total, steps);
}

std::string RunView::add(const RunEvent& event) {
  look_ = std::max(look_, event.look);
  if (event.kind == "look") {
    close_step(event.wall_time_ns);
    const std::string text = row(event);
    steps_.clear();
    // What is left of this state is writing the look down; it counts for the next row.
    if (!state_.empty()) state_ = "record";
    return text;
  }
  if (event.kind == "note") return "      " + event.text + "\n";
  if (event.kind == "end") {
    ended_ = true;
    return fmt::format("{} ({}){}{}\n", meaning_of(event.exit_status), event.exit_status, event.cause.empty() ? "" : ": ", event.cause);
  }
  close_step(event.wall_time_ns);
  const bool again = std::any_of(steps_.begin(), steps_.end(), [&](const auto& step) { return step.first == event.state; });
  state_ = event.state;
  entered_ns_ = event.wall_time_ns;
  // Going through a state twice between looks is what a person wants to be told of: a forbidden pose, a lost image.
  return again ? fmt::format("      {} again: {}\n", spaced(event.state), event.cause) : "";
}

std::string RunView::under_way(std::int64_t now_ns) const {
  if (state_.empty() || ended_) return "";
  return fmt::format("look {}: {} {:.0f} s", look_, spaced(state_), std::max<double>(0, static_cast<double>(now_ns - entered_ns_) * 1e-9));
}

}  // namespace periplus::supervisor::cli
