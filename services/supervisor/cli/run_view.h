// What a person sees of a run: one row a look, with the time of each step, and what is under way.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace periplus::supervisor::cli {

// periplus/supervisor/event as it came.
struct RunEvent {
  std::string run_id;
  std::uint32_t number = 0;
  std::string kind;                       // state | look | note | end
  std::string state, cause;
  std::uint32_t look = 0;
  std::int64_t wall_time_ns = 0;
  std::map<std::string, double> numbers;
  int exit_status = 0;
  std::string run_folder, text;
};

class RunView {
 public:
  static std::string header();
  // Lines to print for this event, each ending with a newline; empty if it only changes what is under way.
  std::string add(const RunEvent& event);
  // "look 3: walk 4 s", without a newline; empty before the first and after the last event.
  std::string under_way(std::int64_t now_ns) const;

 private:
  std::string row(const RunEvent& look) const;
  void close_step(std::int64_t now_ns);

  std::vector<std::pair<std::string, double>> steps_;   // since the last look: state, seconds
  std::string state_;
  std::int64_t entered_ns_ = 0;
  std::uint32_t look_ = 0;
  bool ended_ = false;
};

// "12 345".
std::string grouped(double number);
// What an exit status means.
std::string meaning_of(int exit_status);

}  // namespace periplus::supervisor::cli
