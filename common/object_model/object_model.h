// The model of one object as it is being learnt: occupancy grid, signed distances with colours, and the views with their
// features. A value: copies are independent, so that a caller may integrate into a copy and keep the old one on failure.
//
// Of 512 voxels along each side it takes some 180 MB besides the pictures and depth maps of its views (carving_bench, `memory`); in the
// probabilistic mode, which holds log-odds wherever a depth map has reached, some 440 MB.
//
// World frame W, grid frame G (common/voxel/occupancy_grid.h), optical camera frames C. Metres, pixels.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/object_model/carving.h"
#include "common/object_model/evidence.h"
#include "common/object_model/landmarks.h"
#include "common/object_model/log_odds.h"
#include "common/object_model/perception.h"
#include "common/object_model/stored_depth.h"
#include "common/object_model/tsdf.h"
#include "common/voxel/exposed_faces.h"
#include "common/voxel/occupancy_grid.h"
#include "common/voxel/visibility.h"

namespace periplus::scene {
class CollisionWorld;
struct Scene;
}  // namespace periplus::scene

namespace periplus::object_model {

// What integrating one view changed.
struct Integration {
  std::uint32_t revision = 0;
  voxel::Counts counts;
  double found_gain_px = 0;      // unknown pixels that the view's pair sees before, less those after
  double found_gain_voxels = 0;  // unknown voxels before, less after
  bool operator==(const Integration&) const = default;
};

// A view that was integrated, with all that it takes to integrate it again.
struct View {
  std::string view_id;
  std::int64_t stamp_ns = 0;
  StereoRig rig;
  Pose X_WC = Pose::Identity();  // left eye
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double silhouette_valid_share = 0;
  std::vector<StoredDepth> depth;  // left eye; right eye where computed
  ImageU8 color;                 // rgb
  std::vector<Feature> features;
  Integration result;
};

// Where a view was taken from, as it is known better now.
struct BetterPose {
  std::string view_id;
  Pose X_WC = Pose::Identity();  // left eye
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

// What was done to a model, for whoever asks where it comes from.
struct ModelEvent {
  std::int64_t stamp_ns = 0;   // since 1970
  std::string what, detail;    // at most 64 and 256 octets are kept
  std::uint32_t revision = 0;  // after it
  std::string program;         // version
};

// The known surroundings as carving and gain need them. Both members may be empty: nothing is known.
struct Surroundings {
  std::string revision;
  std::shared_ptr<const scene::CollisionWorld> collision;
  std::vector<voxel::Occluder> occluders;
};
// The scene's solids as occluders.
std::vector<voxel::Occluder> occluders_of(const scene::Scene& scene);

// Equal but for rounding.
bool same_box(const ObjectBox& a, const ObjectBox& b);

// Everything that a model consists of; what is stored.
struct ModelState {
  std::string object_id;
  std::string environment_revision;                 // of the surroundings it was begun in
  ObjectBox begun_box;                              // that it was begun with
  ObjectBox box;                                    // the same, or what it has grown to (growth.h)
  voxel::OccupancyGrid grid;
  std::vector<std::uint64_t> known_solids;          // plane: environment before the first look
  Evidence evidence;
  LogOdds log_odds;                                 // nothing is held unless it is carved in the probabilistic mode
  Tsdf tsdf;
  std::vector<std::shared_ptr<const View>> views;   // in the order of integration
  std::vector<ModelEvent> history;                  // the last 4096
  std::optional<CarvingMode> mode;                  // that of its first view; nothing before that
  bool imported = false;                            // the grid says more than the views, and cannot be carved again
};

// Carves, counts and labels with a view's depth maps as ObjectModel::integrate does, and adds its signed distances if `distances`. A
// state without a mode takes that of `settings`; all else of it stays as it is. Marks in `changed` the bricks of which it changes a plane.
void carve(const View& view, const Surroundings& surroundings, const CarvingSettings& settings, bool distances, ModelState& state,
           voxel::BrickMarks* changed = nullptr);

class ObjectModel {
 public:
  // All unknown but the voxels that touch a known solid, which are environment. `revision` is where counting begins.
  // Throws Error(bad_input): box and voxel size that make no grid.
  ObjectModel(const std::string& object_id, const ObjectBox& box, double voxel_size, const Surroundings& surroundings,
              std::uint32_t revision = 0);
  // Throws Error(bad_input | bad_size) unless the parts fit each other.
  explicit ObjectModel(ModelState state);

  // Carves, labels and attaches the features of one view. A view that was integrated before changes nothing and gives
  // the same answer. Throws Error(bad_size | bad_input | not_finite) and leaves the model as it was. An object keeps
  // the mode that its first view was carved in, whatever `settings` say later; so does revised().
  Integration integrate(const Perception& perception, const Surroundings& surroundings, const CarvingSettings& settings);

  // The same object with some views' poses made better and some views left out, carved anew from the depth maps that are kept: as if it had
  // been so from the start. Features move with their views; revisions go on counting. `surroundings` must be those it was begun in.
  // Throws Error(bad_input): a view that is not there or is named twice, a view without kept depth, an imported grid;
  // Error(not_finite); Error(model_object_differs): other surroundings.
  ObjectModel revised(const std::vector<BetterPose>& better, const std::vector<std::string>& without, const Surroundings& surroundings,
                      const CarvingSettings& settings) const;
  // The same object in another box, all views carved anew from the depth maps that are kept: the model that this box would have given from
  // the start, but for its revision, which goes on counting. Throws as revised(), and Error(bad_input) where the box makes no grid.
  ObjectModel within(const ObjectBox& box, const Surroundings& surroundings, const CarvingSettings& settings) const;
  // True if revised() and within() can carve all its views again.
  bool can_be_revised() const;
  // Into the history; stamps and texts change no digest.
  void note(ModelEvent event);

  const ModelState& state() const { return state_; }
  const voxel::OccupancyGrid& grid() const { return state_.grid; }
  // Of this grid, kept from view to view. It stays as it is when the model takes in another view.
  const std::shared_ptr<const voxel::ExposedFaces>& exposed_faces() const { return faces_; }
  // Null if there is no such view.
  std::shared_ptr<const View> view(const std::string& view_id) const;

  // Known, and at least `known_points` depth pixels fell into the voxel itself (not only closely behind it).
  bool is_measured(const Eigen::Vector3i& voxel, const CarvingSettings& settings = {}) const;

  // The landmarks of all views (landmarks.h) that belong to a voxel of the object; one that lies beside its voxel is moved into it.
  std::vector<Landmark> landmarks(const LandmarkSettings& settings = {}, KeptMatches* kept = nullptr) const;

  // SHA-256 over geometry, planes, and each view's pose and features, in the order of integration. Identifiers, stamps
  // and the revision are left out: two runs that saw the same have the same digest.
  std::string digest() const;

 private:
  // No view yet, all else as it is here. Throws as revised().
  ObjectModel begun_again(const ObjectBox& box, const Surroundings& surroundings, const CarvingSettings& settings) const;
  // Carves, labels and appends.
  Integration add(std::shared_ptr<View> view, const Surroundings& surroundings, const CarvingSettings& settings);

  ModelState state_;
  // What follows from state_.grid; copies of the model share it until one of them changes.
  std::shared_ptr<const voxel::ExposedFaces> faces_;
  std::shared_ptr<const voxel::VisibilityScene> scene_;  // that the last look left, for the next; none before the first
};

}  // namespace periplus::object_model
