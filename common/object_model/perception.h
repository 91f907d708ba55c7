// What one look gives: depth, colour, features and the pose of the camera. Made by vision, used by the model.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/object_model/descriptor.h"

namespace periplus::object_model {

// Depth along the optical axis [m]; 0 where there is none.
struct DepthMap {
  Pinhole camera;
  Pose X_WC = Pose::Identity();
  ImageF depth;
  ImageF depth_minimum;   // least depth within the pixel's footprint: what may carve
  ImageF depth_sigma;     // one standard deviation
};

// A visual feature on a surface.
struct Feature {
  float u = 0, v = 0, size = 0, angle = 0;   // [px], [px], [px], [rad]; on the surface: feature_direction.h
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // unit, towards the camera; zero where unknown
  double size_m = 0;                                    // diameter on the surface
  DescriptorKind kind = DescriptorKind::root_sift;
  std::vector<std::uint8_t> descriptor;                 // descriptor_octets(kind), or none
  bool operator==(const Feature&) const = default;
};

struct Perception {
  std::string view_id;
  std::int64_t stamp_ns = 0;
  StereoRig rig;
  Pose X_WC = Pose::Identity();              // left eye
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<DepthMap> depth;               // left eye; right eye where computed
  ImageU8 color;                             // rectified left image, rgb
  ImageF disparity;                          // [px], left eye, filled (Algorithm 2); 0 where there is none. For pictures
  ImageU8 disparity_filled;                  // 255 where `disparity` is a guess: there depth[0] has nothing, and nothing carves; else 0
  std::vector<Feature> features;
  double silhouette_valid_share = 0;         // valid share of the pixels in the box's projection, 0..1
};

// The object's box: where it is looked for.
struct ObjectBox {
  Pose X_WB = Pose::Identity();              // centre
  Eigen::Vector3d size{0, 0, 0};             // full side lengths [m]
};

// A stored feature as the planner sees it.
struct Landmark {
  Eigen::Vector3d p_W, normal_W;
  double size_m = 0;
};

}  // namespace periplus::object_model
