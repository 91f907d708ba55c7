// Writes the folder of a run: looks/NN (pictures and data), models, truth, report.json. Knows no DDS.
//
//   looks/NN/left.png right.png wide.png      as the cameras gave them
//   looks/NN/disparity.npy depth.npy          float32 (height, width); [px], [m]; 0 where there is none
//   looks/NN/disparity.png depth.png          the same for the eye; guessed disparities are darker
//   looks/NN/disparity_filled.png             white where a disparity is a guess
//   looks/NN/color.png                        rectified left image
//   looks/NN/grid.npy                         uint8 (nx, ny, nz): 0 empty 1 unknown 2 known 3 environment, after this look
//   looks/NN/look.json                        camera pose 4x4, rig, grid geometry, gains
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/object_model/perception.h"
#include "common/voxel/occupancy_grid.h"

namespace periplus::supervisor {

struct LookRecord {
  int look = 0;                                // from 1
  Pose X_WC = Pose::Identity();                // left eye, as vision found it
  std::vector<double> configuration;           // of the posture [m, rad]; empty: looked from where it stood
  double predicted_gain_px = -1, predicted_gain_voxels = -1;   // -1: the first look was not planned
  double found_gain_px = 0, found_gain_voxels = 0;
  double valid_share = 0, valid_share_in_box = 0;
  int features = 0;
  voxel::Counts counts;
  std::vector<std::pair<std::string, double>> seconds;         // by state
};

class RunRecorder {
 public:
  // Creates the folder; Error(io) if it cannot, Error(bad_input) if it holds a report already.
  explicit RunRecorder(const std::string& folder);

  const std::string& folder() const { return folder_; }
  std::string look_folder(int look) const;

  void save_text(const std::string& name, std::string_view text) const;
  void save_bytes(const std::string& name, const void* data, std::size_t bytes) const;
  void save_image(int look, const std::string& camera, const ImageU8& image) const;
  void save_perception(int look, const object_model::Perception& perception) const;
  void save_grid(int look, const voxel::OccupancyGrid& grid) const;
  void save_look(const LookRecord& look, const StereoRig& rig) const;
  // Takes the place of an earlier file of that name at one stroke: whoever reads, however it ends, finds the one or the other.
  void save_json(const std::string& name, const nlohmann::json& value) const;

  // The record of a look as it stands in report.json.
  static nlohmann::json to_json(const LookRecord& look);

 private:
  std::string folder_;
};

nlohmann::json to_json(const Pose& X);   // 4x4, row by row
nlohmann::json to_json(const object_model::ObjectBox& box);

}  // namespace periplus::supervisor
