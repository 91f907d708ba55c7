#include "services/vision_server/calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <set>

#include "common/geometry/pose.h"

namespace periplus::vision {
namespace {

using Corners = std::vector<cv::Point2f>;

template <class... Values>
std::string sentence(const char* pattern, Values... values) {
  char out[400];
  std::snprintf(out, sizeof out, pattern, values...);
  return out;
}

constexpr double kDegrees = 180 / std::numbers::pi;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Corners to_cv(const std::vector<Eigen::Vector2d>& corners) {
  Corners out;
  for (const Eigen::Vector2d& p : corners) out.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  return out;
}

std::vector<cv::Point3f> board_points(const Chessboard& board) {
  std::vector<cv::Point3f> out;
  for (int j = 0; j < board.rows; ++j)
    for (int i = 0; i < board.columns; ++i) out.emplace_back(static_cast<float>(i * board.square), static_cast<float>(j * board.square), 0.f);
  return out;
}

template <int Rows, int Cols>
Eigen::Matrix<double, Rows, Cols> to_eigen(const cv::Mat& m) {
  Eigen::Matrix<double, Rows, Cols> out;
  cv::cv2eigen(m, out);
  return out;
}

cv::Mat to_cv(const Eigen::Matrix3d& m) {
  cv::Mat out;
  cv::eigen2cv(m, out);
  return out;
}

Pose pose_of(const cv::Mat& rotation, const cv::Mat& translation) {
  cv::Mat R;
  cv::Rodrigues(rotation, R);
  return make_pose(to_eigen<3, 1>(translation.reshape(1, 3)), to_eigen<3, 3>(R));
}

int flags_of(const CalibrationSettings& s) { return s.radial == 2 ? cv::CALIB_FIX_K3 : 0; }

// OpenCV's own failures are about the views given to it.
auto solved(auto solve) {
  try {
    return solve();
  } catch (const cv::Exception& e) {
    throw_error(ErrorCode::bad_input, "these views do not determine a camera (" + e.err + "); take more, with the board tilted each way");
  }
}

struct Solution {
  CameraFit fit;
  std::vector<Pose> X_CB;  // per view
};

std::vector<Eigen::Vector2d> projected(const CameraFit& fit, const Pose& X_CB, const std::vector<cv::Point3f>& points) {
  cv::Mat rotation;
  cv::Rodrigues(to_cv(X_CB.linear()), rotation);
  const Eigen::Vector3d t = X_CB.translation();
  Corners seen;
  cv::projectPoints(points, rotation, cv::Vec3d(t.x(), t.y(), t.z()), to_cv(fit.K), fit.distortion, seen);
  std::vector<Eigen::Vector2d> out;
  for (const cv::Point2f& p : seen) out.emplace_back(p.x, p.y);
  return out;
}

void reproject(CameraFit& fit, const std::vector<Pose>& X_CB, const Chessboard& board) {
  const auto points = board_points(board);
  double all = 0;
  std::size_t count = 0;
  for (std::size_t n = 0; n < fit.views.size(); ++n) {
    FittedView& view = fit.views[n];
    view.reprojected = projected(fit, X_CB[n], points);
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) sum += (view.reprojected[i] - view.corners[i]).squaredNorm();
    view.error_px = std::sqrt(sum / static_cast<double>(points.size()));
    all += sum;
    count += points.size();
  }
  fit.rms_px = std::sqrt(all / static_cast<double>(count));
}

double covered(const std::vector<NamedView>& views, int width, int height) {
  std::set<std::pair<int, int>> cells;
  for (const NamedView& v : views)
    for (const Eigen::Vector2d& p : v.board.corners)
      cells.emplace(std::clamp(static_cast<int>(p.x() * 8 / width), 0, 7), std::clamp(static_cast<int>(p.y() * 6 / height), 0, 5));
  return static_cast<double>(cells.size()) / 48;
}

Solution solve_camera(const std::vector<NamedView>& views, int width, int height, const Chessboard& board, const CalibrationSettings& settings) {
  std::vector<Corners> seen;
  for (const NamedView& v : views) seen.push_back(to_cv(v.board.corners));
  const std::vector<std::vector<cv::Point3f>> points(views.size(), board_points(board));
  cv::Mat K, distortion, sigma, sigma_outer, errors;
  std::vector<cv::Mat> rotations, translations;
  solved([&] { return cv::calibrateCamera(points, seen, {width, height}, K, distortion, rotations, translations, sigma, sigma_outer, errors, flags_of(settings)); });
  Solution out;
  CameraFit& fit = out.fit;
  fit.width = width;
  fit.height = height;
  fit.K = to_eigen<3, 3>(K);
  fit.distortion.assign(distortion.begin<double>(), distortion.end<double>());
  fit.focal_sigma_px = std::max(sigma.at<double>(0), sigma.at<double>(1));
  fit.coverage = covered(views, width, height);
  for (std::size_t n = 0; n < views.size(); ++n) {
    out.X_CB.push_back(pose_of(rotations[n], translations[n]));
    fit.views.push_back({.name = views[n].name, .error_px = 0, .edge_px = views[n].board.edge_px, .corners = views[n].board.corners, .reprojected = {}});
  }
  reproject(fit, out.X_CB, board);
  return out;
}

void check_views(const std::vector<NamedView>& views, int width, int height, const Chessboard& board) {
  board.check();
  require(width >= 32 && height >= 32 && width <= 8192 && height <= 8192, ErrorCode::bad_input,
          sentence("images of %d x %d pixels: 32 to 8192 a side are expected", width, height));
  for (const NamedView& v : views) {
    require(v.board.corners.size() == static_cast<std::size_t>(board.columns * board.rows), ErrorCode::bad_input,
            v.name + sentence(": %zu corners, the board has %d", v.board.corners.size(), board.columns * board.rows));
    for (const Eigen::Vector2d& p : v.board.corners)
      require(p.allFinite() && p.x() >= -1 && p.y() >= -1 && p.x() <= width && p.y() <= height, ErrorCode::bad_input,
              v.name + ": a corner is not within the image");
  }
}

// `views[n]` all of moment n. Refuses where too few moments differ.
void check_number(const std::vector<std::vector<const NamedView*>>& moments, const char* what, const CalibrationSettings& settings) {
  const auto same = [&](std::size_t a, std::size_t b) {
    for (std::size_t eye = 0; eye < moments[a].size(); ++eye)
      for (std::size_t i = 0; i < moments[a][eye]->board.corners.size(); ++i)
        if ((moments[a][eye]->board.corners[i] - moments[b][eye]->board.corners[i]).norm() > settings.same_view_px) return false;
    return true;
  };
  std::vector<ViewFault> repeated;
  std::vector<std::size_t> kept;
  for (std::size_t n = 0; n < moments.size(); ++n) {
    const auto earlier = std::find_if(kept.begin(), kept.end(), [&](std::size_t k) { return same(k, n); });
    if (earlier == kept.end()) kept.push_back(n);
    else repeated.push_back({moments[n][0]->name, "shows the board where " + moments[*earlier][0]->name + " does; move the board between images"});
  }
  const int number = static_cast<int>(kept.size());
  if (number >= settings.least_views) return;
  const std::string few = sentence("too few %s: %d that differ, at least %d are needed; take more, with the board tilted each way and in all corners of the image",
                                   what, number, settings.least_views);
  if (repeated.empty()) throw_error(ErrorCode::bad_input, few);
  repeated.insert(repeated.begin(), {sentence("all %zu %s", moments.size(), what), few});
  throw BadViews(repeated);
}

std::vector<ViewFault> outliers(const CameraFit& fit, const CalibrationSettings& settings) {
  std::vector<double> errors;
  for (const FittedView& v : fit.views) errors.push_back(v.error_px);
  const double usual = median(errors);
  std::vector<ViewFault> out;
  for (const FittedView& v : fit.views)
    if (v.error_px > settings.outlier_px && v.error_px > settings.outlier_factor * usual)
      out.push_back({v.name, sentence("its error is %.2f px, the median of all %.2f px: a bent board, a wrong corner, or an image of another camera; take it out",
                                      v.error_px, usual)});
  return out;
}

void refuse(std::vector<ViewFault> faults) {
  if (!faults.empty()) throw BadViews(std::move(faults));
}

void check_camera(const CameraFit& fit, const char* which, const CalibrationSettings& settings) {
  bool finite = fit.K.allFinite() && std::isfinite(fit.rms_px) && std::isfinite(fit.focal_sigma_px);
  for (double d : fit.distortion) finite = finite && std::isfinite(d);
  const double f = std::min(fit.K(0, 0), fit.K(1, 1));
  require(finite && f > 0.1 * fit.width && fit.K(0, 2) > 0 && fit.K(0, 2) < fit.width && fit.K(1, 2) > 0 && fit.K(1, 2) < fit.height,
          ErrorCode::bad_input, std::string("the views of the ") + which + " make no camera: its centre lies outside the image; take more, with the board tilted each way");
  require(fit.focal_sigma_px <= settings.focal_sigma * f, ErrorCode::bad_input,
          std::string("the views of the ") + which + sentence(" do not determine its focal length: %.0f px with a standard deviation of %.0f; tilt the board by 30 degrees, each way", f, fit.focal_sigma_px));
}

// Boards seen from one side only leave focal length and distance undetermined.
void check_tilts(const std::vector<Pose>& X_CB, const CalibrationSettings& settings) {
  double greatest = 0;
  for (const Pose& a : X_CB)
    for (const Pose& b : X_CB) greatest = std::max(greatest, std::acos(std::clamp(a.linear().col(2).dot(b.linear().col(2)), -1.0, 1.0)));
  require(greatest >= settings.least_tilt_rad, ErrorCode::bad_input,
          sentence("the board is seen from one side only: its tilts differ by %.0f degrees, %.0f at least are needed; tilt it by 30 degrees, each way",
                   greatest * kDegrees, settings.least_tilt_rad * kDegrees));
}

// The right eye's corners in the order, of those that the board's symmetry allows, in which they lie most like the left's.
void bring_into_order(const BoardView& left, BoardView& right, const Chessboard& board) {
  const int n = board.columns;
  std::vector<std::vector<Eigen::Vector2d>> orders{right.corners, {right.corners.rbegin(), right.corners.rend()}};
  if (board.columns == board.rows) {
    std::vector<Eigen::Vector2d> quarter;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) quarter.push_back(right.corners[static_cast<std::size_t>((n - 1 - i) * n + j)]);
    orders.push_back(quarter);
    orders.emplace_back(quarter.rbegin(), quarter.rend());
  }
  const auto scatter = [&](const std::vector<Eigen::Vector2d>& corners) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < corners.size(); ++i) mean += (corners[i] - left.corners[i]) / static_cast<double>(corners.size());
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) sum += (corners[i] - left.corners[i] - mean).squaredNorm();
    return sum;
  };
  right.corners = *std::min_element(orders.begin(), orders.end(), [&](const auto& a, const auto& b) { return scatter(a) < scatter(b); });
}

