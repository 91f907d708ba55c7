#include "services/vision_server/feature_detector.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>
#if PERIPLUS_XFEATURES2D
#include <opencv2/xfeatures2d/nonfree.hpp>
#endif

#include "common/core/error.h"

namespace periplus::vision {

namespace {

cv::Ptr<cv::Feature2D> make_detector(const DetectorSettings& s, double sensitivity) {
  switch (s.kind) {
    case DescriptorKind::root_sift: return cv::SIFT::create(0, 3, s.contrast / sensitivity, s.edge, 1.6);
    case DescriptorKind::akaze:
      return cv::AKAZE::create(cv::AKAZE::DESCRIPTOR_MLDB, 0, 3, static_cast<float>(s.akaze_response / sensitivity));
    case DescriptorKind::orb: {
      constexpr int kMost = 4000;  // the strongest; of these the cells choose
      return cv::ORB::create(kMost, 1.2f, 8, 31, 0, 2, cv::ORB::HARRIS_SCORE, 31, std::max(1, static_cast<int>(std::lround(s.orb_fast / sensitivity))));
    }
    case DescriptorKind::surf: break;
  }
#if PERIPLUS_XFEATURES2D
  return cv::xfeatures2d::SURF::create(s.surf_hessian / sensitivity);
#else
  throw_error(ErrorCode::bad_input, unavailable(DescriptorKind::surf));
#endif
}

// The rectangle about the mask, widened by what descriptors look at: most of the work is done for every pixel. Its corner lies where
// coarser octaves have samples too. Empty for an empty mask.
cv::Rect surroundings(const cv::Mat& mask) {
  constexpr int kMargin = 48, kCoarsest = 16;  // [px]
  const cv::Rect about = cv::boundingRect(mask);
  if (about.area() == 0) return about;
  const int left = std::max(0, about.x - kMargin) / kCoarsest * kCoarsest, top = std::max(0, about.y - kMargin) / kCoarsest * kCoarsest;
  return cv::Rect(left, top, std::min(mask.cols, about.br().x + kMargin) - left, std::min(mask.rows, about.br().y + kMargin) - top);
}

void append_root_sift(const float* v, std::size_t n, std::vector<std::uint8_t>& out) {
  double sum = 1e-9;
  for (std::size_t i = 0; i < n; ++i) sum += v[i];
  for (std::size_t i = 0; i < n; ++i) out.push_back(static_cast<std::uint8_t>(std::min<long>(255, std::lround(512 * std::sqrt(v[i] / sum)))));
}

void append_surf(const float* v, std::size_t n, std::vector<std::uint8_t>& out) {
  for (std::size_t i = 0; i < n; ++i) out.push_back(static_cast<std::uint8_t>(std::clamp<long>(std::lround(128 + 256.0 * v[i]), 0, 255)));
}

}  // namespace

std::string unavailable(DescriptorKind kind) {
  if (kind != DescriptorKind::surf) return "";
#if PERIPLUS_XFEATURES2D
  try {
    cv::xfeatures2d::SURF::create();
    return "";
  } catch (const cv::Exception&) {
    // The module is there, the algorithm was left out.
  }
#endif
  return "features: this OpenCV was built without SURF (module xfeatures2d with OPENCV_ENABLE_NONFREE, which Debian's packages leave out); choose sift, "
         "akaze or orb as features.detector";
}

void DetectorSettings::check() const {
  require(contrast > 0 && contrast < 1, ErrorCode::bad_input, "features: contrast must lie in (0, 1)");
  require(edge > 1, ErrorCode::bad_input, "features: edge must exceed 1");
  require(akaze_response > 0 && akaze_response < 1, ErrorCode::bad_input, "features: akaze_response must lie in (0, 1)");
  require(orb_fast >= 1 && orb_fast <= 255, ErrorCode::bad_input, "features: orb_fast must lie in 1..255");
  require(surf_hessian > 0 && std::isfinite(surf_hessian), ErrorCode::bad_input, "features: surf_hessian must be positive");
  const std::string reason = unavailable(kind);
  require(reason.empty(), ErrorCode::bad_input, reason);
}

DetectedFeatures detect_features(const ImageU8& grey, const ImageU8& mask, const DetectorSettings& settings, double sensitivity) {
  settings.check();
  require(grey.channels == 1 && mask.channels == 1 && grey.width > 0 && grey.height > 0 && mask.width == grey.width && mask.height == grey.height,
          ErrorCode::bad_size, "features need a grey image and a mask of its size");
  require(sensitivity > 0 && sensitivity <= 100, ErrorCode::bad_input, "features: sensitivity must lie in (0, 100]");
  const cv::Mat image(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data.data()));
  const cv::Mat where(mask.height, mask.width, CV_8UC1, const_cast<std::uint8_t*>(mask.data.data()));
  const cv::Rect part = surroundings(where);
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  if (part.area() > 0) make_detector(settings, sensitivity)->detectAndCompute(image(part), where(part), points, descriptors);
  for (cv::KeyPoint& k : points) k.pt += cv::Point2f(part.tl());

  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const cv::KeyPoint &x = points[a], &y = points[b];
    return std::tie(x.pt.y, x.pt.x, x.size, x.angle, x.response, x.octave) < std::tie(y.pt.y, y.pt.x, y.size, y.angle, y.response, y.octave);
  });
  DetectedFeatures out;
  out.kind = settings.kind;
  const std::size_t octets = object_model::descriptor_octets(settings.kind);
  require(points.empty() || static_cast<std::size_t>(descriptors.cols) == octets, ErrorCode::internal, "OpenCV gives descriptors of another length");
  out.points.reserve(points.size());
  out.descriptors.reserve(points.size() * octets);
  for (const std::size_t i : order) {
    const cv::KeyPoint& k = points[i];
    out.points.push_back({k.pt.x, k.pt.y, k.size, static_cast<float>(k.angle * std::numbers::pi / 180), k.response});
    const int row = static_cast<int>(i);
    switch (settings.kind) {
      case DescriptorKind::root_sift: append_root_sift(descriptors.ptr<float>(row), octets, out.descriptors); break;
      case DescriptorKind::surf: append_surf(descriptors.ptr<float>(row), octets, out.descriptors); break;
      case DescriptorKind::akaze:
      case DescriptorKind::orb: out.descriptors.insert(out.descriptors.end(), descriptors.ptr<std::uint8_t>(row), descriptors.ptr<std::uint8_t>(row) + octets); break;
    }
  }
  return out;
}

}  // namespace periplus::vision
