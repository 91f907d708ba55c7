// What the model server knows and does, without DDS: environment and object models, in memory and in the knowledge
// database. Every request may be made again: it then gives the same answer and changes nothing.
//
// Thread-safe; requests are served one at a time. Models handed out are immutable.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/object_model/growth.h"
#include "common/object_model/object_model.h"
#include "services/model_server/knowledge_store.h"
#include "services/model_server/settings.h"

namespace periplus::scene {
class CollisionWorld;
struct Scene;
}  // namespace periplus::scene

namespace periplus::model {

// Revision and parsed scene that belong to an environment's texts.
struct KnownTexts {
  EnvironmentTexts texts;
  std::string revision;
  std::shared_ptr<const scene::Scene> scene;
  std::shared_ptr<const scene::CollisionWorld> collision;
};

class ModelKeeper {
 public:
  using Model = std::shared_ptr<const object_model::ObjectModel>;

  // Takes up the models of the store. Its environment comes with set_environment(), parsed by the caller.
  ModelKeeper(const std::string& store_folder, const object_model::CarvingSettings& settings, const object_model::GrowthSettings& growth = {});

  // As the store has it, if it has one. Throws Error(model_store) if it is damaged.
  std::optional<EnvironmentTexts> stored_environment() const;
  void set_environment(const KnownTexts& environment);
  // Throws Error(model_environment_missing) before the first set_environment().
  KnownTexts environment() const;

  // All unknown, or as it stands if it was begun alike, whatever its box has grown to since. `reset` begins it anew with the next revision, unless nothing was
  // seen of it yet. Throws Error(model_environment_missing), Error(model_object_differs) where it was begun with another
  // box, voxel size or environment, Error(bad_input), Error(model_store), without `reset` also where one is stored that cannot be read.
  Model begin(const std::string& object_id, const object_model::ObjectBox& box, double voxel_size, bool reset);

  // True if the view is part of the model already.
  bool has_view(const std::string& object_id, const std::string& view_id) const;
  // Integrates and stores one view; where the object proves larger than its box, the box grows in the same transaction. The answer for a
  // view that is there already is the one of when it was carved last; `perception` may then be null. Throws Error(model_object_unknown),
  // Error(model_environment_missing), Error(model_object_differs) where the object was begun in another environment, Error(model_store) and
  // what ObjectModel::integrate throws; the model is then as before.
  object_model::Integration integrate(const std::string& object_id, const std::string& view_id,
                                      const object_model::Perception* perception);

  // Views with better poses, and without some, from what is stored of them (ObjectModel::revised); stored in one transaction. Poses that
  // are so already and views that were taken out before change nothing. Throws Error(model_object_unknown),
  // Error(model_environment_missing), Error(model_store) and what ObjectModel::revised throws; the model is then as before.
  Model revise(const std::string& object_id, const std::vector<object_model::BetterPose>& better, const std::vector<std::string>& without);

  // Throws Error(model_object_unknown).
  Model model(const std::string& object_id) const;
  std::vector<Model> models() const;

 private:
  // True if it has grown.
  bool grow(object_model::ObjectModel& model, const object_model::Surroundings& around);
  Model find(const std::string& object_id) const;
  object_model::Surroundings surroundings() const;

  object_model::CarvingSettings settings_;
  object_model::GrowthSettings growth_;
  mutable std::mutex mutex_;
  KnowledgeStore store_;
  std::optional<KnownTexts> environment_;
  std::vector<voxel::Occluder> occluders_;
  std::map<std::string, Model> models_;
  std::map<std::string, object_model::RefutedBoxes> refuted_;  // of the same names
};

}  // namespace periplus::model