// Of the right camera to the left one, by view; and the one that is least far from all others.
struct RelativePoses {
  std::vector<Pose> X_RL;
  Pose usual = Pose::Identity();
};

// Differences that count as one: 3 degrees, a quarter of the baseline.
constexpr double kAngle = 0.052, kShare = 0.25;
double difference(const Pose& a, const Pose& b) {
  return angle_between(a, b) / kAngle + (a.translation() - b.translation()).norm() / (kShare * b.translation().norm());
}

RelativePoses relative_poses(const Solution& left, const Solution& right) {
  RelativePoses out;
  for (std::size_t n = 0; n < left.X_CB.size(); ++n) out.X_RL.push_back(right.X_CB[n] * left.X_CB[n].inverse());
  double least = std::numeric_limits<double>::infinity();
  for (const Pose& candidate : out.X_RL) {
    std::vector<double> differences;
    for (const Pose& other : out.X_RL) differences.push_back(difference(other, candidate));
    if (const double middle = median(differences); middle < least) {
      least = middle;
      out.usual = candidate;
    }
  }
  return out;
}

void check_sides(const Eigen::Vector3d& T, const Chessboard& board) {
  require(T.norm() > 1e-3 * board.square, ErrorCode::bad_input, "left and right show the board from the same place: their images are the same; give each camera's own");
  require(std::abs(T.x()) > std::abs(T.y()) && std::abs(T.x()) > std::abs(T.z()), ErrorCode::bad_input,
          sentence("the cameras do not stand side by side: the right one is displaced by (%.3g, %.3g, %.3g) as the left one sees x, y, z; turn images of cameras above each other by 90 degrees",
                   -T.x(), -T.y(), -T.z()));
  require(T.x() < 0, ErrorCode::bad_input,
          "left and right are exchanged: the camera given as the right one stands to the left of the other; exchange the two folders");
}

