// The file format `model.periplus`, and the same in parts for a database.
//
// File: the line "PERIPLUS-MODEL 4\n", 64 hexadecimal digits (SHA-256 of the rest), "\n", then a periplus.proto.Model
// (model.proto) with all its views. What is read is hostile until checked: version, checksum, sizes, counts and numbers;
// at most 512 voxels a side, 4096 views and 2 GiB of unpacked arrays, checked before they are unpacked.
// The history, which has the time of day, is left to the database: two runs that saw the same write the same file.
// Versions 1 to 3 are read too: of 3, distances stand for every voxel of the bricks it names; of 1 and 2, evidence and distances for every
// voxel of the grid; version 1 kept the left eye's depth alone, and cannot be carved again.
// Errors: bad_input with what is wrong; not_finite; bad_size.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/object_model/object_model.h"

namespace periplus::object_model {

std::string write_model(const ObjectModel& model);
ObjectModel read_model(std::string_view file);
// Throws Error(io) if the file cannot be read; files over 1 GiB are refused.
ObjectModel load_model(const std::string& path);

// In parts: everything but the views, and each view. The state names its views in their order with their checksums; `views` are
// those of write_view(), whose checksums it takes.
std::string write_state(const ObjectModel& model, const std::vector<std::string>& view_sha256);
std::string write_view(const View& view);
// Throws Error(bad_input) too if a view is missing, too many, in another place or not what the state names. Parts of version 1 name none.
ObjectModel read_parts(std::string_view state, const std::vector<std::string>& views);
// Whether a part was written by this version, or by an older one that read_parts() takes.
bool is_current(std::string_view state);

}  // namespace periplus::object_model
