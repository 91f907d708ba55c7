#include "common/render/texture.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/mesh/part_builder.h"

namespace periplus::render {
namespace {

constexpr int kFirstOctave = 3, kLastOctave = 10;
constexpr double kFalloff = 0.8;
constexpr int kPixelsPerMark = 2600;

// Cells of the coarse grids are `stretch` times as long as high.
cv::Mat octave_noise(int width, int height, Random& random, int stretch = 1) {
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32F);
  double amplitude = 1;
  for (int octave = kFirstOctave; octave <= kLastOctave; ++octave, amplitude *= kFalloff) {
    const int side = 1 << octave;
    cv::Mat coarse(side, std::max(2, side / stretch), CV_32F), fine;
    for (int y = 0; y < coarse.rows; ++y)
      for (int x = 0; x < coarse.cols; ++x) coarse.at<float>(y, x) = static_cast<float>(random.uniform());
    cv::resize(coarse, fine, {width, height}, 0, 0, cv::INTER_CUBIC);
    sum += fine * amplitude;
  }
  cv::normalize(sum, sum, 0, 1, cv::NORM_MINMAX);
  return sum;
}

// How a material looks: from its dark to its light colour, and marks strewn over it, `length` times as long as high.
struct Look {
  int dark[3], light[3];
  int stretch, length;
};
constexpr Look kLooks[mesh::kMaterials] = {
    {{35, 20, 10}, {150, 100, 60}, 4, 6},      // dark wood
    {{95, 60, 25}, {245, 205, 150}, 4, 6},     // planks
    {{140, 125, 100}, {255, 250, 238}, 1, 1},  // canvas
    {{10, 45, 12}, {150, 215, 90}, 1, 2},      // leaves
    {{60, 62, 68}, {225, 222, 212}, 1, 1},     // stone
    {{28, 20, 14}, {165, 135, 105}, 4, 6},     // bark
    {{70, 12, 10}, {240, 110, 80}, 2, 3},      // paint
    {{30, 50, 38}, {205, 190, 120}, 2, 3},     // bronze
};

void paint_band(cv::Mat canvas, const Look& look, Random& random) {
  const cv::Mat noise = octave_noise(canvas.cols, canvas.rows, random, look.stretch);
  // The middle of the noise, spread over all the contrast there is.
  cv::Scalar mean, deviation;
  cv::meanStdDev(noise, mean, deviation);
  const auto colour = [&](double t, int c) { return std::clamp(look.dark[c] + t * (look.light[c] - look.dark[c]), 0.0, 255.0); };
  for (int y = 0; y < canvas.rows; ++y)
    for (int x = 0; x < canvas.cols; ++x) {
      const double t = std::clamp(0.5 + 0.28 * (noise.at<float>(y, x) - mean[0]) / deviation[0], 0.0, 1.0);
      for (int c = 0; c < 3; ++c) canvas.at<cv::Vec3b>(y, x)[c] = static_cast<std::uint8_t>(colour(t, c));
    }
  for (int i = 0; i < canvas.cols * canvas.rows / 260; ++i) {
    const cv::Point at(static_cast<int>(random.below(static_cast<std::uint64_t>(canvas.cols))), static_cast<int>(random.below(static_cast<std::uint64_t>(canvas.rows))));
    const double t = random.uniform() < 0.5 ? random.uniform(0, 0.15) : random.uniform(0.85, 1.0);
    const int high = 2 + static_cast<int>(random.below(4)), tilt = static_cast<int>(random.below(look.length > 2 ? 12 : 180));
    cv::ellipse(canvas, at, {high * look.length, high}, tilt, 0, 360, {colour(t, 0), colour(t, 1), colour(t, 2)}, cv::FILLED, cv::LINE_AA);
  }
}

}  // namespace

ImageU8 make_texture(int width, int height, std::uint64_t seed) {
  require(width > 0 && height > 0 && width <= 8192 && height <= 8192, ErrorCode::bad_size, "texture: 1 to 8192 pixels a side are possible");
  Random random(seed);
  const cv::Mat noise = octave_noise(width, height, random);
  // Two hues a seed, so that surfaces can be told apart.
  double dark[3], light[3];
  for (int c = 0; c < 3; ++c) {
    dark[c] = random.uniform(25, 75);
    light[c] = random.uniform(175, 235);
  }
  ImageU8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double t = noise.at<float>(y, x);
        image.at(x, y, c) = static_cast<std::uint8_t>(std::clamp(dark[c] * (1 - t) + light[c] * t, 0.0, 255.0));
      }
  cv::Mat canvas(height, width, CV_8UC3, image.data.data());
  const auto whole = [&](int low, int high) { return low + static_cast<int>(random.below(static_cast<std::uint64_t>(high - low))); };
  for (int i = 0; i < width * height / kPixelsPerMark; ++i) {
    const cv::Point at(whole(0, width), whole(0, height));
    const int red = whole(0, 255), green = whole(0, 255), blue = whole(0, 255), size = whole(4, 26);
    const cv::Scalar colour(red, green, blue);
    const int kind = whole(0, 3), line = whole(0, 2) ? cv::FILLED : 3;
    if (kind == 0)
      cv::circle(canvas, at, size, colour, line, cv::LINE_AA);
    else if (kind == 1)
      cv::rectangle(canvas, at, at + cv::Point(size, 3 * size / 2), colour, line);
    else
      cv::putText(canvas, std::string(1, static_cast<char>('A' + whole(0, 26))), at, cv::FONT_HERSHEY_SIMPLEX, size / 14.0, colour, 3, cv::LINE_AA);
  }
  return image;
}

ImageU8 make_materials(int width, int height, std::uint64_t seed) {
  require(width > 0 && height >= mesh::kMaterials && width <= 8192 && height <= 8192, ErrorCode::bad_size, "texture: 8 to 8192 pixels a side are possible");
  Random random(seed);
  ImageU8 image(width, height, 3);
  cv::Mat canvas(height, width, CV_8UC3, image.data.data());
  for (int k = 0; k < mesh::kMaterials; ++k)
    paint_band(canvas.rowRange(height - (k + 1) * height / mesh::kMaterials, height - k * height / mesh::kMaterials), kLooks[k], random);
  return image;
}

ImageU8 load_texture(const std::string& path) {
  cv::Mat picture = cv::imread(path, cv::IMREAD_COLOR);
  require(!picture.empty(), ErrorCode::io, path + ": not a picture that can be read; PNG or JPEG is expected");
  require(picture.cols <= 8192 && picture.rows <= 8192, ErrorCode::bad_size, path + ": the picture has more than 8192 pixels a side");
  ImageU8 image(picture.cols, picture.rows, 3);
  cv::Mat out(image.height, image.width, CV_8UC3, image.data.data());
  cv::cvtColor(picture, out, cv::COLOR_BGR2RGB);
  return image;
}

}  // namespace periplus::render
