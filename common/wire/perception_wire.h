// Perceptions, images, calibrations, joint states and poses between the wire and the domain. What comes in is checked
// before it is used: sizes match, numbers are finite and in range, identifiers are identifiers.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/geometry/calibration.h"
#include "common/geometry/image.h"
#include "common/geometry/mosaic.h"
#include "common/object_model/perception.h"
#include "idl/ros2.h"
#include "idl/vision.h"

namespace periplus::wire {

// Throws Error(bad_input, bad_size, not_finite). Depth in [0, 100] m, least depth not behind depth, shapes those of the
// cameras, 1 or 2 depth maps, colour rgb8 of the left camera's size, disparity of that size or none; where it
// is flagged as filled there is a disparity, and the left eye's depth and least depth are 0: guesses do not carve. Descriptors
// have the octets of a known kind, or none.
object_model::Perception from_wire(const msg::Perception& m);
msg::Perception to_wire(const object_model::Perception& p);

// Position and rotation of a pose, row by row. Throws Error(not_finite, bad_input) unless symmetric with no negative variance.
Eigen::Matrix<double, 6, 6> covariance_from_wire(const std::array<double, 36>& m);

// Nanoseconds; Error(bad_input) unless nanosec < 1e9.
std::int64_t stamp_from_wire(const builtin_interfaces::msg::dds_::Time_& t);
builtin_interfaces::msg::dds_::Time_ stamp_to_wire(std::int64_t stamp_ns);

// An image with its stamp. Encodings rgb8 and 8UC3 (taken for bgr, as OpenCV has it), bgr8, rgba8 and bgra8 (alpha dropped) become rgb,
// mono8 and 8UC1 stay grey, bayer_rggb8, _bggr8, _gbrg8 and _grbg8 stay one value a pixel with their mosaic. Throws
// Error(vision_image_bad) with what to send instead for any other encoding, sizes outside 1..8192, mosaics of less than 4 x 4 pixels, and
// data that are not `step * height` octets long. Rows may be padded.
struct StampedImage {
  std::int64_t stamp_ns = 0;
  std::string frame_id;
  ImageU8 image;
  Mosaic mosaic = Mosaic::none;
};
StampedImage from_wire(const sensor_msgs::msg::dds_::Image_& m);
sensor_msgs::msg::dds_::Image_ to_wire(const StampedImage& image);

// Throws Error(vision_image_bad) for numbers that are not finite, sizes outside 1..8192, more than 14 distortion
// coefficients, or a distortion model other than "", plumb_bob and rational_polynomial.
std::pair<std::int64_t, CameraCalibration> from_wire(const sensor_msgs::msg::dds_::CameraInfo_& m);
sensor_msgs::msg::dds_::CameraInfo_ to_wire(std::int64_t stamp_ns, const std::string& frame_id,
                                            const CameraCalibration& calibration);

// Joint positions [rad] by name; at most 1024. Throws Error(bad_size, not_finite, bad_input).
struct StampedJoints {
  std::int64_t stamp_ns = 0;
  std::vector<std::pair<std::string, double>> positions;
};
StampedJoints from_wire(const sensor_msgs::msg::dds_::JointState_& m);
sensor_msgs::msg::dds_::JointState_ to_wire(const StampedJoints& joints);

// Throws Error(not_finite, bad_input).
std::pair<std::int64_t, Pose> from_wire(const geometry_msgs::msg::dds_::PoseStamped_& m);
geometry_msgs::msg::dds_::PoseStamped_ to_wire(std::int64_t stamp_ns, const std::string& frame_id, const Pose& pose);

}  // namespace periplus::wire
