#include "common/robot/names.h"

#include "common/core/config.h"

namespace periplus::robot {

std::string unknown_name(std::string_view kind, std::string_view wanted, const std::vector<std::string>& known) {
  std::string text = "there is no " + std::string(kind) + " '" + std::string(wanted.substr(0, 256)) + "'";
  const std::string nearest = config::nearest(wanted, known);
  if (!nearest.empty()) text += "; did you mean '" + nearest + "'?";
  return text;
}

}  // namespace periplus::robot
