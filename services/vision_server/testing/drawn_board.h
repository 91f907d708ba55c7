// A chessboard as a camera of known truth sees it, in closed form: every pixel is the mean of the board's colours along
// its rays, through a lens that blurs by a standard deviation of 0.7 px.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "services/vision_server/chessboard.h"

namespace periplus::vision::testing {

struct TrueCamera {
  int width = 640, height = 480;
  double fx = 540, fy = 540, cx = 325, cy = 236;      // [px]
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;

  // A camera of the same kind with `factor` times the pixels a side.
  TrueCamera scaled(double factor) const {
    TrueCamera c = *this;
    c.width = static_cast<int>(width * factor);
    c.height = static_cast<int>(height * factor);
    c.fx *= factor;
    c.fy *= factor;
    c.cx = (cx + 0.5) * factor - 0.5;
    c.cy = (cy + 0.5) * factor - 0.5;
    return c;
  }
  // Brown-Conrady: pixel of a direction (x, y, 1).
  Eigen::Vector2d project(double x, double y) const {
    const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * k2);
    return {fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx, fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy};
  }
  // Direction of a pixel, by fixed-point iteration of the above.
  Eigen::Vector2d direction(double u, double v) const {
    const double x0 = (u - cx) / fx, y0 = (v - cy) / fy;
    double x = x0, y = y0;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d p = project(x, y);
      x += x0 - (p.x() - cx) / fx;
      y += y0 - (p.y() - cy) / fy;
    }
    return {x, y};
  }
};

// `X_CB`: board frame in the camera's, its origin at the first inner corner, x along the columns, y along the rows.
inline ImageU8 draw_board(const TrueCamera& camera, const Chessboard& board, const Pose& X_CB) {
  constexpr int kRays = 3;  // each way in a pixel
  ImageU8 out(camera.width, camera.height);
  const Pose X_BC = X_CB.inverse();
  const Eigen::Vector3d from = X_BC.translation();
  const auto grey = [&](double x, double y) {
    const int i = static_cast<int>(std::floor(x / board.square)) + 1, j = static_cast<int>(std::floor(y / board.square)) + 1;
    if (i < -1 || j < -1 || i > board.columns + 1 || j > board.rows + 1) return 90.0;                            // the room
    if (i < 0 || j < 0 || i > board.columns || j > board.rows) return 220.0;  // the margin
    return (i + j) % 2 == 0 ? 40.0 : 220.0;
  };
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      double sum = 0;
      for (int b = 0; b < kRays; ++b)
        for (int a = 0; a < kRays; ++a) {
          const Eigen::Vector2d d = camera.direction(u + (a + 0.5) / kRays - 0.5, v + (b + 0.5) / kRays - 0.5);
          const Eigen::Vector3d ray = X_BC.linear() * Eigen::Vector3d(d.x(), d.y(), 1);
          const double s = -from.z() / ray.z();
          sum += s > 0 ? grey(from.x() + s * ray.x(), from.y() + s * ray.y()) : 90.0;
        }
      out.at(u, v) = static_cast<std::uint8_t>(std::lround(sum / (kRays * kRays)));
    }
  const cv::Mat image(out.height, out.width, CV_8U, out.data.data());
  cv::GaussianBlur(image, image, {}, 0.7);
  return out;
}

// Where the corners are in truth [px], in the order of BoardView.
inline std::vector<Eigen::Vector2d> true_corners(const TrueCamera& camera, const Chessboard& board, const Pose& X_CB) {
  std::vector<Eigen::Vector2d> out;
  for (int j = 0; j < board.rows; ++j)
    for (int i = 0; i < board.columns; ++i) {
      const Eigen::Vector3d p = X_CB * Eigen::Vector3d(i * board.square, j * board.square, 0);
      out.push_back(camera.project(p.x() / p.z(), p.y() / p.z()));
    }
  return out;
}

// The n-th of many poses of a board of 9 x 6 about 18 squares away, tilted each way, its middle strewn over the image.
inline Pose board_pose(const Chessboard& board, int n) {
  const double tilts[][3] = {{0, 0, 0.07}, {0.5, 0, 0.1}, {-0.5, 0.1, 0}, {0, 0.5, -0.1}, {0.1, -0.5, 0}, {0.35, 0.35, 0.2},
                             {-0.35, 0.35, -0.2}, {0.35, -0.35, 0.1}, {-0.4, -0.3, 0.3}, {0.2, 0.5, -0.3}, {0.5, -0.2, 0.15}, {-0.2, 0.45, 0.25}};
  const double places[][3] = {{0, 0, 17}, {-3, -2, 19}, {3.5, 2, 20}, {-3, 2, 18}, {3, -2, 19}, {0, 2.5, 18},
                              {-1, -2.5, 20}, {1.5, 0, 16}, {-3.5, 0, 20}, {3.5, 0.5, 19}, {0.5, 1, 22}, {-1, -1, 16}};
  const auto& t = tilts[n % 12];
  const auto& p = places[n % 12];
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(t[2], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(t[1], Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(t[0], Eigen::Vector3d::UnitX())).toRotationMatrix();
  const Eigen::Vector3d middle((board.columns - 1) / 2.0 * board.square, (board.rows - 1) / 2.0 * board.square, 0);
  return make_pose(Eigen::Vector3d(p[0], p[1], p[2]) * board.square - R * middle, R);
}

}  // namespace periplus::vision::testing
