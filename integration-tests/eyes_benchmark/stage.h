// What the eyes look at: an object on a table in a room, and six ideal views of it as rendered pairs with their truth.
//
// World frame W: z up, the table's middle above the origin. Metres, pixels. Poses are the left eye's.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/geometry/camera.h"
#include "common/mesh/triangle_mesh.h"
#include "common/mesh/triangle_tree.h"
#include "common/object_model/object_model.h"
#include "common/scene/scene.h"
#include "integration-tests/nbv_benchmark/depth_scene.h"
#include "services/vision_server/rectification.h"

namespace periplus::eyes_benchmark {

inline constexpr double kTable = 0.75;        // height of its top [m]
inline constexpr double kDistance = 1.2;      // from the middle of the eyes to the object's middle [m]
inline constexpr double kTableSkin = 0.004;   // lower than this above the table, surface is the table's [m]
inline constexpr float kBackground = 6;       // true depth of what is neither object nor table [m]

// 640 x 480, 25 degrees vertically (f = 1082 px), 144 mm.
StereoRig robot_eyes();

// rich: noise on all scales with marks; weak: the same without marks, within 32 grey levels; none: one colour, so that only
// its shading shows the shape; own: the file's picture.
enum class Paint { rich, weak, none, own };
const char* to_string(Paint paint);

struct Stage {
  std::string object;
  scene::Scene scene;                                      // room and table
  std::shared_ptr<const scene::CollisionWorld> solids;
  object_model::ObjectBox box;                             // 3 cm about the object, on the table
  object_model::Surroundings surroundings;
  mesh::TriangleMesh mesh_W;
  std::shared_ptr<const mesh::TriangleTree> tree;
  Eigen::Vector3d middle{0, 0, 0};                         // of the object's bounding box
  nbv_benchmark::DepthScene with_table, alone;
};

// `file` below the assets folder, its y axis up; the longest side becomes `longest_side`. Throws Error(io) if it is missing.
Stage make_stage(const std::string& object, const std::string& file, double longest_side);
// For tests: any mesh that stands on the table already.
Stage make_stage(const std::string& object, mesh::TriangleMesh mesh_W);

// Every 60 degrees, at heights of 1.25, 1.05 and 1.4 m in turn.
std::vector<Pose> six_views(const Stage& stage);

// From the place of the first of six_views(), turned about the vertical through the object's middle by each of `degrees`.
std::vector<Pose> turned_views(const Stage& stage, const std::vector<double>& degrees);

// One eye's truth. `object` is 255 where the object is seen.
struct EyeTruth {
  Pose X_WC = Pose::Identity();
  ImageF depth;
  ImageU8 object;
};
EyeTruth true_eye(const Stage& stage, const Pinhole& camera, const Pose& X_WC);

struct Shot {
  vision::RectifiedPair pair;
  EyeTruth left, right;
};

struct SensorSettings {
  double noise = 2, right_gain = 1.03, right_offset = 2;  // grey levels
  std::uint64_t seed = 1;
};

// `file` and `longest_side` as the stage was made with; `poses` of left eyes. Throws Error(sim_render_failed) where nothing can be drawn.
std::vector<Shot> take_pictures(const Stage& stage, const std::string& file, double longest_side, Paint paint, const SensorSettings& sensor,
                                const std::vector<Pose>& poses);

// Points of the surface above the table that the left eye sees, unoccluded, from at least one of 192 places around: 48 directions
// at heights of 1, 1.13, 1.26 and 1.4 m. Of `samples` area-uniform ones.
std::vector<Eigen::Vector3d> visible_surface(const Stage& stage, std::size_t samples, std::uint64_t seed);

}  // namespace periplus::eyes_benchmark
