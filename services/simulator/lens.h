// A lens that bends: pictures of an ideal camera to those of one with radial and tangential distortion, by OpenCV's plumb_bob model
// (D. C. Brown, Close-range camera calibration, 1971).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/image.h"

namespace periplus::simulator {

class Lens {
 public:
  // `camera`: focal lengths, principal point and size of the picture that comes out. `distortion`: k1 k2 p1 p2 k3, or none of them,
  // which is an ideal lens. Throws Error(bad_input) for another count, for a distortion that shows one direction at two places within
  // the picture, and for one that would need a picture of more than twice the size to be drawn.
  Lens(const Pinhole& camera, std::vector<double> distortion);

  bool ideal() const { return distortion_.empty(); }
  const std::vector<double>& distortion() const { return distortion_; }
  // What must be drawn: the same focal lengths, wide enough for all that the lens sees.
  const Pinhole& drawn() const { return drawn_; }
  // The picture through the lens of one that was drawn; bilinear. Of an ideal lens the same bytes.
  ImageU8 bend(ImageU8 picture) const;

  // Of directions (x/z, y/z) in the optical frame.
  Eigen::Vector2d distorted(const Eigen::Vector2d& xy) const;

 private:
  Eigen::Vector2d undistorted(const Eigen::Vector2d& xy) const;

  Pinhole camera_, drawn_;
  std::vector<double> distortion_;
  std::vector<Eigen::Vector2f> from_;  // of each pixel: where it lies in the drawn picture [px]
};

}  // namespace periplus::simulator