// `exchanged`: pairs whose eyes are; otherwise those that do not show one moment.
std::vector<ViewFault> mismatches(const std::vector<std::pair<NamedView, NamedView>>& pairs, const RelativePoses& relative, bool exchanged) {
  std::vector<ViewFault> out;
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const Pose& X = relative.X_RL[n];
    const double as_given = difference(X, relative.usual), the_other_way = difference(X.inverse(), relative.usual);
    if (as_given < 1) continue;
    const std::string name = pairs[n].first.name + " with " + pairs[n].second.name;
    const bool inverse = the_other_way < 2.5 && the_other_way < 0.5 * as_given;  // each seen with the other camera's lens
    if (exchanged && inverse) out.push_back({name, "left and right are exchanged in this pair; exchange its two files"});
    if (!exchanged && !inverse)
      out.push_back({name, sentence("the two do not show the same moment: by this pair the cameras would stand %.3g apart, by the others %.3g, %.1f degrees otherwise; take the pair out, or find its partner",
                                    X.translation().norm(), relative.usual.translation().norm(), angle_between(X, relative.usual) * kDegrees)});
  }
  return out;
}

// The board of pair `n` in the left eye's frame where both eyes' errors are least: Gauss-Newton from `X_LB`.
Pose seen_by_both(const PairFit& fit, const Pose& X_RL, std::size_t n, Pose X_LB, const Chessboard& board) {
  const auto points = board_points(board);
  const auto rows = static_cast<Eigen::Index>(4 * points.size());
  const auto residual = [&](const Pose& X) {
    Eigen::VectorXd out(rows);
    Eigen::Index k = 0;
    for (const CameraFit* eye : {&fit.left, &fit.right}) {
      const auto seen = projected(*eye, eye == &fit.left ? X : X_RL * X, points);
      for (std::size_t i = 0; i < seen.size(); ++i, k += 2) out.segment<2>(k) = seen[i] - eye->views[n].corners[i];
    }
    return out;
  };
  const auto moved = [&](const Pose& X, const Eigen::Matrix<double, 6, 1>& step) {
    const Eigen::Vector3d turn = step.head<3>();
    const double angle = turn.norm();
    const Eigen::Matrix3d R = angle > 0 ? Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() : Eigen::Matrix3d::Identity();
    return make_pose(X.translation() + step.tail<3>(), R * X.linear());
  };
  const double depth = X_LB.translation().norm();
  for (int iteration = 0; iteration < 6; ++iteration) {
    const Eigen::VectorXd r = residual(X_LB);
    Eigen::MatrixXd J(rows, 6);
    for (int c = 0; c < 6; ++c) {
      const double h = c < 3 ? 1e-3 : 1e-3 * depth;  // projectPoints answers in single precision
      Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
      step[c] = h;
      J.col(c) = (residual(moved(X_LB, step)) - residual(moved(X_LB, -step))) / (2 * h);
    }
    X_LB = moved(X_LB, -(J.transpose() * J).ldlt().solve(J.transpose() * r));
  }
  return X_LB;
}

