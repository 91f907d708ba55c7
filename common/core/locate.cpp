#include "common/core/locate.h"

#include <cstdlib>
#include <system_error>

#include "common/core/error.h"

namespace periplus {
namespace fs = std::filesystem;
namespace {

std::vector<fs::path> source_trees() {
  std::vector<fs::path> trees;
  for (fs::path at = executable_folder(); at != at.root_path(); at = at.parent_path())
    if (fs::exists(at / "idl" / "periplus" / "common.idl")) trees.push_back(at);
  trees.emplace_back(PERIPLUS_SOURCE_DIR);
  return trees;
}

}  // namespace

fs::path executable_folder() {
  std::error_code problem;
  const fs::path program = fs::read_symlink("/proc/self/exe", problem);
  if (problem) throw Error(ErrorCode::io, "cannot read /proc/self/exe: " + problem.message() + "; mount /proc");
  return program.parent_path();
}

fs::path default_configuration(const std::string& service) {
  std::vector<fs::path> places;
  if (const char* folder = std::getenv("PERIPLUS_CONFIG_DIR"); folder && *folder) places.push_back(fs::path(folder) / (service + ".yaml"));
  places.push_back(executable_folder().parent_path() / "share" / "periplus" / "config" / (service + ".yaml"));
  for (const fs::path& tree : source_trees()) places.push_back(tree / "services" / service / "config" / "default.yaml");
  for (const fs::path& place : places)
    if (fs::is_regular_file(place)) return place;
  return {};
}

std::vector<fs::path> share_folders() {
  std::vector<fs::path> places, found;
  if (const char* folder = std::getenv("PERIPLUS_SHARE_DIR"); folder && *folder) places.emplace_back(folder);
  places.push_back(executable_folder().parent_path() / "share" / "periplus");
  for (const fs::path& tree : source_trees()) places.push_back(tree / "deploy");
  for (const fs::path& place : places)
    if (fs::is_directory(place)) found.push_back(place);
  return found;
}

}  // namespace periplus
