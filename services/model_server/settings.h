// Parameters of the model server; config/default.yaml says what each means.
#pragma once

#include <chrono>
#include <string>

#include "common/core/config.h"
#include "common/object_model/carving.h"
#include "common/object_model/growth.h"
#include "common/object_model/landmarks.h"

namespace periplus::model {

struct ModelSettings {
  std::string store_folder;  // empty: default_store_folder()
  std::chrono::milliseconds perception_wait{2000};
  int perceptions_kept = 8;
  bool ros_topics = true;
  object_model::CarvingSettings carving;
  object_model::GrowthSettings growth;
  object_model::LandmarkSettings landmarks;
};

// Throws Error(bad_input) that names key, line and range.
ModelSettings read_settings(const config::Node& root);

// $XDG_STATE_HOME/periplus/domain-<domain>, or below $HOME/.local/state. Throws Error(bad_input) if neither is set.
std::string default_store_folder(int domain);

}  // namespace periplus::model
