// The knowledge database: environment, and object models with their views, in one SQLite file (write-ahead log). Each
// writing call is one transaction: after a crash the file holds all of it or nothing, after a power cut too. Every part has a
// SHA-256: a model's state names its views with theirs, so that nothing of it can be changed, lost or put in another place unnoticed.
//
// One process at a time writes; its lock (on knowledge.lock) ends with it, however it ends. Others may read meanwhile.
// What an older version wrote is brought to this one's form when it is opened for writing, in one transaction.
// Errors: model_store, with what to do about it. Not thread-safe.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/object_model/object_model.h"
#include "common/scene/environment_texts.h"

namespace periplus::model {

using scene::EnvironmentTexts;

// Error(model_store) of a database of which nothing can be read any more.
class DamagedDatabase : public Error {
 public:
  explicit DamagedDatabase(const std::string& message) : Error(ErrorCode::model_store, message) {}
};

class KnowledgeStore {
 public:
  enum class Access { write, read };

  // knowledge.sqlite in `folder`. For writing both are created where needed; for reading they must be there, and may be read-only.
  explicit KnowledgeStore(const std::string& folder, Access access = Access::write);
  ~KnowledgeStore();

  // Writes nothing where it is kept so already.
  void put_environment(const EnvironmentTexts& texts);
  // Nothing if there is none; throws Error(model_store) if it is damaged.
  std::optional<EnvironmentTexts> environment() const;

  // A model as it stands, in place of whatever went by its id.
  void put_model(const object_model::ObjectModel& model);
  // The model after one more view, its last.
  void add_view(const object_model::ObjectModel& model);
  // False if there was none.
  bool remove_model(const std::string& object_id);
  // All of them, by id. One that cannot be read is left out and named in `damaged`.
  std::vector<object_model::ObjectModel> models(std::vector<std::string>* damaged = nullptr) const;
  // Nothing if there is none; throws Error(model_store) if it is damaged.
  std::optional<object_model::ObjectModel> model(const std::string& object_id) const;

  // What is damaged, a sentence each: the file's structure, checksums, contents, and whether each grid is the one that its last view gave.
  std::vector<std::string> verify() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::model
