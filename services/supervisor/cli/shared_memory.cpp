#include "services/supervisor/cli/shared_memory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <set>

namespace periplus::supervisor::cli {
namespace fs = std::filesystem;
namespace {

bool is_process(const fs::path& entry) {
  const std::string name = entry.filename();
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// Names below `folder` that some process has mapped or open.
std::set<std::string> names_in_use(const fs::path& folder, OwnMappings own) {
  const std::string self = std::to_string(::getpid());
  const std::string prefix = folder.string() + "/";
  std::set<std::string> names;
  std::error_code ignored;  // processes come and go while they are read
  for (const fs::directory_entry& process : fs::directory_iterator("/proc", fs::directory_options::skip_permission_denied, ignored)) {
    if (!is_process(process.path()) || (own == OwnMappings::unused && process.path().filename() == self)) continue;
    std::ifstream maps(process.path() / "maps");
    for (std::string line; std::getline(maps, line);) {
      const std::size_t at = line.find(prefix);
      if (at != std::string::npos) names.insert(line.substr(at + prefix.size()));
    }
    for (const fs::directory_entry& file : fs::directory_iterator(process.path() / "fd", fs::directory_options::skip_permission_denied, ignored)) {
      const std::string target = fs::read_symlink(file.path(), ignored).string();
      if (target.starts_with(prefix)) names.insert(target.substr(prefix.size()));
    }
  }
  return names;
}

bool is_locked(const fs::path& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool locked = ::flock(fd, LOCK_EX | LOCK_NB) != 0;
  ::close(fd);
  return locked;
}

// Fast DDS keeps a lock file beside each segment and port; its semaphore belongs to the port.
std::string base_name(std::string name) {
  if (name.starts_with("sem.")) name.erase(0, 4);
  for (const char* suffix : {"_el", "_sl", "_mutex"})
    if (name.ends_with(suffix)) name.erase(name.size() - std::string(suffix).size());
  return name;
}

}  // namespace

std::vector<fs::path> shared_memory_leftovers(const fs::path& folder, OwnMappings own) {
  std::vector<fs::path> candidates;
  std::error_code problem;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, problem)) {
    const std::string name = entry.path().filename();
    struct stat about {};
    if (!(name.starts_with("fastrtps_") || name.starts_with("sem.fastrtps_"))) continue;
    if (::lstat(entry.path().c_str(), &about) != 0 || !S_ISREG(about.st_mode) || about.st_uid != ::getuid()) continue;
    candidates.push_back(entry.path());
  }
  if (candidates.empty()) return candidates;
  std::set<std::string> busy;
  for (const std::string& name : names_in_use(folder, own)) busy.insert(base_name(name));
  for (const fs::path& file : candidates) {
    const std::string name = file.filename();
    if ((name.ends_with("_el") || name.ends_with("_sl")) && is_locked(file)) busy.insert(base_name(name));
  }
  std::erase_if(candidates, [&](const fs::path& file) { return busy.contains(base_name(file.filename())); });
  std::sort(candidates.begin(), candidates.end());
  return candidates;
}

int clean_shared_memory(const fs::path& folder, OwnMappings own) {
  int removed = 0;
  for (const fs::path& file : shared_memory_leftovers(folder, own)) removed += ::unlink(file.c_str()) == 0;
  return removed;
}

SharedMemorySize shared_memory_size(const fs::path& folder) {
  struct statvfs about {};
  if (::statvfs(folder.c_str(), &about) != 0) return {};
  return {static_cast<std::uint64_t>(about.f_blocks) * about.f_frsize, static_cast<std::uint64_t>(about.f_bavail) * about.f_frsize};
}

}  // namespace periplus::supervisor::cli
