// The chessboard that cameras are calibrated with, found in an image.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/image.h"

namespace periplus::vision {

struct Chessboard {
  int columns = 9, rows = 6;  // inner corners, where four squares meet; each at least 3
  double square = 1;          // a square's side; poses and baselines come out in its unit
  // Throws Error(bad_input) outside 3..50 corners a side, or where the side is not finite or not in 1e-6..1e6.
  void check() const;
};

struct BoardView {
  std::vector<Eigen::Vector2d> corners;  // columns * rows, row by row [px], pixel centres at integers
  double edge_px = 0;                    // mean width of the edges, 10 to 90 % of their rise, of the blurrier direction
};

struct BoardLimits {
  // Widest edge that counts as sharp. Sharp images show 2.5 to 3.6 px; Gaussian blur of standard deviation 2 px makes 5.8.
  // Images wider than 1280 px may be blurred in proportion: their pixels are smaller than what a lens resolves.
  double edge_px = 4.5;
  double edge_px_for(int image_width) const { return edge_px * std::max(1.0, image_width / 1280.0); }
};

// `view` or, where the image cannot be used, `why`: a sentence for whoever took it.
struct BoardSearch {
  std::optional<BoardView> view;
  std::string why;
};

// Corners to a fraction of a pixel (OpenCV's findChessboardCorners and, where that fails, findChessboardCornersSB; then
// cornerSubPix in windows that no neighbouring corner enters). Whatever is found is checked to be a chessboard of that many
// corners and no more. Sharpness as OpenCV's estimateChessboardSharpness, across and along. `grey` has one channel.
// No view if there is no board, a part of one, a board of more corners, or a blurred one. Throws Error(bad_input) for a board
// that cannot be.
BoardSearch find_board(const ImageU8& grey, const Chessboard& board, const BoardLimits& limits = {});

}  // namespace periplus::vision
