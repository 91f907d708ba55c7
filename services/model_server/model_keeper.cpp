#include "services/model_server/model_keeper.h"

#include <algorithm>
#include <chrono>

#include "common/core/error.h"
#include "common/core/fault_point.h"
#include "common/core/log.h"
#include "common/core/version.h"
#include "common/scene/scene.h"

namespace periplus::model {

namespace {

constexpr const char *kBegun = "begun", *kIntegrated = "view integrated", *kMoved = "view integrated again with a better pose", *kTakenOut = "view taken out", *kGrown = "box grown";

void note(object_model::ObjectModel& model, const char* what, const std::string& detail) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  model.note({std::chrono::duration_cast<std::chrono::nanoseconds>(now).count(), what, detail, model.grid().revision, version()});
}

}  // namespace

ModelKeeper::ModelKeeper(const std::string& store_folder, const object_model::CarvingSettings& settings, const object_model::GrowthSettings& growth)
    : settings_(settings), growth_(growth), store_(store_folder) {
  settings_.check();
  growth_.check();
  std::vector<std::string> damaged;
  for (object_model::ObjectModel& m : store_.models(&damaged)) {
    const std::string id = m.state().object_id;
    models_[id] = std::make_shared<const object_model::ObjectModel>(std::move(m));
  }
  for (const std::string& what : damaged) log::warn("a stored model cannot be read and is left out", {{"model", what}});
}

std::optional<EnvironmentTexts> ModelKeeper::stored_environment() const {
  std::lock_guard lock(mutex_);
  return store_.environment();
}

void ModelKeeper::set_environment(const KnownTexts& environment) {
  require(environment.scene && environment.collision, ErrorCode::internal, "an environment comes with its scene");
  auto occluders = object_model::occluders_of(*environment.scene);
  std::lock_guard lock(mutex_);
  store_.put_environment(environment.texts);
  environment_ = environment;
  occluders_ = std::move(occluders);
}

KnownTexts ModelKeeper::environment() const {
  std::lock_guard lock(mutex_);
  require(environment_.has_value(), ErrorCode::model_environment_missing, "no environment is known yet; send one with model/set_environment");
  return *environment_;
}

object_model::Surroundings ModelKeeper::surroundings() const {
  require(environment_.has_value(), ErrorCode::model_environment_missing, "no environment is known yet; send one with model/set_environment");
  return {environment_->revision, environment_->collision, occluders_};
}

ModelKeeper::Model ModelKeeper::find(const std::string& object_id) const {
  const auto it = models_.find(object_id);
  require(it != models_.end(), ErrorCode::model_object_unknown, "no object goes by the name " + object_id + "; begin it with model/begin");
  return it->second;
}

ModelKeeper::Model ModelKeeper::begin(const std::string& object_id, const object_model::ObjectBox& box, double voxel_size, bool reset) {
  std::lock_guard lock(mutex_);
  const object_model::Surroundings around = surroundings();
  std::uint32_t revision = 0;
  std::string replaced;
  if (const auto it = models_.find(object_id); it != models_.end()) {
    const object_model::ModelState& old = it->second->state();
    const bool alike = object_model::same_box(old.begun_box, box) && std::abs(old.grid.geometry().voxel_size - voxel_size) < 1e-12 &&
                       old.environment_revision == around.revision;
    if (alike && (!reset || old.views.empty())) return it->second;
    require(alike || reset, ErrorCode::model_object_differs,
            "object " + object_id + " was begun with another box, voxel size or environment; ask with reset to begin it anew");
    // Counting goes on, so that no reader takes the new grid for an old one.
    revision = old.grid.revision + 1;
    if (!old.views.empty()) {
      replaced = ", in place of revision " + std::to_string(old.grid.revision) + " of " + std::to_string(old.views.size()) + " views";
      log::warn("an object is begun anew: what was kept of it goes", {{"object", object_id},
                                                                    {"revision", std::to_string(old.grid.revision)},
                                                                    {"views", std::to_string(old.views.size())}});
    }
  } else if (!reset) {
    // One that is stored and cannot be read may be saved yet, by hand or by a newer version.
    try {
      store_.model(object_id);
    } catch (const Error& e) {
      throw_error(ErrorCode::model_store, std::string(e.what()) + "; choose another name, delete it (periplus model delete), or ask with reset to begin it anew in its place");
    }
  }
  auto model = std::make_shared<object_model::ObjectModel>(object_id, box, voxel_size, around, revision);
  note(*model, kBegun, "environment " + around.revision + replaced);
  store_.put_model(*model);
  models_[object_id] = model;
  refuted_.erase(object_id);
  return model;
}

