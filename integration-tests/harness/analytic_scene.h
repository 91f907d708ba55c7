// Stereo images and depth of a scene of boxes, cylinders and spheres, ray-cast in closed form: images whose truth is known
// without the simulator. Surfaces carry a solid noise texture, so that every image row can be matched.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/scene/scene.h"

namespace periplus::harness {

class AnalyticScene {
 public:
  // The scene's room and solids, and `object`: solids that the scene does not know of.
  AnalyticScene(scene::Scene scene, std::vector<scene::Solid> object);

  struct Hit {
    double t = 0;                             // p = origin + t * direction
    Eigen::Vector3d p_W{0, 0, 0}, normal_W{0, 0, 1};
    int solid = -1;                           // index: the scene's solids, then the object's; -1 the room
  };
  Hit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  bool is_object(const Hit& hit) const { return hit.solid >= static_cast<int>(scene_.solids.size()); }
  // Distance of a point to the object's surface, negative inside [m].
  double object_distance(const Eigen::Vector3d& p_W) const;

  struct Look {
    ImageU8 image;                            // rgb
    ImageF depth;                             // along the optical axis [m]
    ImageU8 object;                           // 255 where the object is seen
  };
  // What a camera at X_WC sees; no noise.
  Look look(const Pinhole& camera, const Pose& X_WC) const;

  // Makes the object plain grey: stereo finds nothing on it.
  bool plain_object = false;

 private:
  scene::Scene scene_;
  std::vector<scene::Solid> solids_;          // the scene's, then the object's
};

// Camera as it is: value * gain + offset + Gaussian noise of `sigma`, all in grey levels, seeded.
ImageU8 with_sensor_noise(const ImageU8& image, double sigma, double gain, double offset, std::uint64_t seed);

// Grey values of an rgb image, as the luma of ITU-R BT.601.
ImageU8 to_grey(const ImageU8& rgb);

}  // namespace periplus::harness
