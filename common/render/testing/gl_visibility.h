// Visibility by OpenGL, as a second reference of common/voxel's kernel and as what it is measured against: all free faces of the
// grid are drawn with their voxel's number as colour, the picture is read back and counted.
#pragma once

#include <memory>

#include "common/render/gl_context.h"
#include "common/voxel/testing/ray_caster.h"
#include "common/voxel/visibility.h"

namespace periplus::render {

class GlVisibility {
 public:
  // Draws into a frame buffer of its own, at most `width` x `height`. The context must outlive it. Solids outside the grid are left out.
  // Throws Error(sim_render_failed) if OpenGL lacks what is needed.
  GlVisibility(const GlContext& context, const voxel::OccupancyGrid& grid, int width, int height);
  ~GlVisibility();

  // Only where the camera is outside of every occupied voxel and no such voxel is nearer than 5 mm.
  voxel::testing::RayCastView evaluate(const Pose& X_WC, const Pinhole& camera);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::render