bool ModelKeeper::has_view(const std::string& object_id, const std::string& view_id) const {
  std::lock_guard lock(mutex_);
  return find(object_id)->view(view_id) != nullptr;
}

object_model::Integration ModelKeeper::integrate(const std::string& object_id, const std::string& view_id,
                                                 const object_model::Perception* perception) {
  std::lock_guard lock(mutex_);
  const Model old = find(object_id);
  if (const auto before = old->view(view_id)) return before->result;
  fault_point("keeper.asked");
  const object_model::Surroundings around = surroundings();
  // Carved with other solids, it could never be carved again from its views.
  require(old->state().imported || old->state().environment_revision == around.revision, ErrorCode::model_object_differs,
          "object " + object_id + " was begun in another environment; set that one to integrate views of it, or ask with reset to begin it anew");
  require(perception != nullptr && perception->view_id == view_id, ErrorCode::model_perception_not_here,
          "the perception of view " + view_id + " is not here; have vision/process publish it again");
  auto next = std::make_shared<object_model::ObjectModel>(*old);
  fault_point("keeper.copied");
  next->integrate(*perception, around, settings_);
  note(*next, kIntegrated, view_id);
  fault_point("keeper.integrated");
  if (grow(*next, around))
    store_.put_model(*next);
  else
    store_.add_view(*next);
  fault_point("keeper.stored");
  models_[object_id] = next;
  return next->view(view_id)->result;
}

bool ModelKeeper::grow(object_model::ObjectModel& model, const object_model::Surroundings& around) {
  object_model::Growth growth = object_model::grow(model, around, settings_, growth_, &refuted_[model.state().object_id]);
  if (!growth.refused.empty()) log::warn("the model does not grow", {{"object", model.state().object_id}, {"reason", growth.refused}});
  if (!growth.model) return false;
  const auto text = [](const voxel::GridGeometry& g) {
    return std::to_string(g.size.x()) + " x " + std::to_string(g.size.y()) + " x " + std::to_string(g.size.z()) + " voxels";
  };
  const std::string change = text(model.grid().geometry()) + " to " + text(growth.model->grid().geometry());
  model = std::move(*growth.model);
  note(model, kGrown, change);
  log::info("the object leaves its box, which grows", {{"object", model.state().object_id}, {"from_to", change}});
  fault_point("keeper.grown");
  return true;
}

ModelKeeper::Model ModelKeeper::revise(const std::string& object_id, const std::vector<object_model::BetterPose>& better,
                                       const std::vector<std::string>& without) {
  std::lock_guard lock(mutex_);
  const Model old = find(object_id);
  std::vector<object_model::BetterPose> moved;
  for (const object_model::BetterPose& b : better) {
    const auto view = old->view(b.view_id);
    if (!view || view->X_WC.matrix() != b.X_WC.matrix() || view->covariance != b.covariance) moved.push_back(b);
  }
  std::vector<std::string> gone;
  for (const std::string& id : without) {
    const auto& history = old->state().history;
    const bool before = std::any_of(history.begin(), history.end(), [&](const auto& e) { return e.what == kTakenOut && e.detail == id; });
    if (old->view(id) || !before) gone.push_back(id);
  }
  if (moved.empty() && gone.empty()) return old;
  auto next = std::make_shared<object_model::ObjectModel>(old->revised(moved, gone, surroundings(), settings_));
  for (const auto& b : moved) note(*next, kMoved, b.view_id);
  for (const std::string& id : gone) note(*next, kTakenOut, id);
  grow(*next, surroundings());
  store_.put_model(*next);
  models_[object_id] = next;
  return next;
}

ModelKeeper::Model ModelKeeper::model(const std::string& object_id) const {
  std::lock_guard lock(mutex_);
  return find(object_id);
}

std::vector<ModelKeeper::Model> ModelKeeper::models() const {
  std::lock_guard lock(mutex_);
  std::vector<Model> out;
  for (const auto& [id, m] : models_) out.push_back(m);
  return out;
}

}  // namespace periplus::model
