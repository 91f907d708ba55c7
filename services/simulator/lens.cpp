#include "services/simulator/lens.h"

#include <algorithm>
#include <cmath>

#include "common/core/error.h"

namespace periplus::simulator {

namespace {
[[noreturn]] void too_strong() {
  throw_error(ErrorCode::bad_input, "a camera's distortion is too strong: within the picture one direction would be seen twice, or it would be wider than twice what is asked for; make the coefficients k1 k2 p1 p2 k3 smaller");
}
}  // namespace

Eigen::Vector2d Lens::distorted(const Eigen::Vector2d& xy) const {
  const double k1 = distortion_[0], k2 = distortion_[1], p1 = distortion_[2], p2 = distortion_[3], k3 = distortion_[4];
  const double x = xy.x(), y = xy.y(), r2 = xy.squaredNorm(), radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

// Newton's method from the image's middle outwards: the branch that begins there is the one that a lens has.
Eigen::Vector2d Lens::undistorted(const Eigen::Vector2d& goal) const {
  const double k1 = distortion_[0], k2 = distortion_[1], p1 = distortion_[2], p2 = distortion_[3], k3 = distortion_[4];
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  constexpr int kSteps = 8;
  for (int step = 1; step <= kSteps; ++step) {
    const Eigen::Vector2d target = goal * step / kSteps;
    Eigen::Vector2d rest = target - distorted(at);
    for (int i = 0; i < 20 && rest.norm() > 1e-12; ++i) {
      const double x = at.x(), y = at.y(), r2 = at.squaredNorm();
      const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3)), slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));
      Eigen::Matrix2d J;
      J << radial + slope * x * x + 2 * p1 * y + 6 * p2 * x, slope * x * y + 2 * p1 * x + 2 * p2 * y,
          slope * x * y + 2 * p1 * x + 2 * p2 * y, radial + slope * y * y + 6 * p1 * y + 2 * p2 * x;
      const double determinant = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
      // Where the picture folds over, the determinant changes its sign.
      if (!(determinant > 0.05) || !(J(0, 0) > 0)) too_strong();
      at += Eigen::Vector2d(J(1, 1) * rest.x() - J(0, 1) * rest.y(), J(0, 0) * rest.y() - J(1, 0) * rest.x()) / determinant;
      rest = target - distorted(at);
    }
    if (!(rest.norm() < 1e-9)) too_strong();
  }
  return at;
}

Lens::Lens(const Pinhole& camera, std::vector<double> distortion) : camera_(camera), drawn_(camera), distortion_(std::move(distortion)) {
  require(distortion_.empty() || distortion_.size() == 5, ErrorCode::bad_input, "a camera's distortion has five coefficients: k1 k2 p1 p2 k3");
  if (std::all_of(distortion_.begin(), distortion_.end(), [](double k) { return k == 0; })) distortion_.clear();
  if (ideal()) return;
  const Eigen::Array2d f(camera.fx, camera.fy), c(camera.cx, camera.cy);
  Eigen::Array2d least(0, 0), most(camera.width - 1, camera.height - 1);
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  from_.reserve(pixels);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Array2d at = undistorted((Eigen::Array2d(u, v) - c) / f).array() * f + c;
      least = least.min(at);
      most = most.max(at);
      from_.push_back(at.cast<float>().matrix());
    }
  // As much on either side, so that the principal point stays where it was in the picture's middle.
  const Eigen::Array2d beyond = (-least).max(most - Eigen::Array2d(camera.width - 1, camera.height - 1)).ceil() + 1;
  if ((2 * beyond > Eigen::Array2d(camera.width, camera.height)).any()) too_strong();
  drawn_.width += 2 * static_cast<int>(beyond.x());
  drawn_.height += 2 * static_cast<int>(beyond.y());
  drawn_.cx += beyond.x();
  drawn_.cy += beyond.y();
  for (Eigen::Vector2f& at : from_) at += beyond.cast<float>().matrix();
}

ImageU8 Lens::bend(ImageU8 picture) const {
  require(picture.width == drawn_.width && picture.height == drawn_.height, ErrorCode::bad_size, "a lens bends pictures of the camera that is drawn");
  if (ideal()) return picture;
  ImageU8 out(camera_.width, camera_.height, picture.channels);
  std::size_t pixel = 0;
  for (const Eigen::Vector2f& at : from_) {
    const int u = std::clamp(static_cast<int>(at.x()), 0, picture.width - 2), v = std::clamp(static_cast<int>(at.y()), 0, picture.height - 2);
    const float a = at.x() - static_cast<float>(u), b = at.y() - static_cast<float>(v);
    for (int c = 0; c < out.channels; ++c) {
      const float upper = (1 - a) * picture.at(u, v, c) + a * picture.at(u + 1, v, c);
      const float lower = (1 - a) * picture.at(u, v + 1, c) + a * picture.at(u + 1, v + 1, c);
      out.data[pixel++] = static_cast<std::uint8_t>(std::lround((1 - b) * upper + b * lower));
    }
  }
  return out;
}

}  // namespace periplus::simulator
