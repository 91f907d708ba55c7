// The whiteboard of thesis 5.2.1: what the states put down for one another, and every state entered, on disk as JSON lines
// (whiteboard.jsonl). Each line is written through before the call returns, so that a crash loses nothing that happened.
#pragma once

#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace periplus::supervisor {

class Whiteboard {
 public:
  // Opens (appends to) `path`; Error(io) if that fails.
  explicit Whiteboard(const std::string& path);
  ~Whiteboard();
  Whiteboard(const Whiteboard&) = delete;
  Whiteboard& operator=(const Whiteboard&) = delete;

  // {"time": ISO 8601, "wall_time_ns", "state", "cause", "look"}.
  void entered(const std::string& state, const std::string& cause, int look);
  // {"time", "wall_time_ns", "put": key, "value"}; replaces what stood there.
  void put(const std::string& key, const nlohmann::json& value);
  // What was put last; null if nothing was.
  nlohmann::json get(const std::string& key) const;

 private:
  void write(const nlohmann::json& line);
  std::FILE* file_;
  std::map<std::string, std::string> values_;
};

// 2026-01-31T12:00:00.123Z.
std::string iso_time(long long wall_time_ns);

}  // namespace periplus::supervisor
