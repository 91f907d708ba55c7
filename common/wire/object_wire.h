// The environment and counts of voxels: IDL types of model.idl to domain types and back. What comes in is checked: identifiers, texts
// that parse, and the revision that must be the SHA-256 of the texts. Errors: bad_input, bad_size. Objects: object_chunks.h.
#pragma once

#include <string>
#include <string_view>

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

msg::GridCounts to_wire(const voxel::Counts& counts);
voxel::Counts from_wire(const msg::GridCounts& counts);

}  // namespace periplus::wire
