#include "services/supervisor/whiteboard.h"

#include <cerrno>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "common/core/clock.h"
#include "common/core/error.h"

namespace periplus::supervisor {

std::string iso_time(long long ns) {
  const std::time_t seconds = static_cast<std::time_t>(ns / 1000000000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[40], whole[64];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  std::snprintf(whole, sizeof whole, "%s.%03dZ", text, static_cast<int>(ns / 1000000 % 1000));
  return whole;
}

Whiteboard::Whiteboard(const std::string& path) : file_(std::fopen(path.c_str(), "a")) {
  require(file_ != nullptr, ErrorCode::io, "cannot write " + path + ": " + std::strerror(errno));
}

Whiteboard::~Whiteboard() { std::fclose(file_); }

void Whiteboard::write(const nlohmann::json& line) {
  const std::string text = line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  const bool written = std::fwrite(text.data(), 1, text.size(), file_) == text.size() && std::fflush(file_) == 0;
  require(written, ErrorCode::io, std::string("cannot write the whiteboard: ") + std::strerror(errno));
}

void Whiteboard::entered(const std::string& state, const std::string& cause, int look) {
  const long long now = wall_time_ns();
  write({{"time", iso_time(now)}, {"wall_time_ns", now}, {"state", state}, {"cause", cause}, {"look", look}});
}

void Whiteboard::put(const std::string& key, const nlohmann::json& value) {
  const long long now = wall_time_ns();
  write({{"time", iso_time(now)}, {"wall_time_ns", now}, {"put", key}, {"value", value}});
  values_[key] = value.dump();
}

nlohmann::json Whiteboard::get(const std::string& key) const {
  const auto it = values_.find(key);
  return it == values_.end() ? nlohmann::json() : nlohmann::json::parse(it->second);
}

}  // namespace periplus::supervisor
