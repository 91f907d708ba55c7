#include "services/vision_server/match_range.h"

#include <algorithm>
#include <cmath>

#include "common/core/error.h"

namespace periplus::vision {

namespace {

constexpr double kSlack = 0.02;  // [m] on both ends: poses and boxes are not exact

// Calls f(p_W) on a grid over the faces of a box of `size` at X_WB.
template <class F>
void on_faces(const Pose& X_WB, const Eigen::Vector3d& size, int steps, F f) {
  for (int axis = 0; axis < 3; ++axis)
    for (int side = -1; side <= 1; side += 2)
      for (int i = 0; i <= steps; ++i)
        for (int j = 0; j <= steps; ++j) {
          Eigen::Vector3d p;
          p[axis] = side * size[axis] / 2;
          p[(axis + 1) % 3] = (static_cast<double>(i) / steps - 0.5) * size[(axis + 1) % 3];
          p[(axis + 2) % 3] = (static_cast<double>(j) / steps - 0.5) * size[(axis + 2) % 3];
          f(X_WB * p);
        }
}

// Full sides of the solid's bounding box in its own frame.
Eigen::Vector3d bounding_size(const scene::Solid& solid) {
  switch (solid.shape) {
    case scene::Shape::cylinder:
      return {solid.size.x(), solid.size.x(), solid.size.z()};
    case scene::Shape::sphere:
      return Eigen::Vector3d::Constant(solid.size.x());
    case scene::Shape::box:
    case scene::Shape::mesh:
      break;
  }
  return solid.size;
}

}  // namespace

DepthRange depth_range(const StereoRig& rig, const Pose& X_WC, const object_model::ObjectBox& box,
                       const scene::Scene* scene, double least_depth, double default_far) {
  const Pose X_CW = X_WC.inverse();
  const Pinhole& camera = rig.camera;
  DepthRange r{1e9, 0};
  on_faces(box.X_WB, box.size, 1, [&](const Eigen::Vector3d& p_W) {
    const double z = (X_CW * p_W).z();
    r.nearest = std::min(r.nearest, z);
    r.farthest = std::max(r.farthest, z);
  });
  require(r.farthest > least_depth, ErrorCode::bad_input,
          "the object's box lies behind the camera; check box and camera pose");
  r.box = std::max(least_depth, r.nearest);
  const auto in_picture = [&](const Eigen::Vector3d& p_C) {
    if (p_C.z() < least_depth) return false;
    const Eigen::Vector2d uv = camera.project(p_C);
    const double margin = 0.03 * camera.width;
    return uv.x() > -margin && uv.y() > -margin && uv.x() < camera.width + margin && uv.y() < camera.height + margin;
  };
  if (scene) {
    for (const scene::Solid& solid : scene->solids)
      on_faces(solid.X_WS, bounding_size(solid), 24, [&](const Eigen::Vector3d& p_W) {
        const Eigen::Vector3d p_C = X_CW * p_W;
        if (in_picture(p_C)) r.nearest = std::min(r.nearest, p_C.z());
      });
    // The floor is nearest at the lower rim of the picture.
    for (double u : {0.0, camera.width - 1.0}) {
      const Eigen::Vector3d ray = X_WC.linear() * camera.back_project(u, camera.height - 1.0, 1);
      if (ray.z() < 0) r.nearest = std::min(r.nearest, -X_WC.translation().z() / ray.z());
    }
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d corner((i & 1 ? 0.5 : -0.5) * scene->room.size.x(), (i & 2 ? 0.5 : -0.5) * scene->room.size.y(),
                                   i & 4 ? scene->room.size.z() : 0);
      r.farthest = std::max(r.farthest, (X_CW * corner).z());
    }
  } else {
    r.farthest = std::max(r.farthest, default_far);
  }
  r.nearest = std::max(least_depth, r.nearest - kSlack);
  r.farthest += kSlack;
  return r;
}

DisparityRange disparity_range(const StereoRig& rig, const DepthRange& depths) {
  const double of_box = rig.disparity(depths.box);
  require(of_box <= kMostDisparity, ErrorCode::vision_no_depth,
          "the object's box has disparities of " + std::to_string(std::lround(std::min(of_box, 1e9))) + " px, at most " + std::to_string(kMostDisparity) +
              " can be matched; send images of less resolution, or look from further away");
  const auto pixels = [&](double z) { return std::min(rig.disparity(z), static_cast<double>(kMostDisparity)); };
  const int least = std::max(0, static_cast<int>(std::floor(pixels(depths.farthest))) - 1);
  const int most = static_cast<int>(std::ceil(pixels(depths.nearest))) + 1;
  return {least, std::max(16, std::min(most - least + 1 + 15, kMostDisparity + 1 - least) / 16 * 16)};
}

}  // namespace periplus::vision
