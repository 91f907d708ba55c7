// Raw image pairs to rectified ones (thesis 4.2.1.2): lines of both images correspond, disparities run along them.
#pragma once

#include <cstddef>
#include <list>
#include <memory>
#include <mutex>

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

// Where each rectified pixel lies in the raw image, of the calibrations last used: computed once for each, however many images
// it serves. A calibration that differs in any number is another one. Thread-safe.
class RectificationMaps {
 public:
  // `capacity`: calibrations kept, the least recently used leaves first; 8 bytes a pixel each.
  explicit RectificationMaps(std::size_t capacity = 4) : capacity_(capacity) {}
  ~RectificationMaps();

  // Width x height pixels of the rectified image, grey or rgb as `raw`, whose size must be the calibration's. Bilinear; black
  // where the raw image does not reach.
  ImageU8 resample(const ImageU8& raw, const CameraCalibration& calibration);
  // How often a map has been computed.
  std::size_t computed() const;

 private:
  struct Map;
  std::shared_ptr<const Map> map_of(const CameraCalibration& calibration);

  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::list<std::shared_ptr<const Map>> maps_;  // the last used first
  std::size_t computed_ = 0;
};

// The rig of a calibrated pair. Throws Error(vision_image_bad) where the two do not make a rectified pair: other sizes or
// focal lengths, vertical offset, no baseline.
StereoRig rig_of(const CameraCalibration& left, const CameraCalibration& right);

// `X_WC_raw`: pose of the raw left eye. Images of calibrations without distortion, with R = I and K as P, are taken as
// they are; others are resampled through `maps` (OpenCV's initUndistortRectifyMap). Throws Error(vision_image_bad) if an image
// has another size than its calibration.
RectifiedPair rectify(const CapturedView& view, const Pose& X_WC_raw, RectificationMaps& maps);

}  // namespace periplus::vision
