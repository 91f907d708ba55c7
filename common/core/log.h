// Structured logs: one JSON object a line in a file, a short line on standard error for people. Levels: trace, debug,
// info, warn, error. Never include spdlog elsewhere.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

namespace periplus::log {

enum class Level { trace, debug, info, warn, error };

struct Options {
  std::string service = "periplus";   // stands in every line
  std::string file;                   // JSON lines are appended here; empty: none
  Level level = Level::info;
  bool console = true;
};

// Call once at start; before, everything from `info` on goes to standard error.
void configure(const Options& options);

// A field of a structured line: name and value as text (use std::to_string or fmt).
using Field = std::pair<std::string_view, std::string>;

void write(Level level, std::string_view message, std::initializer_list<Field> fields = {});
inline void debug(std::string_view m, std::initializer_list<Field> f = {}) { write(Level::debug, m, f); }
inline void info(std::string_view m, std::initializer_list<Field> f = {}) { write(Level::info, m, f); }
inline void warn(std::string_view m, std::initializer_list<Field> f = {}) { write(Level::warn, m, f); }
inline void error(std::string_view m, std::initializer_list<Field> f = {}) { write(Level::error, m, f); }

// Writes out what is buffered.
void flush();

}  // namespace periplus::log
