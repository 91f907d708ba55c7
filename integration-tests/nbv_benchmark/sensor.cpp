#include "integration-tests/nbv_benchmark/sensor.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/core/error.h"
#include "common/render/renderer.h"
#include "services/simulator/camera_sensor.h"
#include "services/vision_server/box_silhouette.h"
#include "services/vision_server/depth.h"
#include "services/vision_server/disparity_filter.h"
#include "services/vision_server/match_range.h"
#include "services/vision_server/stereo_matcher.h"

namespace periplus::nbv_benchmark {
namespace {

// Slack of "the other eye sees this point": slanted surfaces between two pixels [share of the depth].
constexpr double kSeenByOther = 2e-3;
constexpr double kTextureSlack = 1.25;
constexpr double kLeastDepth = 0.4, kDefaultFar = 6.5;   // as the vision server's default configuration [m]
constexpr double kNoise = 2, kRightGain = 1.03, kRightOffset = 2;   // grey levels; as the simulator's

Pose right_eye(const Pose& X_WC, const StereoRig& rig) { return X_WC * Pose(Eigen::Translation3d(rig.baseline, 0, 0)); }

object_model::DepthMap depth_map(const Pinhole& camera, const Pose& X_WC, ImageF depth) {
  object_model::DepthMap map;
  map.camera = camera;
  map.X_WC = X_WC;
  map.depth_minimum = depth;
  map.depth = std::move(depth);
  map.depth_sigma = ImageF(camera.width, camera.height);
  return map;
}

// Removes what the other eye does not see; it stands `shift` metres along x.
ImageF seen_by_other(const ImageF& mine, const ImageF& other, const Pinhole& camera, double shift) {
  ImageF out = mine;
  for (int v = 0; v < mine.height; ++v)
    for (int u = 0; u < mine.width; ++u) {
      const double z = mine.at(u, v), x = u - camera.fx * shift / z;
      const int left = static_cast<int>(std::floor(x));
      bool seen = x >= 0 && x <= mine.width - 1;
      if (seen) {
        const double behind = std::max(other.at(left, v), other.at(std::min(left + 1, mine.width - 1), v));
        seen = z <= behind * (1 + kSeenByOther);
      }
      if (!seen) out.at(u, v) = 0;
    }
  return out;
}

class IdealSensor : public Sensor {
 public:
  explicit IdealSensor(const Arena& arena) : arena_(arena) {}

  Look look(const Pose& X_WC, int) override {
    const Pinhole& camera = arena_.rig.camera;
    Look out;
    ImageF left = arena_.truth.render(X_WC, camera, kBackground);
    if (!arena_.pair) {
      out.depth.push_back(depth_map(camera, X_WC, std::move(left)));
      return out;
    }
    const Pose X_WR = right_eye(X_WC, arena_.rig);
    const ImageF right = arena_.truth.render(X_WR, camera, kBackground);
    out.depth.push_back(depth_map(camera, X_WC, seen_by_other(left, right, camera, arena_.rig.baseline)));
    out.depth.push_back(depth_map(camera, X_WR, seen_by_other(right, left, camera, -arena_.rig.baseline)));
    return out;
  }

 private:
  const Arena& arena_;
};

render::RendererOptions one_thread() {
  render::RendererOptions o;
  o.threads = 1;
  return o;
}

render::TrueObject painted(const Subject& subject, const Pose& X_WO) {
  render::TrueObject object;
  object.path = subject.file.path;
  object.texture = subject.file.texture.empty() ? "noise:5" : subject.file.texture;
  object.mesh_W = subject.mesh;
  mesh::compute_normals(object.mesh_W);
  if (subject.file.texture.empty() || object.mesh_W.corner_uv.empty())
    mesh::unwrap_six_tiles(object.mesh_W, kTextureSlack * mesh::bounds(object.mesh_W).size().maxCoeff());
  mesh::transform(object.mesh_W, X_WO);
  object.X_WM = X_WO;
  return object;
}

ImageU8 grey(const ImageU8& rgb) {
  ImageU8 out(rgb.width, rgb.height);
  // ITU-R BT.601, as every camera driver has it.
  for (std::size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = static_cast<std::uint8_t>(std::lround(0.299 * rgb.data[3 * i] + 0.587 * rgb.data[3 * i + 1] + 0.114 * rgb.data[3 * i + 2]));
  return out;
}

class StereoSensor : public Sensor {
 public:
  StereoSensor(const Arena& arena, const Subject& subject, std::uint64_t seed)
      : arena_(arena), seed_(seed), renderer_(arena.scene, {painted(subject, arena.X_WO)}, one_thread()) {
    require(arena.pair, ErrorCode::bad_input, "stereo needs the robot's pair of cameras");
  }

  Look look(const Pose& X_WC, int number) override {
    const StereoRig& rig = arena_.rig;
    const Pose X_WR = right_eye(X_WC, rig);
    const ImageU8 left = picture(X_WC, {1, 0, kNoise}, number, "left");
    const ImageU8 right = picture(X_WR, {kRightGain, kRightOffset, kNoise}, number, "right");
    const vision::DepthRange range = vision::depth_range(rig, X_WC, arena_.box, &arena_.scene, kLeastDepth, kDefaultFar);
    const vision::DisparityPair disparity = vision::match(left, right, vision::disparity_range(rig, range), {});
    const double distance = (X_WC.inverse() * arena_.box.X_WB.translation()).z();
    Look out;
    out.depth.push_back(vision::make_depth(disparity.left, rig, X_WC, {}, distance));
    out.depth.push_back(vision::make_depth(disparity.right, rig, X_WR, {}, distance));
    out.silhouette_valid_share =
        vision::valid_share(disparity.left, vision::box_silhouette(rig.camera, X_WC, arena_.box), rig.disparity(distance));
    const auto share = vision::object_valid_share(disparity.left, vision::fill_disparity(disparity.left, left).disparity, rig, X_WC, arena_.box,
                                                  arena_.collision.get());
    if (share) out.silhouette_valid_share = std::min(out.silhouette_valid_share, *share);
    return out;
  }

 private:
  ImageU8 picture(const Pose& X_WC, const simulator::CameraSensor& camera, int number, const char* eye) {
    render::RenderedView view = renderer_.render(X_WC, arena_.rig.camera);
    simulator::expose(view.colour, camera, simulator::picture_seed(seed_, std::to_string(number), eye));
    return grey(view.colour);
  }

  const Arena& arena_;
  std::uint64_t seed_;
  render::Renderer renderer_;
};

}  // namespace

const char* to_string(SensorKind kind) { return kind == SensorKind::ideal ? "ideal" : "stereo"; }

std::unique_ptr<Sensor> make_sensor(SensorKind kind, const Arena& arena, const Subject& subject, std::uint64_t seed) {
  if (kind == SensorKind::ideal) return std::make_unique<IdealSensor>(arena);
  return std::make_unique<StereoSensor>(arena, subject, seed);
}

}  // namespace periplus::nbv_benchmark
