// The file format `model.periplus`, and the same in parts for a database.
//
// File: the line "PERIPLUS-MODEL 1\n", 64 hexadecimal digits (SHA-256 of the rest), "\n", then a periplus.proto.Model
// (model.proto) with all its views. What is read is hostile until checked: version, checksum, sizes, counts and numbers;
// at most 2^24 voxels, 4096 views and 2 GiB of unpacked arrays, checked before they are unpacked.
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

// In parts: everything but the views, and each view.
std::string write_state(const ObjectModel& model);
std::string write_view(const View& view);
ObjectModel read_parts(std::string_view state, const std::vector<std::string>& views);

}  // namespace periplus::object_model
