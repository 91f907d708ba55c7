// The model of one object as it is being learnt: occupancy grid, signed distances with colours, and the views with their
// features. A value: copies are independent, so that a caller may integrate into a copy and keep the old one on failure.
//
// World frame W, grid frame G (common/voxel/occupancy_grid.h), optical camera frames C. Metres, pixels.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/object_model/carving.h"
#include "common/object_model/evidence.h"
#include "common/object_model/perception.h"
#include "common/object_model/tsdf.h"
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

// A view that was integrated, with its images as provenance.
struct View {
  std::string view_id;
  std::int64_t stamp_ns = 0;
  StereoRig rig;
  Pose X_WC = Pose::Identity();  // left eye
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double silhouette_valid_share = 0;
  Image<std::uint16_t> depth;    // left eye [0.1 mm]; 0 where there is none, 65535 from 6.5535 m on
  ImageU8 color;                 // rgb
  std::vector<Feature> features;
  Integration result;
};

// The known surroundings as carving and gain need them. Both members may be empty: nothing is known.
struct Surroundings {
  std::string revision;
  std::shared_ptr<const scene::CollisionWorld> collision;
  std::vector<voxel::Occluder> occluders;
};
// The scene's solids as occluders.
std::vector<voxel::Occluder> occluders_of(const scene::Scene& scene);

// Throws Error(bad_input) if a model of this geometry would have more than 2^24 voxels.
void check_voxel_count(const voxel::GridGeometry& geometry);

// Everything that a model consists of; what is stored.
struct ModelState {
  std::string object_id;
  std::string environment_revision;                 // of the surroundings it was begun in
  ObjectBox box;
  voxel::OccupancyGrid grid;
  std::vector<std::uint64_t> known_solids;          // plane: environment before the first look
  Evidence evidence;
  Tsdf tsdf;
  std::vector<std::shared_ptr<const View>> views;   // in the order of integration
};

class ObjectModel {
 public:
  // All unknown but the voxels that touch a known solid, which are environment. `revision` is where counting begins.
  // Throws Error(bad_input): box and voxel size that make no grid, or more than 2^24 voxels.
  ObjectModel(const std::string& object_id, const ObjectBox& box, double voxel_size, const Surroundings& surroundings,
              std::uint32_t revision = 0);
  // Throws Error(bad_input | bad_size) unless the parts fit each other.
  explicit ObjectModel(ModelState state);

  // Carves, labels and attaches the features of one view. A view that was integrated before changes nothing and gives
  // the same answer. Throws Error(bad_size | bad_input | not_finite) and leaves the model as it was.
  Integration integrate(const Perception& perception, const Surroundings& surroundings, const CarvingSettings& settings);

  const ModelState& state() const { return state_; }
  const voxel::OccupancyGrid& grid() const { return state_.grid; }
  // Null if there is no such view.
  std::shared_ptr<const View> view(const std::string& view_id) const;

  // Known, and at least `known_points` depth pixels fell into the voxel itself (not only closely behind it).
  bool is_measured(const Eigen::Vector3i& voxel, const CarvingSettings& settings = {}) const;

  // One feature for each voxel that is still part of the object: the first one that was seen there.
  std::vector<Landmark> landmarks() const;

  // SHA-256 over geometry, planes, and each view's pose and features, in the order of integration. Identifiers, stamps
  // and the revision are left out: two runs that saw the same have the same digest.
  std::string digest() const;

 private:
  ModelState state_;
};

}  // namespace periplus::object_model