CameraCalibration rectified(const CameraFit& fit, const cv::Mat& R, const cv::Mat& P) {
  CameraCalibration c;
  c.width = fit.width;
  c.height = fit.height;
  c.K = fit.K;
  c.distortion = fit.distortion;
  c.R = to_eigen<3, 3>(R);
  c.P = to_eigen<3, 4>(P);
  return c;
}

double row_difference(const PairFit& fit) {
  double sum = 0;
  std::size_t count = 0;
  const auto rows = [](const FittedView& view, const CameraCalibration& c) {
    Corners out;
    cv::undistortPoints(to_cv(view.corners), out, to_cv(c.K), c.distortion, to_cv(c.R), to_cv(Eigen::Matrix3d(c.P.leftCols<3>())));
    return out;
  };
  for (std::size_t n = 0; n < fit.left.views.size(); ++n) {
    const Corners left = rows(fit.left.views[n], fit.left_rectified), right = rows(fit.right.views[n], fit.right_rectified);
    for (std::size_t i = 0; i < left.size(); ++i, ++count) sum += std::pow(left[i].y - right[i].y, 2);
  }
  return std::sqrt(sum / static_cast<double>(count));
}

std::string listed(const std::vector<ViewFault>& faults) {
  std::string out;
  for (const ViewFault& f : faults) out += (out.empty() ? "" : "\n") + f.name + ": " + f.why;
  return out;
}

}  // namespace

