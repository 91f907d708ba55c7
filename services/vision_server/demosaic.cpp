#include "services/vision_server/demosaic.h"

#include <opencv2/imgproc.hpp>

namespace periplus::vision {

ImageU8 demosaiced(ImageU8 raw, Mosaic mosaic) {
  // OpenCV names a mosaic by the second and third pixel of its second row.
  int code = 0;
  switch (mosaic) {
    case Mosaic::none: return raw;
    case Mosaic::rggb: code = cv::COLOR_BayerBG2RGB; break;
    case Mosaic::bggr: code = cv::COLOR_BayerRG2RGB; break;
    case Mosaic::gbrg: code = cv::COLOR_BayerGR2RGB; break;
    case Mosaic::grbg: code = cv::COLOR_BayerGB2RGB; break;
  }
  require(raw.channels == 1 && raw.width >= 4 && raw.height >= 4, ErrorCode::vision_image_bad, "a mosaic has one value a pixel and at least 4 pixels a side");
  ImageU8 rgb(raw.width, raw.height, 3);
  cv::Mat out(rgb.height, rgb.width, CV_8UC3, rgb.data.data());
  cv::cvtColor(cv::Mat(raw.height, raw.width, CV_8UC1, raw.data.data()), out, code);
  return rgb;
}

}  // namespace periplus::vision
