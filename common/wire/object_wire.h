// Object grids and the environment: IDL types of model.idl to domain types and back. What comes in is checked before
// anything is allocated from it: identifiers, poses, sizes of planes, finite landmarks, texts that parse, and the
// revision that must be the SHA-256 of the texts. Errors: bad_input, bad_size, not_finite.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/object_model/perception.h"
#include "common/scene/environment_texts.h"
#include "common/voxel/occupancy_grid.h"
#include "common/wire/knowledge.h"
#include "idl/model.h"

namespace periplus::wire {

// SHA-256 (64 hexadecimal digits) of the three texts, each preceded by its length.
std::string environment_revision(std::string_view scene_yaml, std::string_view robot_yaml, std::string_view robot_urdf);

// SHA-256 of what a robot's driver knows of it: the scene's text without `truth`, and the robot's texts.
std::string scene_revision(std::string_view scene_yaml);
std::string robot_revision(std::string_view robot_yaml, std::string_view robot_urdf);

// Fills in the revision. Removes nothing: give a scene without `truth` (scene::without_truth).
msg::Environment environment_to_wire(std::string_view scene_id, std::string_view scene_yaml, std::string_view robot_yaml,
                                     std::string_view robot_urdf);
msg::Environment environment_to_wire(const scene::EnvironmentTexts& texts);
scene::EnvironmentTexts texts_from_wire(const msg::Environment& environment);
// Parses the scene and loads the robot. An empty revision is filled in, a wrong one refused.
KnownEnvironment environment_from_wire(const msg::Environment& environment);

// Of more views than this the last ones go on the wire.
inline constexpr std::size_t kViewsOnWire = 1024;

// `views`: left eyes X_WC, in the order of integration.
msg::ObjectGrid object_to_wire(std::string_view object_id, const voxel::OccupancyGrid& grid,
                               const std::vector<object_model::Landmark>& landmarks, const std::vector<Pose>& views = {});
KnownObject object_from_wire(const msg::ObjectGrid& object);

msg::GridCounts to_wire(const voxel::Counts& counts);
voxel::Counts from_wire(const msg::GridCounts& counts);

}  // namespace periplus::wire
