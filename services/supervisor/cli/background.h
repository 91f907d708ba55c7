// One record a domain of the `periplus` process that keeps services running there, so that `periplus down` finds it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

namespace periplus::supervisor::cli {

struct Background {
  pid_t pid = -1;
  std::string logs;         // folder of the services' logs
};

// $XDG_RUNTIME_DIR/periplus or /tmp/periplus-<uid>: this user's own, mode 700. Throws Error(io) if it belongs to someone else.
std::filesystem::path background_folder();

// Written by the keeper itself; removed as this object ends.
class BackgroundRecord {
 public:
  BackgroundRecord(int domain, const std::string& logs);
  ~BackgroundRecord();
  BackgroundRecord(const BackgroundRecord&) = delete;
  BackgroundRecord& operator=(const BackgroundRecord&) = delete;

 private:
  std::filesystem::path file_;
};

// The keeper of a domain if it is alive; a record whose process is gone (or whose number another process got) is removed.
std::optional<Background> find_background(int domain);

}  // namespace periplus::supervisor::cli
