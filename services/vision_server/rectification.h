// Raw image pairs to rectified ones (thesis 4.2.1.2): lines of both images correspond, disparities run along them.
#pragma once

#include "common/geometry/calibration.h"
#include "common/geometry/camera.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "services/vision_server/captured_view.h"

namespace periplus::vision {

struct RectifiedPair {
  StereoRig rig;
  Pose X_WC = Pose::Identity();     // rectified left eye
  ImageU8 left, right;              // rgb
  ImageU8 left_grey, right_grey;
};

// The rig of a calibrated pair. Throws Error(vision_image_bad) where the two do not make a rectified pair: other sizes or
// focal lengths, vertical offset, no baseline.
StereoRig rig_of(const CameraCalibration& left, const CameraCalibration& right);

// `X_WC_raw`: pose of the raw left eye. Images of calibrations without distortion, with R = I and K as P, are taken as
// they are; others are resampled (OpenCV's initUndistortRectifyMap, bilinear). Throws Error(vision_image_bad) if an image
// has another size than its calibration.
RectifiedPair rectify(const CapturedView& view, const Pose& X_WC_raw);

}  // namespace periplus::vision
