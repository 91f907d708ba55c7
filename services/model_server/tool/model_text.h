// What `periplus model` prints of models.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/object_model/object_model.h"

namespace periplus::model {

// One line a model, with a line of names.
std::string list_text(const std::vector<object_model::ObjectModel>& models);
// Box, grid, counts, each view and the history.
std::string show_text(const object_model::ObjectModel& model);

// Metres, radians, world frame; poses as 3x4 rows.
nlohmann::json list_json(const std::vector<object_model::ObjectModel>& models);
nlohmann::json show_json(const object_model::ObjectModel& model);

}  // namespace periplus::model
