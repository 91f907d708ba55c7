#include "common/core/log.h"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <memory>
#include <mutex>

#include "common/core/error.h"
#include "common/core/utf8.h"

namespace periplus::log {
namespace {

struct Sinks {
  Options options;
  std::shared_ptr<spdlog::logger> file, console;
};

std::shared_ptr<spdlog::logger> make_logger(const std::string& name, spdlog::sink_ptr sink) {
  auto logger = std::make_shared<spdlog::logger>(name, std::move(sink));
  logger->set_pattern("%v");
  logger->set_level(spdlog::level::trace);
  // A killed process must leave its last lines behind: no buffering of what a person would look for.
  logger->flush_on(spdlog::level::trace);
  return logger;
}

std::mutex mutex;

std::shared_ptr<const Sinks>& current() {
  static std::shared_ptr<const Sinks> sinks = [] {
    auto first = std::make_shared<Sinks>();
    first->console = make_logger("console", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    return first;
  }();
  return sinks;
}

std::shared_ptr<const Sinks> sinks_now() {
  const std::lock_guard lock(mutex);
  return current();
}

const char* name_of(Level level) {
  constexpr std::array names{"trace", "debug", "info", "warn", "error"};
  return names[static_cast<std::size_t>(level)];
}

spdlog::level::level_enum spdlog_level(Level level) {
  constexpr std::array levels{spdlog::level::trace, spdlog::level::debug, spdlog::level::info, spdlog::level::warn, spdlog::level::err};
  return levels[static_cast<std::size_t>(level)];
}

void append_json_string(std::string& out, std::string_view text) {
  out += '"';
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t n = utf8_length(text.substr(i));
    if (n == 0) {
      out += "\\ufffd";
      ++i;
    } else if (n > 1) {
      out += text.substr(i, n);
      i += n;
    } else {
      const char c = text[i++];
      switch (c) {
        case '"': out += "\\\""; break;
        case '\\': out += "\\\\"; break;
        case '\n': out += "\\n"; break;
        case '\t': out += "\\t"; break;
        case '\r': out += "\\r"; break;
        default:
          if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
            out += fmt::format("\\u{:04x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
          } else {
            out += c;
          }
      }
    }
  }
  out += '"';
}

// UTC with microseconds: "2026-01-31T12:34:56.789012Z".
std::string time_text(std::chrono::system_clock::time_point now) {
  const auto microseconds = std::chrono::duration_cast<std::chrono::microseconds>(now.time_since_epoch()).count();
  const std::time_t seconds = static_cast<std::time_t>(microseconds / 1000000);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:06}Z", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday, parts.tm_hour,
                     parts.tm_min, parts.tm_sec, microseconds % 1000000);
}

bool is_reserved(std::string_view field) {
  constexpr std::array<std::string_view, 5> names{"time", "level", "service", "pid", "message"};
  return std::find(names.begin(), names.end(), field) != names.end();
}

}  // namespace

void configure(const Options& options) {
  auto sinks = std::make_shared<Sinks>();
  sinks->options = options;
  if (!options.file.empty()) {
    std::error_code ignored;  // the sink says why, if the folder cannot be made
    const std::filesystem::path folder = std::filesystem::path(options.file).parent_path();
    if (!folder.empty()) std::filesystem::create_directories(folder, ignored);
    try {
      sinks->file = make_logger("file", std::make_shared<spdlog::sinks::basic_file_sink_mt>(options.file));
    } catch (const spdlog::spdlog_ex& e) {
      throw Error(ErrorCode::io, "cannot write the log file " + options.file + ": " + e.what() + "; choose another with --log-file");
    }
  }
  if (options.console) sinks->console = make_logger("console", std::make_shared<spdlog::sinks::stderr_sink_mt>());
  const std::lock_guard lock(mutex);
  current() = std::move(sinks);
}

void write(Level level, std::string_view message, std::initializer_list<Field> fields) {
  const std::shared_ptr<const Sinks> sinks = sinks_now();
  if (level < sinks->options.level) return;
  const std::string time = time_text(std::chrono::system_clock::now());
  if (sinks->file) {
    std::string line = "{\"time\":\"" + time + "\",\"level\":\"" + name_of(level) + "\",\"service\":";
    append_json_string(line, sinks->options.service);
    line += fmt::format(",\"pid\":{},\"message\":", ::getpid());
    append_json_string(line, message);
    for (const auto& [name, value] : fields) {
      line += ',';
      append_json_string(line, is_reserved(name) ? std::string(name) + "_" : std::string(name));
      line += ':';
      append_json_string(line, value);
    }
    line += '}';
    sinks->file->log(spdlog_level(level), line);
  }
  if (sinks->console) {
    std::string line = time.substr(11, 12) + " " + name_of(level) + " " + sinks->options.service + ": " + std::string(message);
    for (const auto& [name, value] : fields) line += " " + std::string(name) + "=" + value;
    sinks->console->log(spdlog_level(level), line);
  }
}

void flush() {
  const std::shared_ptr<const Sinks> sinks = sinks_now();
  if (sinks->file) sinks->file->flush();
  if (sinks->console) sinks->console->flush();
}

}  // namespace periplus::log
