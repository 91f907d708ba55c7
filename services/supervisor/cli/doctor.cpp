#include "services/supervisor/cli/doctor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "services/supervisor/cli/launcher.h"
#include "services/supervisor/cli/process.h"
#include "services/supervisor/cli/shared_memory.h"

namespace periplus::supervisor::cli {
namespace fs = std::filesystem;
using Grade = Finding::Grade;

namespace {

constexpr double kMebibyte = 1024.0 * 1024.0;
constexpr double kSharedMemory_MiB = 256;      // eight participants with 16 MiB segments, and room for images
constexpr std::uint64_t kSocketBuffer = 4u << 20;
constexpr double kClockWarning_s = 0.005, kClockBad_s = 0.1;

// A library's own file behind the links, which carries its full version: "libfastrtps.so.2.9.1".
std::string file_of(const fs::path& library) {
  std::error_code problem;
  const fs::path file = fs::canonical(library, problem);
  return problem ? library.string() : file.filename().string();
}

}  // namespace

std::vector<Library> parse_ldd(const std::string& text) {
  std::vector<Library> libraries;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t arrow = line.find(" => ");
    if (arrow == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t");
    std::string path = line.substr(arrow + 4);
    if (const std::size_t bracket = path.find(" ("); bracket != std::string::npos) path.erase(bracket);
    libraries.push_back({line.substr(begin, arrow - begin), path});
  }
  return libraries;
}

std::vector<Finding> check_programs(const fs::path& folder) {
  static constexpr std::array kNamed{"libfastrtps.", "libfastcdr.", "libddsc.", "libmujoco.", "libopencv_core.", "libipopt.",
                                     "libnlopt.", "libfcl.", "liboctomap.", "libassimp.", "libsqlite3.", "libprotobuf."};
  std::vector<Finding> findings;
  std::set<std::string> main_libraries;
  std::vector<std::string> absent;
  for (const std::string& service : service_names()) {
    const fs::path program = folder / program_name(service);
    if (!fs::exists(program)) {
      absent.push_back(program.filename());
      continue;
    }
    const auto text = output_of("/usr/bin/ldd", {program});
    if (!text) {
      findings.push_back({Grade::warning, "libraries", "/usr/bin/ldd did not answer for " + program.string()});
      continue;
    }
    for (const Library& library : parse_ldd(*text)) {
      if (library.path == "not found")
        findings.push_back({Grade::bad, "libraries", program.filename().string() + " lacks " + library.name + "; run deploy/setup.sh or install its package"});
      if (std::any_of(kNamed.begin(), kNamed.end(), [&](const char* prefix) { return library.name.starts_with(prefix); }))
        main_libraries.insert(file_of(library.path));
    }
  }
  if (absent.empty()) {
    findings.push_back({Grade::good, "programs", "all eight services stand in " + folder.string()});
  } else {
    // On a computer of a split system only some of them are installed.
    std::string names;
    for (const std::string& name : absent) names += (names.empty() ? "" : ", ") + name;
    findings.push_back({Grade::warning, "programs", "not in " + folder.string() + ": " + names + "; they must run on another host of the domain"});
  }
  std::string text;
  for (const std::string& name : main_libraries) text += (text.empty() ? "" : ", ") + name;
  if (!text.empty()) findings.push_back({Grade::good, "libraries", text});
  return findings;
}

std::vector<Finding> check_shared_memory(const fs::path& folder) {
  std::vector<Finding> findings;
  const SharedMemorySize size = shared_memory_size(folder);
  const double total = static_cast<double>(size.total_bytes) / kMebibyte, free = static_cast<double>(size.free_bytes) / kMebibyte;
  if (free < kSharedMemory_MiB) {
    findings.push_back({Grade::warning, "shared memory",
                        fmt::format("{:.0f} MiB, {:.0f} free; {:.0f} are wanted: give the container shm_size, or set PERIPLUS_SHM=0", total, free, kSharedMemory_MiB)});
  } else {
    findings.push_back({Grade::good, "shared memory", fmt::format("{:.0f} MiB, {:.0f} free", total, free)});
  }
  const auto leftovers = shared_memory_leftovers(folder);
  if (leftovers.empty()) {
    findings.push_back({Grade::good, "leftovers", "none of killed processes"});
  } else {
    findings.push_back({Grade::warning, "leftovers",
                        fmt::format("{} files of killed processes, such as {}; remove them with `periplus doctor --clean`", leftovers.size(), leftovers.front().string())});
  }
  return findings;
}

std::vector<Finding> check_socket_buffers(const fs::path& sys) {
  std::vector<Finding> findings;
  for (const char* name : {"rmem_max", "wmem_max"}) {
    std::uint64_t limit = 0;
    if (!(std::ifstream(sys / name) >> limit)) {
      findings.push_back({Grade::warning, "socket buffers", std::string(name) + " cannot be read here"});
    } else if (limit < kSocketBuffer) {
      findings.push_back({Grade::warning, "socket buffers",
                          fmt::format("net.core.{0} is {1}; images over UDP want {2}: sysctl -w net.core.{0}={2}", name, limit, kSocketBuffer)});
    } else {
      findings.push_back({Grade::good, "socket buffers", fmt::format("net.core.{} is {}", name, limit)});
    }
  }
  return findings;
}

std::vector<Finding> check_domain(const std::vector<ServiceRow>& rows, int domain) {
  std::vector<Finding> findings;
  std::map<std::string, int> count;
  std::string names;
  for (const ServiceRow& row : rows) {
    if (row.age_s > kSilent_s) {
      findings.push_back({Grade::warning, "domain", row.instance + " was last heard " + fmt::format("{:.0f} s ago", row.age_s)});
      continue;
    }
    ++count[row.service];
    names += (names.empty() ? "" : ", ") + row.instance + " (" + state_name(row) + ")";
    const double off = std::abs(row.clock_ahead_s);
    if (off > kClockWarning_s)
      findings.push_back({off > kClockBad_s ? Grade::bad : Grade::warning, "clocks",
                          fmt::format("the clock of {} ({}) is {:.0f} ms off; run an NTP client (chrony) on both hosts", row.host, row.instance, 1000 * row.clock_ahead_s)});
  }
  findings.push_back({Grade::good, "domain", fmt::format("domain {}: {}", domain, names.empty() ? "nobody" : names)});
  for (const char* unique : {"supervisor", "model_server", "motion_controller", "simulator"})
    if (count[unique] > 1)
      findings.push_back({Grade::bad, "domain", fmt::format("{} of {} are on domain {}; stop all but one, or give each system its own PERIPLUS_DOMAIN", count[unique], unique, domain)});
  return findings;
}

std::string to_text(const std::vector<Finding>& findings) {
  std::string text;
  for (const Finding& f : findings)
    text += fmt::format("{:<4} {:<15} {}\n", f.grade == Grade::good ? "ok" : f.grade == Grade::warning ? "warn" : "BAD", f.what, f.text);
  return text;
}

}  // namespace periplus::supervisor::cli
