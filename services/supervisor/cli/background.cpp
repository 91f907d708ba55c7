#include "services/supervisor/cli/background.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <system_error>

#include "common/core/config.h"
#include "common/core/error.h"
#include "services/supervisor/cli/process.h"

namespace periplus::supervisor::cli {
namespace fs = std::filesystem;
namespace {

fs::path record_file(int domain) { return background_folder() / ("domain-" + std::to_string(domain) + ".yaml"); }

}  // namespace

fs::path background_folder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  const fs::path folder = runtime && *runtime && fs::is_directory(runtime) ? fs::path(runtime) / "periplus" : fs::path("/tmp/periplus-" + std::to_string(::getuid()));
  ::mkdir(folder.c_str(), 0700);
  struct stat about {};
  require(::lstat(folder.c_str(), &about) == 0 && S_ISDIR(about.st_mode) && about.st_uid == ::getuid(), ErrorCode::io,
          folder.string() + " is not a folder of this user; remove it or set XDG_RUNTIME_DIR");
  return folder;
}

BackgroundRecord::BackgroundRecord(int domain, const std::string& logs) : file_(record_file(domain)) {
  std::ofstream(file_) << "pid: " << ::getpid() << "\nstart_ticks: " << start_ticks(::getpid()).value_or(0) << "\nlogs: \"" << logs << "\"\n";
}

BackgroundRecord::~BackgroundRecord() {
  std::error_code ignored;
  fs::remove(file_, ignored);
}

std::optional<Background> find_background(int domain) {
  const fs::path file = record_file(domain);
  if (!fs::exists(file)) return std::nullopt;
  try {
    const config::Node node = config::load_file(file);
    Background found;
    found.pid = node.get<int>("pid");
    found.logs = node.get<std::string>("logs");
    const auto ticks = start_ticks(found.pid);
    if (ticks && *ticks == node.get<std::uint64_t>("start_ticks")) return found;
  } catch (const Error&) {
    // half written by a process that was killed: as good as none
  }
  std::error_code ignored;
  fs::remove(file, ignored);
  return std::nullopt;
}

}  // namespace periplus::supervisor::cli
