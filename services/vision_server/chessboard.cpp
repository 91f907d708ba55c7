#include "services/vision_server/chessboard.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/error.h"

namespace periplus::vision {
namespace {

using Corners = std::vector<cv::Point2f>;

std::string text(const char* pattern, auto... values) {
  char out[300];
  std::snprintf(out, sizeof out, pattern, values...);
  return out;
}

// Grey value between pixels; negative outside.
float grey_at(const cv::Mat& grey, cv::Point2f p) {
  const int x = cvFloor(p.x), y = cvFloor(p.y);
  if (x < 0 || y < 0 || x + 1 >= grey.cols || y + 1 >= grey.rows) return -1;
  const float u = p.x - static_cast<float>(x), v = p.y - static_cast<float>(y);
  const auto at = [&](int column, int row) { return static_cast<float>(grey.at<std::uint8_t>(row, column)); };
  return (1 - v) * ((1 - u) * at(x, y) + u * at(x + 1, y)) + v * ((1 - u) * at(x, y + 1) + u * at(x + 1, y + 1));
}

// 1 or -1 where two bright and two dark squares meet at the board point (the sign says which), 0 elsewhere.
int saddle(const cv::Mat& grey, const cv::Matx33d& H, double column, double row) {
  const auto sample = [&](double dx, double dy) {
    const cv::Vec3d p = H * cv::Vec3d(column + dx, row + dy, 1);
    return grey_at(grey, cv::Point2f(static_cast<float>(p[0] / p[2]), static_cast<float>(p[1] / p[2])));
  };
  constexpr double kReach = 0.3;         // of a square
  constexpr float kLeastContrast = 12;   // grey values
  const float a = sample(-kReach, -kReach), b = sample(kReach, kReach), c = sample(kReach, -kReach), d = sample(-kReach, kReach);
  if (std::min(std::min(a, b), std::min(c, d)) < 0) return 0;
  if (std::min(a, b) > std::max(c, d) + kLeastContrast) return 1;
  if (std::min(c, d) > std::max(a, b) + kLeastContrast) return -1;
  return 0;
}

// Share of the points (column0 + i, row0 + j) that are corners of a chessboard, colours alternating.
double share_of_saddles(const cv::Mat& grey, const cv::Matx33d& H, int column0, int row0, int columns, int rows) {
  int even = 0, odd = 0;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int sign = saddle(grey, H, column0 + i, row0 + j) * ((i + j) % 2 == 0 ? 1 : -1);
      even += sign > 0;
      odd += sign < 0;
    }
  return static_cast<double>(std::max(even, odd)) / (columns * rows);
}

std::optional<cv::Matx33d> image_from_board(const Corners& corners, cv::Size size) {
  Corners points;
  for (int j = 0; j < size.height; ++j)
    for (int i = 0; i < size.width; ++i) points.emplace_back(static_cast<float>(i), static_cast<float>(j));
  const cv::Mat H = cv::findHomography(points, corners);
  if (H.empty()) return std::nullopt;
  return cv::Matx33d(H.ptr<double>());
}

// Of the corners, this share must look like one: some of a piece lie beside what covers the rest.
constexpr double kWhole = 0.95, kPiece = 0.7;

constexpr double kFaint = 32;  // grey values between an image's darkest and brightest pixel: of 12 bits in 16, say, the upper 8 have 16

bool is_board(const cv::Mat& grey, const Corners& corners, cv::Size size, double least_share) {
  const auto H = image_from_board(corners, size);
  return H && share_of_saddles(grey, *H, 0, 0, size.width, size.height) >= least_share;
}

// A further row or column of corners lies beyond those found.
bool is_larger(const cv::Mat& grey, const Corners& corners, cv::Size size) {
  const auto H = image_from_board(corners, size);
  if (!H) return false;
  const int w = size.width, h = size.height;
  const double beside[] = {share_of_saddles(grey, *H, -1, 0, 1, h), share_of_saddles(grey, *H, w, 0, 1, h),
                           share_of_saddles(grey, *H, 0, -1, w, 1), share_of_saddles(grey, *H, 0, h, w, 1)};
  return *std::max_element(std::begin(beside), std::end(beside)) >= 0.8;
}

void refine(const cv::Mat& grey, Corners& corners, cv::Size size) {
  double spacing = 1e9;
  for (int j = 0; j < size.height; ++j)
    for (int i = 0; i < size.width; ++i) {
      const cv::Point2f p = corners[static_cast<std::size_t>(j * size.width + i)];
      if (i + 1 < size.width) spacing = std::min(spacing, cv::norm(corners[static_cast<std::size_t>(j * size.width + i + 1)] - p));
      if (j + 1 < size.height) spacing = std::min(spacing, cv::norm(corners[static_cast<std::size_t>((j + 1) * size.width + i)] - p));
    }
  const int half = std::clamp(static_cast<int>(0.3 * spacing), 2, 11);
  cv::cornerSubPix(grey, corners, {half, half}, {-1, -1}, {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-4});
}

double edge_width(const cv::Mat& grey, const Corners& corners, cv::Size size) {
  const auto width = [&](bool vertical) { return cv::estimateChessboardSharpness(grey, size, corners, 0.8f, vertical)[0]; };
  return std::max(width(false), width(true));
}

// The whole board, looked for at the size at which it is most easily seen first.
std::optional<Corners> whole_board(const cv::Mat& grey, cv::Size size) {
  int divisor = 1;
  while (grey.cols / divisor > 1280) divisor *= 2;
  for (const int d : {divisor, 2 * divisor, divisor / 2}) {
    if (d < 1 || std::min(grey.cols, grey.rows) / d < 60) continue;
    cv::Mat smaller = grey;
    if (d > 1) cv::resize(grey, smaller, {grey.cols / d, grey.rows / d}, 0, 0, cv::INTER_AREA);
    Corners corners;
    if (!cv::findChessboardCorners(smaller, size, corners,
                                   cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
      continue;
    const cv::Point2f scale(static_cast<float>(grey.cols) / static_cast<float>(smaller.cols),
                            static_cast<float>(grey.rows) / static_cast<float>(smaller.rows));
    for (cv::Point2f& p : corners) p = {(p.x + 0.5f) * scale.x - 0.5f, (p.y + 0.5f) * scale.y - 0.5f};
    refine(grey, corners, size);
    if (is_board(grey, corners, size, kWhole)) return corners;
  }
  return std::nullopt;
}

struct Piece {
  Corners corners;
  cv::Size size;  // 0 x 0: none
};

// Whatever of a chessboard is seen, the largest of what several searches find; they tolerate blur better.
Piece piece_of_board(const cv::Mat& grey) {
  cv::Mat smaller = grey;
  int divisor = 1;
  while (grey.cols / divisor > 1280) divisor *= 2;
  if (divisor > 1) cv::resize(grey, smaller, {grey.cols / divisor, grey.rows / divisor}, 0, 0, cv::INTER_AREA);
  Piece largest;
  const auto take = [&](Corners corners, cv::Size size) {
    if (size.area() <= largest.size.area() || static_cast<int>(corners.size()) != size.area()) return;
    const auto scale = static_cast<float>(divisor);
    for (cv::Point2f& p : corners) p = {(p.x + 0.5f) * scale - 0.5f, (p.y + 0.5f) * scale - 0.5f};
    if (is_board(grey, corners, size, kPiece)) largest = {std::move(corners), size};
  };
  for (const int effort : {0, static_cast<int>(cv::CALIB_CB_EXHAUSTIVE)}) {
    Corners corners;
    cv::Mat meta;
    if (cv::findChessboardCornersSB(smaller, {3, 3}, corners, cv::CALIB_CB_LARGER | effort, meta)) take(std::move(corners), meta.size());
  }
  return largest;
}

// Corners of a board found with columns and rows exchanged, in the order of `size`.
Corners transposed(const Corners& corners, cv::Size size) {
  Corners out;
  for (int j = 0; j < size.height; ++j)
    for (int i = 0; i < size.width; ++i) out.push_back(corners[static_cast<std::size_t>(i * size.height + j)]);
  return out;
}

BoardSearch search(const cv::Mat& grey, const Chessboard& board, double limit) {
  const cv::Size size(board.columns, board.rows), turned(board.rows, board.columns);
  std::optional<Corners> corners = whole_board(grey, size);
  Piece piece;
  if (!corners) {
    piece = piece_of_board(grey);
    if (piece.size == size) corners = piece.corners;
    if (piece.size == turned) corners = transposed(piece.corners, size);
    if (corners) refine(grey, *corners, size);
    if (corners && !is_board(grey, *corners, size, kWhole)) corners.reset();
  }
  const std::string all = text("%d x %d", board.columns, board.rows);
  const auto blurred = [&](double width) {
    return text("blurred: the board's edges are %.1f px wide, at most %.1f are sharp; hold the board still, focus, take more light", width, limit);
  };
  BoardSearch out;
  if (!corners) {
    const double width = piece.size.area() > 0 ? edge_width(grey, piece.corners, piece.size) : 0;
    const int longer = std::max(piece.size.width, piece.size.height), shorter = std::min(piece.size.width, piece.size.height);
    double darkest = 0, brightest = 0;
    cv::minMaxLoc(grey, &darkest, &brightest);
    if (width > limit) {
      out.why = blurred(width);
    } else if (brightest - darkest < kFaint) {
      out.why = text("no whole board is found: the image has hardly any contrast, grey values from %.0f to %.0f of 255; take more light, and scale what is stored in a part of 16 bits to all of them",
                     darkest, brightest);
    } else if ((longer > std::max(board.columns, board.rows) || shorter > std::min(board.columns, board.rows)) && is_board(grey, piece.corners, piece.size, kWhole)) {
      out.why = text("the board seems to have %d x %d inner corners, not ", longer, shorter) + all + "; give the board's own number";
    } else if (piece.size.area() > 0 && longer <= std::max(board.columns, board.rows) && shorter <= std::min(board.columns, board.rows)) {
      out.why = text("partly seen: %d x %d of the board's ", longer, shorter) + all +
                " inner corners are recognised; nothing may cover the board, all of it must be in the picture, and its number is that of the places where four squares meet";
    } else {
      out.why = "no whole board of " + all + " inner corners is found: it is covered, cut by the picture's edge, unevenly lit, bent, of another number or not there";
    }
    return out;
  }
  if (is_larger(grey, *corners, size)) {
    out.why = "the board has more than " + all + " inner corners; give the board's own number";
    return out;
  }
  BoardView view;
  view.edge_px = edge_width(grey, *corners, size);
  if (!(view.edge_px <= limit)) {
    out.why = blurred(view.edge_px);
    return out;
  }
  for (const cv::Point2f& p : *corners) view.corners.emplace_back(p.x, p.y);
  out.view = std::move(view);
  return out;
}

}  // namespace

void Chessboard::check() const {
  require(columns >= 3 && columns <= 50 && rows >= 3 && rows <= 50, ErrorCode::bad_input,
          "a board of " + std::to_string(columns) + " x " + std::to_string(rows) +
              " inner corners: 3 to 50 each way are expected; count where four squares meet, not the squares");
  require(std::isfinite(square) && square >= 1e-6 && square <= 1e6, ErrorCode::bad_input,
          "a square of side " + std::to_string(square) + ": a positive length is expected");
}

BoardSearch find_board(const ImageU8& grey, const Chessboard& board, const BoardLimits& limits) {
  board.check();
  require(grey.channels == 1, ErrorCode::bad_input, "boards are found in grey images");
  if (std::min(grey.width, grey.height) < 32)
    return {std::nullopt, text("an image of %d x %d pixels: too small to show a board", grey.width, grey.height)};
  const cv::Mat image(grey.height, grey.width, CV_8U, const_cast<std::uint8_t*>(grey.data.data()));
  try {
    return search(image, board, limits.edge_px_for(grey.width));
  } catch (const cv::Exception& e) {
    return {std::nullopt, "the search for the board fails on this image: " + e.err};
  }
}

}  // namespace periplus::vision
