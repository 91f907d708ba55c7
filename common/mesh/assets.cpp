#include "common/mesh/assets.h"

#include <cstdlib>
#include <filesystem>

#include "common/core/error.h"

namespace periplus::mesh {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

std::string assets_folder() {
  if (const std::string own = variable("PERIPLUS_ASSETS"); !own.empty()) return own;
  std::string cache = variable("XDG_CACHE_HOME");
  if (cache.empty()) cache = variable("HOME") + "/.cache";
  return cache + "/periplus/assets";
}

std::string find_asset(const std::string& name, const std::vector<std::string>& folders) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path path(name);
  if (path.is_absolute()) {
    require(fs::is_regular_file(path, error), ErrorCode::io, name + ": there is no such file");
    return name;
  }
  std::vector<std::string> all = folders;
  all.push_back(assets_folder());
  std::string searched;
  for (const std::string& folder : all) {
    const fs::path candidate = fs::path(folder) / path;
    if (fs::is_regular_file(candidate, error)) return candidate.string();
    searched += (searched.empty() ? "" : ", ") + folder;
  }
  throw_error(ErrorCode::io, name + ": not found in " + searched + "; deploy/fetch-assets.sh fetches the files of the scenes");
}

}  // namespace periplus::mesh
