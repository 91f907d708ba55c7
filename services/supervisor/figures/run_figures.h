// Figures of a run, from its folder alone, as thesis Fig. 3.9, 3.10 and 5.9 show them:
//   <task>-postures.png   the room with the robot in each posture that it looked from, numbered, around the model that it made
//   <task>-unknown.png    the model from four sides and from above; green is what is still unknown on it: within two voxels of known
//                         ones (what lies elsewhere in the box, above all that can be seen, would hide it)
//   <task>-looks.png      the voxels known after each look
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry/image.h"
#include "common/geometry/pose.h"
#include "common/mesh/triangle_mesh.h"
#include "common/robot/robot_model.h"

namespace periplus::supervisor {

struct FigureOptions {
  std::optional<double> azimuth_deg;  // where the pictures are taken from, from +x to +y; otherwise from where most robots are seen
  double elevation_deg = 38;          // of the picture of the postures
  int width = 1400, height = 1000;    // of that picture
};

// Writes the three pictures into `folder` and returns their paths. Throws Error(io | bad_input) for a folder that holds no run with
// a model.
std::vector<std::string> write_figures(const std::string& run, const std::string& folder, const FigureOptions& options = {});

// What looks/NN/grid.npy and grid.json tell.
struct RecordedGrid {
  Pose X_WG = Pose::Identity();
  double voxel_m = 0;
  Eigen::Vector3i size{0, 0, 0};
  std::vector<std::uint8_t> states;  // x slowest, z fastest: 0 empty 1 unknown 2 known 3 environment

  // Beyond the grid: nothing.
  std::optional<std::uint8_t> at(const Eigen::Vector3i& v) const;
};
RecordedGrid read_recorded_grid(const std::string& look_folder);

// The faces of the voxels of one state that border on empty space or on the outside of the grid, in the world, in one colour (0..1).
mesh::TriangleMesh exposed_faces(const RecordedGrid& grid, std::uint8_t state, const Eigen::Vector3d& colour);

// The grid with those unknown voxels emptied that have no known one within `reach` voxels.
RecordedGrid only_near_known(const RecordedGrid& grid, int reach);

// The robot's capsules at a configuration.
mesh::TriangleMesh robot_mesh(const std::shared_ptr<const robot::RobotModel>& robot, const Eigen::VectorXd& configuration);

}  // namespace periplus::supervisor