BadViews::BadViews(std::vector<ViewFault> faults) : Error(ErrorCode::bad_input, listed(faults)), faults_(std::move(faults)) {}

void CalibrationSettings::check() const {
  require(least_views >= 3, ErrorCode::bad_input, sentence("a calibration from %d views: 3 at least are needed", least_views));
  require(radial == 2 || radial == 3, ErrorCode::bad_input, sentence("%d radial coefficients: 2 or 3 can be estimated", radial));
  require(outlier_px > 0 && outlier_factor > 1 && same_view_px >= 0 && least_tilt_rad >= 0 && focal_sigma > 0, ErrorCode::bad_input, "limits of outliers, of views alike and of the focal length must be positive");
}

CameraCalibration CameraFit::undistorted() const {
  const cv::Mat P = cv::getOptimalNewCameraMatrix(to_cv(K), distortion, {width, height}, 0);
  cv::Mat wide = cv::Mat::zeros(3, 4, CV_64F);
  P.copyTo(wide.colRange(0, 3));
  return rectified(*this, cv::Mat::eye(3, 3, CV_64F), wide);
}

CameraFit calibrate_camera(const std::vector<NamedView>& views, int width, int height, const Chessboard& board, const CalibrationSettings& settings) {
  settings.check();
  check_views(views, width, height, board);
  std::vector<std::vector<const NamedView*>> moments;
  for (const NamedView& v : views) moments.push_back({&v});
  check_number(moments, "images", settings);
  const Solution solution = solve_camera(views, width, height, board, settings);
  refuse(outliers(solution.fit, settings));
  check_tilts(solution.X_CB, settings);
  check_camera(solution.fit, "camera", settings);
  return solution.fit;
}

