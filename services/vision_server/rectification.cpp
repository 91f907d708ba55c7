#include "services/vision_server/rectification.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

namespace periplus::vision {

namespace {

bool is_rectified(const CameraCalibration& c) {
  for (double k : c.distortion)
    if (k != 0) return false;
  return c.R.isIdentity(1e-12) && (c.K - c.P.leftCols<3>()).cwiseAbs().maxCoeff() < 1e-9;
}

template <int Rows, int Cols>
cv::Mat to_cv(const Eigen::Matrix<double, Rows, Cols>& m) {
  cv::Mat out(Rows, Cols, CV_64F);
  for (int i = 0; i < Rows; ++i)
    for (int j = 0; j < Cols; ++j) out.at<double>(i, j) = m(i, j);
  return out;
}

cv::Mat view_of(const ImageU8& image) {
  return {image.height, image.width, image.channels == 3 ? CV_8UC3 : CV_8UC1,
          const_cast<std::uint8_t*>(image.data.data())};
}

ImageU8 to_image(const cv::Mat& m) {
  ImageU8 out(m.cols, m.rows, m.channels());
  m.copyTo(cv::Mat(m.rows, m.cols, m.type(), out.data.data()));
  return out;
}

ImageU8 rectified(const ImageU8& raw, const CameraCalibration& c, RectificationMaps& maps) {
  return is_rectified(c) ? raw : maps.resample(raw, c);
}

ImageU8 converted(const ImageU8& image, int channels) {
  if (image.channels == channels) return image;
  cv::Mat out;
  cv::cvtColor(view_of(image), out, channels == 1 ? cv::COLOR_RGB2GRAY : cv::COLOR_GRAY2RGB);
  return to_image(out);
}

bool same(const CameraCalibration& a, const CameraCalibration& b) {
  return a.width == b.width && a.height == b.height && a.distortion == b.distortion && a.K == b.K && a.R == b.R && a.P == b.P;
}

}  // namespace

struct RectificationMaps::Map {
  CameraCalibration calibration;
  cv::Mat x, y;
};

RectificationMaps::~RectificationMaps() = default;

std::shared_ptr<const RectificationMaps::Map> RectificationMaps::map_of(const CameraCalibration& c) {
  const std::lock_guard lock(mutex_);
  const auto known = std::find_if(maps_.begin(), maps_.end(), [&](const auto& map) { return same(map->calibration, c); });
  if (known != maps_.end()) {
    maps_.splice(maps_.begin(), maps_, known);
    return maps_.front();
  }
  auto map = std::make_shared<Map>();
  map->calibration = c;
  cv::initUndistortRectifyMap(to_cv(c.K), c.distortion, to_cv(c.R), to_cv<3, 3>(c.P.leftCols<3>()), {c.width, c.height},
                              CV_32FC1, map->x, map->y);
  ++computed_;
  maps_.push_front(map);
  if (maps_.size() > capacity_) maps_.pop_back();
  return map;
}

ImageU8 RectificationMaps::resample(const ImageU8& raw, const CameraCalibration& calibration) {
  const std::shared_ptr<const Map> map = map_of(calibration);
  cv::Mat out;
  cv::remap(view_of(raw), out, map->x, map->y, cv::INTER_LINEAR);
  return to_image(out);
}

std::size_t RectificationMaps::computed() const {
  const std::lock_guard lock(mutex_);
  return computed_;
}

StereoRig rig_of(const CameraCalibration& left, const CameraCalibration& right) {
  require(left.width == right.width && left.height == right.height, ErrorCode::vision_image_bad,
          "left and right camera differ in size; the pair must be rectified to one");
  const double fx = left.P(0, 0);
  require(left.P.col(3).head<2>().norm() < 1e-6 * std::max(1.0, std::abs(fx)), ErrorCode::vision_image_bad,
          "the left camera info carries a baseline, which the right one must: P[3] and P[7] of the left must be 0; are left and right exchanged?");
  require((left.P.leftCols<3>() - right.P.leftCols<3>()).cwiseAbs().maxCoeff() < 1e-6 * std::max(1.0, std::abs(fx)),
          ErrorCode::vision_image_bad,
          "left and right projection matrices differ in more than the baseline; calibrate the pair with "
          "zero disparity at infinity");
  require(fx > 0 && right.P(0, 3) < 0 && std::abs(right.P(1, 3)) < 1e-6 * fx, ErrorCode::vision_image_bad,
          "the right camera info carries no baseline: P[3] must be -fx times the baseline, P[7] 0");
  Eigen::Matrix3d pinhole = left.P.leftCols<3>();
  pinhole(1, 1) = pinhole(0, 0) = 1;
  pinhole(0, 2) = pinhole(1, 2) = 0;
  require(pinhole.isIdentity(1e-9), ErrorCode::vision_image_bad, "a camera info's P must be (fx 0 cx; 0 fy cy; 0 0 1) and the baseline; calibrate the pair again");
  StereoRig rig;
  rig.camera = {left.width, left.height, fx, left.P(1, 1), left.P(0, 2), left.P(1, 2)};
  rig.baseline = -right.P(0, 3) / fx;
  rig.check();
  return rig;
}

RectifiedPair rectify(const CapturedView& view, const Pose& X_WC_raw, RectificationMaps& maps) {
  check_sizes(view);
  RectifiedPair pair;
  pair.rig = rig_of(view.left_calibration, view.right_calibration);
  // R turns raw into rectified coordinates, so the rectified frame stands at its transpose in the raw one.
  pair.X_WC = X_WC_raw;
  pair.X_WC.linear() = X_WC_raw.linear() * view.left_calibration.R.transpose();
  const ImageU8 left = rectified(view.left, view.left_calibration, maps);
  const ImageU8 right = rectified(view.right, view.right_calibration, maps);
  pair.left = converted(left, 3);
  pair.right = converted(right, 3);
  pair.left_grey = converted(left, 1);
  pair.right_grey = converted(right, 1);
  return pair;
}

}  // namespace periplus::vision
