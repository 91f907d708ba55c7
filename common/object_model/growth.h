// An object that is larger than its box: "detect parts of the object going out of the grid and add other occupancy grids where necessary"
// (thesis 5.1.1). All kept depth maps carve the larger grid again, so that the model is the one that the larger box would have
// given from the start.
//
// The object leaves its box where measured voxels at the grid's faces go on outside: through voxels that share a face, an edge or a corner, each
// with enough depth points, none of them on a known solid as far as depth and pose can tell. Views in which too little of the object's
// silhouette has a depth (CarvingSettings::cautious_share) do not count: plain surfaces are matched wrongly. Nor does what another view
// sees through. The grid grows by whole bricks of 8 voxels on each side that is left, so that its voxels stay where they were.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/object_model/object_model.h"

namespace periplus::object_model {

struct GrowthSettings {
  bool enabled = true;
  int least_voxels = 12;     // outside the box that must belong to the object before the grid grows
  int margin_voxels = 4;     // kept free around them
  double least_area = 0.1;   // of a voxel's face, seen frontally, that its points must cover to be gone through [share]

  // Throws Error(bad_input) naming the value and its range.
  void check() const;
  bool operator==(const GrowthSettings&) const = default;
};

struct Growth {
  std::optional<ObjectModel> model;  // in the larger box; nothing if the object stays in its box
  std::string refused;               // why the model does not grow although its object leaves the box; else empty
};

class PointsOutside;

// Larger boxes that the object seemed to need and that its views refuted, carved by all of them, and the points that lie outside: kept from
// one call of grow() to the next, so that such a look adds itself alone, and does not go through all views again. A few octets a voxel
// that was looked at.
struct RefutedBoxes {
  struct Box {
    std::vector<std::shared_ptr<const View>> views;  // of the model, that it was carved by
    std::shared_ptr<const scene::CollisionWorld> collision;
    CarvingSettings carving;
    ModelState carved;                               // without views and signed distances
  };
  RefutedBoxes() = default;
  RefutedBoxes(RefutedBoxes&&) = default;
  RefutedBoxes& operator=(RefutedBoxes&&) = default;

  std::vector<Box> boxes;                            // the last two of the last call that carved
  std::shared_ptr<PointsOutside> points;             // null after growth
};

// Whether the newest view shows the object outside its box; if so, all views say how far. Refused are other surroundings than the object
// was begun in, an imported grid, and views of old versions that kept too little depth. The model itself is left as it is.
// The same to the last bit with `kept` boxes and without.
Growth grow(const ObjectModel& model, const Surroundings& surroundings, const CarvingSettings& carving, const GrowthSettings& settings,
            RefutedBoxes* kept = nullptr);

}  // namespace periplus::object_model
