// IDL types of common.idl to domain types and back. What comes in is checked: finite, unit quaternion (to 1e-3, then
// normalised), sane sizes, identifiers [A-Za-z0-9_.-]{1,64}; otherwise Error(not_finite | bad_input | bad_size).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/object_model/perception.h"
#include "idl/common.h"

namespace periplus::wire {

Eigen::Vector3d from_wire(const msg::Vec3& v);
Pose from_wire(const msg::Pose& X);
Pose2 from_wire(const msg::Pose2& X);
Pinhole from_wire(const msg::Pinhole& c);
StereoRig from_wire(const msg::StereoRig& r);
object_model::ObjectBox from_wire(const msg::Box& b);

msg::Vec3 to_wire(const Eigen::Vector3d& v);
msg::Pose to_wire(const Pose& X);
msg::Pose2 to_wire(const Pose2& X);
msg::Pinhole to_wire(const Pinhole& c);
msg::StereoRig to_wire(const StereoRig& r);
msg::Box to_wire(const object_model::ObjectBox& b);
msg::NamedNumber named(std::string_view name, double value);

// `what` names the field in the error. May be empty only where `optional`.
std::string id_from_wire(const msg::Id& id, const char* what, bool optional = false);
// Throws Error(bad_input) unless `id` is an identifier.
void check_id(std::string_view id, const char* what);

// UTF-8 texts in octet sequences.
std::string text_from_wire(const std::vector<std::uint8_t>& octets);
std::vector<std::uint8_t> text_to_wire(std::string_view text);

// All finite, else Error(not_finite) naming `what`; a size other than `size` (if >= 0) is Error(bad_size).
Eigen::VectorXd vector_from_wire(const std::vector<double>& v, const char* what, int size = -1);
std::vector<double> vector_to_wire(const Eigen::VectorXd& v);

}  // namespace periplus::wire
