#include "services/vision_server/calibration_file.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/core/eigen.hpp>
#include <opencv2/core/persistence.hpp>

namespace periplus::vision {
namespace {

template <class Matrix>
cv::Mat matrix(const Matrix& m) {
  cv::Mat out;
  cv::eigen2cv(Eigen::Matrix<double, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime>(m), out);
  return out;
}

cv::Mat row(const std::vector<double>& values) { return cv::Mat(values, true).reshape(1, 1); }

cv::FileStorage to_memory() { return {".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML}; }

void write_board(cv::FileStorage& file, const Chessboard& board, std::size_t views, double rms) {
  file << "board_width" << board.columns << "board_height" << board.rows << "square_size" << board.square;
  file << "nframes" << static_cast<int>(views) << "avg_reprojection_error" << rms;
}

}  // namespace

std::string camera_yaml(const CameraFit& fit, const CameraCalibration& rectified, const std::string& name, const Chessboard& board) {
  cv::FileStorage file = to_memory();
  file << "image_width" << fit.width << "image_height" << fit.height << "camera_name" << name;
  file << "camera_matrix" << matrix(fit.K) << "distortion_model"
       << "plumb_bob"
       << "distortion_coefficients" << row(fit.distortion);
  file << "rectification_matrix" << matrix(rectified.R) << "projection_matrix" << matrix(rectified.P);
  write_board(file, board, fit.views.size(), fit.rms_px);
  return file.releaseAndGetString();
}

std::string pair_yaml(const PairFit& fit, const Chessboard& board) {
  cv::FileStorage file = to_memory();
  file << "image_width" << fit.left.width << "image_height" << fit.left.height;
  file << "M1" << matrix(fit.left.K) << "D1" << row(fit.left.distortion) << "M2" << matrix(fit.right.K) << "D2" << row(fit.right.distortion);
  file << "R" << matrix(fit.R) << "T" << matrix(fit.T) << "E" << matrix(fit.E) << "F" << matrix(fit.F);
  file << "R1" << matrix(fit.left_rectified.R) << "P1" << matrix(fit.left_rectified.P);
  file << "R2" << matrix(fit.right_rectified.R) << "P2" << matrix(fit.right_rectified.P) << "Q" << matrix(fit.Q);
  write_board(file, board, fit.left.views.size(), fit.rms_px);
  return file.releaseAndGetString();
}

std::string view_camera_yaml(const StereoRig& rig, const std::string& name) {
  char text[600];
  std::snprintf(text, sizeof text,
                "schema: periplus-camera-1\nname: %s\nresolution_px: [%d, %d]\nfocal_px: [%.9g, %.9g]\ncenter_px: [%.9g, %.9g]\nbaseline_m: %.9g\n",
                name.c_str(), rig.camera.width, rig.camera.height, rig.camera.fx, rig.camera.fy, rig.camera.cx, rig.camera.cy, rig.baseline);
  return text;
}

void write_files(const std::string& folder, const std::vector<std::pair<std::string, std::string>>& files) {
  namespace fs = std::filesystem;
  std::error_code problem;
  fs::create_directories(folder, problem);
  std::vector<std::pair<fs::path, fs::path>> renames;
  const auto give_up = [&](const fs::path& path) {
    for (const auto& [part, target] : renames) fs::remove(part, problem);
    throw_error(ErrorCode::io, "cannot write " + path.string() + "; choose a folder that exists and may be written, on a disk with space");
  };
  for (const auto& [name, bytes] : files) {
    const fs::path target = fs::path(folder) / name, part = target.string() + ".part";
    if (fs::is_directory(target, problem)) give_up(target);
    renames.emplace_back(part, target);
    std::ofstream out(part, std::ios::binary);
    out << bytes << std::flush;
    if (!out.good()) give_up(target);
  }
  for (const auto& [part, target] : renames) {
    fs::rename(part, target, problem);
    if (problem) give_up(target);
  }
}

}  // namespace periplus::vision
