#include "services/supervisor/run_recorder.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/core/error.h"

namespace periplus::supervisor {

namespace fs = std::filesystem;

namespace {

// NumPy's .npy format 1.0, C order, little-endian.
std::string npy_header(const std::string& descr, const std::vector<int>& shape) {
  std::string dict = "{'descr': '" + descr + "', 'fortran_order': False, 'shape': (";
  for (const int n : shape) dict += std::to_string(n) + ", ";
  dict += "), }";
  const std::size_t unpadded = 10 + dict.size() + 1;
  dict += std::string((64 - unpadded % 64) % 64, ' ') + "\n";
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(dict.size() & 255);
  header += static_cast<char>(dict.size() >> 8);
  return header + dict;
}

std::string npy(const ImageF& image) {
  std::string bytes = npy_header("<f4", {image.height, image.width});
  bytes.append(reinterpret_cast<const char*>(image.data.data()), image.data.size() * sizeof(float));
  return bytes;
}

void write_png(const std::string& path, const cv::Mat& image) {
  bool written = false;
  try {
    written = cv::imwrite(path, image);
  } catch (const cv::Exception&) {
  }
  require(written, ErrorCode::io, "cannot write " + path);
}

cv::Mat to_mat(const ImageU8& image) {
  require((image.channels == 1 || image.channels == 3) && image.width > 0 && image.height > 0, ErrorCode::bad_size,
          "a picture needs 1 or 3 channels and a size");
  const cv::Mat view(image.height, image.width, image.channels == 3 ? CV_8UC3 : CV_8UC1, const_cast<std::uint8_t*>(image.data.data()));
  cv::Mat bgr = view;
  if (image.channels == 3) cv::cvtColor(view, bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

// Near is bright; pixels without a value are black.
cv::Mat coloured(const ImageF& image, bool inverse) {
  float low = 1e30f, high = 0;
  for (const float v : image.data)
    if (v > 0) low = std::min(low, v), high = std::max(high, v);
  cv::Mat grey(image.height, image.width, CV_8UC1, cv::Scalar(0)), picture;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (const float v = image.at(x, y); v > 0) {
        const float t = high > low ? (v - low) / (high - low) : 1.f;
        grey.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(255 * (inverse ? 1 - t : t));
      }
  cv::applyColorMap(grey, picture, cv::COLORMAP_VIRIDIS);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (image.at(x, y) <= 0) picture.at<cv::Vec3b>(y, x) = {0, 0, 0};
  return picture;
}

}  // namespace

nlohmann::json to_json(const Pose& X) {
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({X.matrix()(r, 0), X.matrix()(r, 1), X.matrix()(r, 2), X.matrix()(r, 3)});
  return rows;
}

nlohmann::json to_json(const object_model::ObjectBox& box) {
  return {{"pose_world_box", to_json(box.X_WB)}, {"size_m", {box.size.x(), box.size.y(), box.size.z()}}};
}

RunRecorder::RunRecorder(const std::string& folder) : folder_(folder) {
  require(!fs::exists(folder + "/report.json"), ErrorCode::bad_input, folder + " holds a run already; give another run id");
  std::error_code error;
  fs::create_directories(folder + "/looks", error);
  require(!error, ErrorCode::io, "cannot create " + folder + ": " + error.message() + "; choose an output folder that can be written");
}

std::string RunRecorder::look_folder(int look) const {
  char name[24];
  std::snprintf(name, sizeof name, "/looks/%02d", look);
  const std::string path = folder_ + name;
  fs::create_directories(path);
  return path;
}

void RunRecorder::save_bytes(const std::string& name, const void* data, std::size_t bytes) const {
  const std::string path = folder_ + "/" + name;
  std::ofstream file(path, std::ios::binary);
  file.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  file.close();
  require(file.good(), ErrorCode::io, "cannot write " + path + ": " + std::strerror(errno));
}

void RunRecorder::save_text(const std::string& name, std::string_view text) const { save_bytes(name, text.data(), text.size()); }

void RunRecorder::save_json(const std::string& name, const nlohmann::json& value) const {
  save_text(name + ".new", value.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  std::error_code error;
  fs::rename(folder_ + "/" + name + ".new", folder_ + "/" + name, error);
  require(!error, ErrorCode::io, "cannot write " + folder_ + "/" + name + ": " + error.message());
}

void RunRecorder::save_image(int look, const std::string& camera, const ImageU8& image) const {
  write_png(look_folder(look) + "/" + camera + ".png", to_mat(image));
}

void RunRecorder::save_perception(int look, const object_model::Perception& p) const {
  const std::string folder = look_folder(look), relative = fs::relative(folder, folder_).string();
  if (!p.disparity.empty()) {
    save_text(relative + "/disparity.npy", npy(p.disparity));
    cv::Mat picture = coloured(p.disparity, false);
    if (!p.disparity_filled.empty()) {
      const cv::Mat filled = to_mat(p.disparity_filled);
      cv::Mat(picture * 0.5).copyTo(picture, filled);
      write_png(folder + "/disparity_filled.png", filled);
    }
    write_png(folder + "/disparity.png", picture);
  }
  if (!p.depth.empty()) {
    save_text(relative + "/depth.npy", npy(p.depth[0].depth));
    write_png(folder + "/depth.png", coloured(p.depth[0].depth, true));
  }
  if (!p.color.empty()) write_png(folder + "/color.png", to_mat(p.color));
}

void RunRecorder::save_grid(int look, const voxel::OccupancyGrid& grid) const {
  const Eigen::Vector3i n = grid.geometry().size;
  std::string bytes = npy_header("|u1", {n.x(), n.y(), n.z()});
  for (int x = 0; x < n.x(); ++x)
    for (int y = 0; y < n.y(); ++y)
      for (int z = 0; z < n.z(); ++z) bytes += static_cast<char>(grid.state({x, y, z}));
  const std::string relative = fs::relative(look_folder(look), folder_).string();
  save_text(relative + "/grid.npy", bytes);
  save_json(relative + "/grid.json", {{"pose_world_grid", supervisor::to_json(grid.geometry().X_WG)},
                                      {"voxel_m", grid.geometry().voxel_size},
                                      {"size", {n.x(), n.y(), n.z()}},
                                      {"revision", grid.revision}});
}

nlohmann::json RunRecorder::to_json(const LookRecord& l) {
  nlohmann::json seconds = nlohmann::json::object();
  for (const auto& [name, value] : l.seconds) seconds[name] = seconds.value(name, 0.0) + value;
  const auto planned = [](double v) { return v < 0 ? nlohmann::json() : nlohmann::json(v); };
  return {{"look", l.look},
          {"pose_world_camera", supervisor::to_json(l.X_WC)},
          {"configuration", l.configuration},
          {"predicted_gain_px", planned(l.predicted_gain_px)},
          {"predicted_gain_voxels", planned(l.predicted_gain_voxels)},
          {"found_gain_px", l.found_gain_px},
          {"found_gain_voxels", l.found_gain_voxels},
          {"valid_share", l.valid_share},
          {"valid_share_in_box", l.valid_share_in_box},
          {"features", l.features},
          {"voxels", {{"unknown", l.counts.unknown}, {"known", l.counts.known}, {"empty", l.counts.empty}, {"environment", l.counts.environment}}},
          {"seconds", seconds}};
}

void RunRecorder::save_look(const LookRecord& look, const StereoRig& rig) const {
  nlohmann::json j = to_json(look);
  j["rig"] = {{"width", rig.camera.width}, {"height", rig.camera.height}, {"fx", rig.camera.fx}, {"fy", rig.camera.fy},
              {"cx", rig.camera.cx},       {"cy", rig.camera.cy},         {"baseline_m", rig.baseline}};
  save_json(fs::relative(look_folder(look.look), folder_).string() + "/look.json", j);
}

}  // namespace periplus::supervisor