PairFit calibrate_pair(const std::vector<std::pair<NamedView, NamedView>>& pairs, int width, int height, const Chessboard& board,
                       const CalibrationSettings& settings) {
  settings.check();
  std::vector<std::vector<const NamedView*>> moments;
  for (const auto& [l, r] : pairs) moments.push_back({&l, &r});
  std::vector<NamedView> left_views, right_views;
  for (const auto& [l, r] : pairs) {
    left_views.push_back(l);
    right_views.push_back(r);
  }
  check_views(left_views, width, height, board);
  check_views(right_views, width, height, board);
  check_number(moments, "pairs", settings);
  for (std::size_t n = 0; n < pairs.size(); ++n) bring_into_order(left_views[n].board, right_views[n].board, board);
  const Solution left = solve_camera(left_views, width, height, board, settings), right = solve_camera(right_views, width, height, board, settings);
  const RelativePoses relative = relative_poses(left, right);
  check_sides(relative.usual.translation(), board);
  refuse(mismatches(pairs, relative, true));
  std::vector<ViewFault> bad = outliers(left.fit, settings);
  for (ViewFault& f : outliers(right.fit, settings)) bad.push_back(std::move(f));
  refuse(std::move(bad));
  refuse(mismatches(pairs, relative, false));
  check_tilts(left.X_CB, settings);
  check_camera(left.fit, "left camera", settings);
  check_camera(right.fit, "right camera", settings);

  PairFit fit;
  fit.left = left.fit;
  fit.right = right.fit;
  std::vector<Corners> left_seen, right_seen;
  for (const NamedView& v : left_views) left_seen.push_back(to_cv(v.board.corners));
  for (const NamedView& v : right_views) right_seen.push_back(to_cv(v.board.corners));
  const std::vector<std::vector<cv::Point3f>> points(pairs.size(), board_points(board));
  cv::Mat K1 = to_cv(fit.left.K), K2 = to_cv(fit.right.K), D1 = cv::Mat(fit.left.distortion, true), D2 = cv::Mat(fit.right.distortion, true);
  cv::Mat R, T, E, F, errors, R1, R2, P1, P2, Q;
  fit.rms_px = solved([&] {
    return cv::stereoCalibrate(points, left_seen, right_seen, K1, D1, K2, D2, {width, height}, R, T, E, F, errors,
                               cv::CALIB_USE_INTRINSIC_GUESS | flags_of(settings), {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-6});
  });
  fit.R = to_eigen<3, 3>(R);
  fit.T = to_eigen<3, 1>(T);
  fit.E = to_eigen<3, 3>(E);
  fit.F = to_eigen<3, 3>(F);
  fit.left.K = to_eigen<3, 3>(K1);
  fit.right.K = to_eigen<3, 3>(K2);
  fit.left.distortion.assign(D1.begin<double>(), D1.end<double>());
  fit.right.distortion.assign(D2.begin<double>(), D2.end<double>());
  require(fit.R.allFinite() && fit.T.allFinite() && std::isfinite(fit.rms_px), ErrorCode::bad_input,
          "these pairs do not determine the cameras; take more, with the board tilted each way");
  check_sides(fit.T, board);

  const Pose X_RL = make_pose(fit.T, fit.R);
  std::vector<Pose> X_LB, X_RB;
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    X_LB.push_back(seen_by_both(fit, X_RL, n, left.X_CB[n], board));
    X_RB.push_back(X_RL * X_LB.back());
  }
  reproject(fit.left, X_LB, board);
  reproject(fit.right, X_RB, board);
  bad = outliers(fit.left, settings);
  for (ViewFault& f : outliers(fit.right, settings)) bad.push_back(std::move(f));
  refuse(std::move(bad));

  cv::stereoRectify(K1, D1, K2, D2, {width, height}, R, T, R1, R2, P1, P2, Q, cv::CALIB_ZERO_DISPARITY, 0);
  fit.left_rectified = rectified(fit.left, R1, P1);
  fit.right_rectified = rectified(fit.right, R2, P2);
  fit.Q = to_eigen<4, 4>(Q);
  require(fit.left_rectified.P.allFinite() && fit.right_rectified.P.allFinite() && fit.left_rectified.P(0, 0) > 0, ErrorCode::bad_input,
          "the two cameras see nothing in common that could be rectified; turn them the same way");
  fit.row_px = row_difference(fit);
  return fit;
}

}  // namespace periplus::vision
