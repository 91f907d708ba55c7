// The knowledge database: environment, and object models with their views, in one SQLite file (write-ahead log). Each
// writing call is one transaction: after a crash the file holds all of it or nothing.
//
// The file belongs to one server at a time; the lock ends with the process, however it ends.
// Errors: model_store, with what to do about it. Not thread-safe.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/object_model/object_model.h"
#include "common/scene/environment_texts.h"

namespace periplus::model {

using scene::EnvironmentTexts;

class KnowledgeStore {
 public:
  // Creates `folder` where needed and opens knowledge.sqlite in it.
  explicit KnowledgeStore(const std::string& folder);
  ~KnowledgeStore();

  void put_environment(const EnvironmentTexts& texts);
  std::optional<EnvironmentTexts> environment() const;

  // A model as it stands, in place of whatever went by its id.
  void put_model(const object_model::ObjectModel& model);
  // The model after one more view, its last.
  void add_view(const object_model::ObjectModel& model);
  // All of them, by id. One that cannot be read is left out and named in `damaged`.
  std::vector<object_model::ObjectModel> models(std::vector<std::string>* damaged = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::model
