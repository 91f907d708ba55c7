#include "services/supervisor/figures/run_figures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <unordered_map>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/mesh/part_builder.h"
#include "common/render/renderer.h"
#include "common/scene/scene.h"
#include "services/supervisor/model_view.h"

namespace periplus::supervisor {

using nlohmann::json;
using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

constexpr double kDegrees = std::numbers::pi / 180;
const Vector3d kGreen(0.15, 0.85, 0.25);
constexpr int kReach = 2;  // voxels
constexpr std::uint8_t kEmpty = 0, kUnknown = 1, kKnown = 2;

json read_json_file(const std::string& path) {
  try {
    return json::parse(read_file(path));
  } catch (const json::exception& e) {
    throw_error(ErrorCode::bad_input, path + ": " + e.what());
  }
}

Pose pose_from_rows(const json& rows) {
  Pose X = Pose::Identity();
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c) X.matrix()(static_cast<int>(r), static_cast<int>(c)) = rows.at(r).at(c).get<double>();
  return X;
}

std::string two_digits(int look) { return (look < 10 ? "0" : "") + std::to_string(look); }

// Faces of one colour each are painted by a palette: 16 levels of red, green, blue.
constexpr int kLevels = 16, kPaletteSide = 64;
ImageU8 palette() {
  ImageU8 image(kPaletteSide, kPaletteSide, 3);
  for (int i = 0; i < kPaletteSide * kPaletteSide; ++i)
    for (int c = 0; c < 3; ++c) image.at(i % kPaletteSide, i / kPaletteSide, c) = static_cast<std::uint8_t>((i >> (4 * (2 - c)) & 15) * 17);
  return image;
}

render::TrueObject painted_by_vertex(mesh::TriangleMesh mesh) {
  render::TrueObject object;
  object.picture = palette();
  mesh::compute_normals(mesh);
  mesh.corner_uv.clear();
  for (const Vector3i& t : mesh.triangles) {
    Vector3d colour(0.7, 0.7, 0.7);
    if (!mesh.colours.empty()) {
      colour.setZero();
      for (int k = 0; k < 3; ++k) colour += mesh.colours[static_cast<std::size_t>(t[k])] / 3;
    }
    int at = 0;
    for (int c = 0; c < 3; ++c) at = at * kLevels + std::clamp(static_cast<int>(std::lround(colour[c] * (kLevels - 1))), 0, kLevels - 1);
    const Eigen::Vector2d uv((at % kPaletteSide + 0.5) / kPaletteSide, 1 - (at / kPaletteSide + 0.5) / kPaletteSide);
    mesh.corner_uv.insert(mesh.corner_uv.end(), 3, uv);
  }
  object.mesh_W = std::move(mesh);
  return object;
}

mesh::TriangleMesh joined(mesh::TriangleMesh a, const mesh::TriangleMesh& b) {
  const int first = static_cast<int>(a.vertices.size());
  if (a.colours.empty()) a.colours.assign(a.vertices.size(), {0.72, 0.72, 0.75});
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Vector3d& c : b.colours) a.colours.push_back(c);
  a.colours.resize(a.vertices.size(), Vector3d(0.72, 0.72, 0.75));
  for (const Vector3i& t : b.triangles) a.triangles.push_back(t + Vector3i::Constant(first));
  a.corner_uv.clear();
  a.corner_normals.clear();
  return a;
}

cv::Mat to_bgr(const ImageU8& image) {
  const cv::Mat rgb(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.data.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  return bgr;
}

void write_picture(const std::string& path, const cv::Mat& picture) { require(cv::imwrite(path, picture), ErrorCode::io, "cannot write " + path); }

// A run as its folder tells it.
struct Run {
  json report;
  scene::Scene scene;
  std::shared_ptr<const robot::RobotModel> robot;
  mesh::TriangleMesh model;
  std::vector<int> looks;
  std::vector<Pose> eyes;                      // left eye at each look
  std::vector<Eigen::VectorXd> configurations;  // at each look
  std::vector<double> coverage;                // -1: not evaluated
  std::string folder;

  std::string look_folder(std::size_t i) const { return folder + "/looks/" + two_digits(looks[i]); }
};

Run read_run(const std::string& folder) {
  Run run;
  run.folder = folder;
  run.report = read_json_file(folder + "/report.json");
  run.scene = scene::parse_scene(read_file(folder + "/scene.yaml"), folder + "/scene.yaml");
  run.robot = robot::RobotModel::load_files(folder + "/robot.urdf", folder + "/robot.yaml");
  run.model = mesh::load(folder + "/model.ply");
  robot::Kinematics kinematics(run.robot);
  kinematics.set(run.robot->half_sitting());
  const Pose eye = kinematics.X_WC("left");
  try {
    for (const json& look : run.report.at("looks")) {
      run.looks.push_back(look.at("look").get<int>());
      const Pose X_WC = pose_from_rows(look.at("pose_world_camera"));
      run.eyes.push_back(X_WC);
      run.coverage.push_back(look.value("coverage", -1.0));
      const auto q = look.value("configuration", std::vector<double>{});
      if (static_cast<int>(q.size()) == run.robot->dof()) {
        run.configurations.push_back(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
      } else {
        // The first look is taken as the robot stood: half-sitting, where its left eye was.
        const double yaw = camera_yaw_pitch_roll(X_WC)[0];
        const Eigen::Vector2d behind = Eigen::Rotation2Dd(yaw) * eye.translation().head<2>();
        run.configurations.push_back(run.robot->half_sitting({X_WC.translation().x() - behind.x(), X_WC.translation().y() - behind.y(), yaw}));
      }
    }
  } catch (const json::exception& e) {
    throw_error(ErrorCode::bad_input, folder + "/report.json: " + e.what());
  }
  require(!run.looks.empty(), ErrorCode::bad_input, folder + " holds a run without a look");
  return run;
}

// What must be in the picture of the postures.
std::vector<Vector3d> worth_seeing(const Run& run, const RecordedGrid& grid) {
  std::vector<Vector3d> points;
  for (const Eigen::VectorXd& q : run.configurations) {
    robot::Kinematics kinematics(run.robot);
    kinematics.set(q);
    for (std::size_t i = 0; i < run.robot->capsules().size(); ++i) {
      Vector3d a, b;
      kinematics.capsule(static_cast<int>(i), a, b);
      points.push_back(a);
    }
  }
  const Vector3d size = grid.size.cast<double>() * grid.voxel_m;
  for (int c = 0; c < 8; ++c) points.push_back(grid.X_WG * size.cwiseProduct(Vector3d(c & 1, c >> 1 & 1, c >> 2 & 1)));
  return points;
}

// The nearest camera in the given direction that has all points in its picture, with a rim of 8 %.
Pose frame(const std::vector<Vector3d>& points, double azimuth, double elevation, const Pinhole& camera) {
  Vector3d low = points[0], high = points[0];
  for (const Vector3d& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vector3d back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  Vector3d middle = (low + high) / 2;
  double distance = 2;
  for (int i = 0; i < 400; ++i) {
    const Pose X_WC = look_along(middle + distance * back, azimuth + std::numbers::pi, elevation);
    Eigen::Vector2d least(1e9, 1e9), most(-1e9, -1e9);
    bool before = true;
    for (const Vector3d& p : points) {
      const Vector3d p_C = X_WC.inverse() * p;
      if (p_C.z() < 0.3) { before = false; continue; }
      const Eigen::Vector2d uv = camera.project(p_C);
      least = least.cwiseMin(uv), most = most.cwiseMax(uv);
    }
    const Eigen::Vector2d size(camera.width, camera.height), rim = 0.08 * size;
    if (before && ((most - least).array() <= (size - 2 * rim).array()).all()) {
      // Shifted so that they stand in the middle.
      const Eigen::Vector2d off = (least + most) / 2 - size / 2;
      const Pose centred(X_WC * Eigen::Translation3d(off.x() / camera.fx * distance, off.y() / camera.fy * distance, 0));
      return centred;
    }
    distance *= 1.02;
  }
  throw_error(ErrorCode::internal, "the run does not fit into a picture");
}

// From where most of the robots' heads and chests are seen past the solids and the object's box.
double best_azimuth(const Run& run, const RecordedGrid& grid, double elevation) {
  const scene::CollisionWorld world(run.scene);
  const Vector3d size = grid.size.cast<double>() * grid.voxel_m, centre = grid.X_WG * (size / 2);
  double best = 0, most = -1;
  for (int k = 0; k < 36; ++k) {
    const double azimuth = 10 * k * kDegrees;
    const Vector3d back(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    double seen = 0;
    const auto free = [&](const Vector3d& p) {
      if (world.first_hit(p + 0.3 * back, p + 12 * back)) return false;
      for (double t = 0.1; t < 6; t += 0.1) {
        const Vector3d p_G = grid.X_WG.inverse() * (p + t * back);
        if ((p_G.array() > 0.15 * size.array()).all() && (p_G.array() < 0.85 * size.array()).all()) return false;
      }
      return true;
    };
    for (const Pose& eye : run.eyes)
      for (const double down : {0.0, 0.5, 0.9}) seen += free(eye.translation() - Vector3d(0, 0, down));
    for (const double up : {-0.3, 0.0, 0.3}) seen += 2 * !world.first_hit(centre + Vector3d(0, 0, up * size.z()), centre + Vector3d(0, 0, up * size.z()) + 12 * back);
    if (seen > most) most = seen, best = azimuth;
  }
  return best;
}

Vector3d look_colour(std::size_t i, std::size_t count) {
  cv::Mat value(1, 1, CV_8UC1, cv::Scalar(count > 1 ? 40 + 190.0 * static_cast<double>(i) / static_cast<double>(count - 1) : 120)), colour;
  cv::applyColorMap(value, colour, cv::COLORMAP_TURBO);
  const auto c = colour.at<cv::Vec3b>(0, 0);
  return 0.35 * Vector3d::Constant(1) + 0.65 * Vector3d(c[2], c[1], c[0]) / 255;
}

// A number in a disc over the head, moved up while it would cover another one.
void label(cv::Mat& picture, cv::Point head, int look, const Vector3d& colour, std::vector<cv::Point>& taken) {
  cv::Point at(head.x, head.y - 34);
  for (bool moved = true; moved;) {
    moved = false;
    for (const cv::Point& other : taken)
      if (std::hypot(other.x - at.x, other.y - at.y) < 40) at.y -= 8, moved = true;
  }
  taken.push_back(at);
  cv::line(picture, head, at, {60, 60, 60}, 1, cv::LINE_AA);
  cv::circle(picture, at, 18, {255 * colour.z(), 255 * colour.y(), 255 * colour.x()}, cv::FILLED, cv::LINE_AA);
  cv::circle(picture, at, 18, {40, 40, 40}, 2, cv::LINE_AA);
  const std::string text = std::to_string(look);
  int below = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, 0.65, 2, &below);
  cv::putText(picture, text, {at.x - size.width / 2, at.y + size.height / 2}, cv::FONT_HERSHEY_SIMPLEX, 0.65, {20, 20, 20}, 2, cv::LINE_AA);
}

cv::Mat postures(const Run& run, const RecordedGrid& grid, const mesh::TriangleMesh& shown, const FigureOptions& o) {
  const double elevation = o.elevation_deg * kDegrees;
  const double azimuth = o.azimuth_deg ? *o.azimuth_deg * kDegrees : best_azimuth(run, grid, elevation);
  const double focal = o.height / 2.0 / std::tan(14 * kDegrees);
  const Pinhole camera{o.width, o.height, focal, focal, (o.width - 1) / 2.0, (o.height - 1) / 2.0};
  const Pose X_WC = frame(worth_seeing(run, grid), azimuth, elevation, camera);

  scene::Scene stage = run.scene;
  stage.room = {{60, 60, 40}, "", ""};
  stage.lights = {{{4 * std::cos(azimuth + 0.9), 4 * std::sin(azimuth + 0.9), 8}, 0.75}, {{6 * std::cos(azimuth - 0.6), 6 * std::sin(azimuth - 0.6), 4}, 0.45}};
  for (scene::Solid& solid : stage.solids) {
    solid.texture.clear();
    solid.rgb = solid.supports_object ? Vector3d(0.72, 0.58, 0.42) : Vector3d(0.62, 0.64, 0.68);
  }
  stage.landmarks.clear();
  std::vector<render::TrueObject> objects{painted_by_vertex(shown)};
  for (std::size_t i = 0; i < run.looks.size(); ++i) {
    render::TrueObject body;
    body.mesh_W = robot_mesh(run.robot, run.configurations[i]);
    body.rgb = look_colour(i, run.looks.size());
    objects.push_back(body);
    render::TrueObject gaze;  // a stick along the optical axis
    mesh::PartBuilder stick(1);
    stick.tube(run.eyes[i] * Vector3d(0.072, 0, 0.1), run.eyes[i] * Vector3d(0.072, 0, 0.4), 0.012, 0.004, 8, mesh::Material::paint);
    gaze.mesh_W = stick.mesh();
    gaze.mesh_W.corner_uv.clear();
    gaze.rgb = {0.85, 0.2, 0.15};
    objects.push_back(gaze);
  }
  render::RendererOptions options;
  options.max_width = o.width;
  options.max_height = o.height;
  options.samples = 4;
  options.near_m = 0.5;
  options.far_m = 80;
  render::Renderer renderer(stage, objects, options);
  const render::RenderedView view = renderer.render(X_WC, camera);
  cv::Mat picture = to_bgr(view.colour);
  std::vector<cv::Point> taken;
  for (std::size_t i = 0; i < run.looks.size(); ++i) {
    const Vector3d head = X_WC.inverse() * (run.eyes[i] * Vector3d(0.072, -0.12, -0.03));
    const Eigen::Vector2d uv = camera.project(head);
    label(picture, {static_cast<int>(uv.x()), static_cast<int>(uv.y())}, run.looks[i], look_colour(i, run.looks.size()), taken);
  }
  return picture;
}

cv::Mat unknown_left(const mesh::TriangleMesh& shown, const mesh::Bounds& bounds, double azimuth) {
  std::vector<cv::Mat> row;
  for (int k = 0; k < 4; ++k) row.push_back(to_bgr(draw_model(shown, azimuth + k * std::numbers::pi / 2, 20 * kDegrees, 420, bounds)));
  row.push_back(to_bgr(draw_model(shown, azimuth, 75 * kDegrees, 420, bounds)));
  cv::Mat all;
  cv::hconcat(row, all);
  return all;
}

// The known voxels in the colours of the finished model.
class VoxelColours {
 public:
  VoxelColours(const mesh::TriangleMesh& model, const RecordedGrid& grid) : grid_(grid) {
    if (model.colours.empty()) return;
    for (std::size_t i = 0; i < model.vertices.size(); ++i) {
      auto& [sum, count] = cells_[key(cell(model.vertices[i]))];
      if (count == 0) sum.setZero();
      sum += model.colours[i];
      ++count;
    }
  }
  Vector3d operator()(const Vector3d& p_W) const {
    const Vector3i c = cell(p_W);
    for (int reach = 0; reach <= 1; ++reach) {
      Vector3d sum = Vector3d::Zero();
      int count = 0;
      for (int dx = -reach; dx <= reach; ++dx)
        for (int dy = -reach; dy <= reach; ++dy)
          for (int dz = -reach; dz <= reach; ++dz)
            if (const auto it = cells_.find(key(c + Vector3i(dx, dy, dz))); it != cells_.end()) sum += it->second.first, count += it->second.second;
      if (count > 0) return sum / count;
    }
    return {0.7, 0.7, 0.7};
  }

 private:
  Vector3i cell(const Vector3d& p_W) const { return (grid_.X_WG.inverse() * p_W / grid_.voxel_m).array().floor().cast<int>(); }
  static std::int64_t key(const Vector3i& c) { return (static_cast<std::int64_t>(c.x()) * 4096 + c.y()) * 4096 + c.z(); }
  const RecordedGrid& grid_;
  std::unordered_map<std::int64_t, std::pair<Vector3d, int>> cells_;
};

cv::Mat sequence(const Run& run, const RecordedGrid& last, const mesh::Bounds& bounds, double azimuth) {
  constexpr int kTile = 340;
  const VoxelColours colours(run.model, last);
  std::vector<cv::Mat> tiles;
  for (std::size_t i = 0; i < run.looks.size(); ++i) {
    mesh::TriangleMesh known = exposed_faces(read_recorded_grid(run.look_folder(i)), kKnown, {0.7, 0.7, 0.7});
    for (std::size_t f = 0; f + 3 < known.vertices.size(); f += 4) {
      // A face's middle, drawn back into its voxel.
      const Vector3d middle = (known.vertices[f] + known.vertices[f + 2]) / 2;
      const Vector3d out = (known.vertices[f + 1] - known.vertices[f]).cross(known.vertices[f + 2] - known.vertices[f]).normalized();
      const Vector3d c = colours(middle - out * last.voxel_m / 2);
      for (std::size_t k = 0; k < 4; ++k) known.colours[f + k] = c;
    }
    cv::Mat tile = known.empty() ? cv::Mat(kTile, kTile, CV_8UC3, cv::Scalar::all(250)) : to_bgr(draw_model(known, azimuth, 20 * kDegrees, kTile, bounds));
    std::string text = std::to_string(run.looks[i]);
    if (run.coverage[i] >= 0) text += ": " + std::to_string(static_cast<int>(std::floor(100 * run.coverage[i]))) + " %";
    cv::putText(tile, text, {12, 28}, cv::FONT_HERSHEY_SIMPLEX, 0.75, {50, 50, 50}, 2, cv::LINE_AA);
    cv::rectangle(tile, {0, 0, kTile, kTile}, {225, 225, 225}, 1);
    tiles.push_back(tile);
  }
  const std::size_t columns = tiles.size() <= 8 ? 4 : 5;
  while (tiles.size() % columns) tiles.emplace_back(kTile, kTile, CV_8UC3, cv::Scalar::all(250));
  std::vector<cv::Mat> rows;
  for (std::size_t i = 0; i < tiles.size(); i += columns) {
    cv::Mat row;
    cv::hconcat(std::vector<cv::Mat>(tiles.begin() + static_cast<std::ptrdiff_t>(i), tiles.begin() + static_cast<std::ptrdiff_t>(i + columns)), row);
    rows.push_back(row);
  }
  cv::Mat all;
  cv::vconcat(rows, all);
  return all;
}

}  // namespace

std::optional<std::uint8_t> RecordedGrid::at(const Vector3i& v) const {
  if ((v.array() < 0).any() || (v.array() >= size.array()).any()) return std::nullopt;
  return states[(static_cast<std::size_t>(v.x()) * static_cast<std::size_t>(size.y()) + static_cast<std::size_t>(v.y())) * static_cast<std::size_t>(size.z()) +
                static_cast<std::size_t>(v.z())];
}

RecordedGrid read_recorded_grid(const std::string& look_folder) {
  RecordedGrid grid;
  const json j = read_json_file(look_folder + "/grid.json");
  try {
    grid.voxel_m = j.at("voxel_m").get<double>();
    for (int c = 0; c < 3; ++c) grid.size[c] = j.at("size").at(static_cast<std::size_t>(c)).get<int>();
    grid.X_WG = pose_from_rows(j.at("pose_world_grid"));
  } catch (const json::exception& e) {
    throw_error(ErrorCode::bad_input, look_folder + "/grid.json: " + e.what());
  }
  require((grid.size.array() > 0).all() && (grid.size.array() <= 512).all() && grid.voxel_m > 0, ErrorCode::bad_input, look_folder + "/grid.json has no usable size");
  const std::string text = read_file(look_folder + "/grid.npy");
  const std::size_t count = static_cast<std::size_t>(grid.size.x()) * static_cast<std::size_t>(grid.size.y()) * static_cast<std::size_t>(grid.size.z());
  require(text.size() > 10 && text.compare(1, 5, "NUMPY") == 0 && text.size() > count && text.find("'|u1'") < 128, ErrorCode::bad_input,
          look_folder + "/grid.npy is not the grid that grid.json describes");
  grid.states.assign(text.end() - static_cast<std::ptrdiff_t>(count), text.end());
  return grid;
}

mesh::TriangleMesh exposed_faces(const RecordedGrid& grid, std::uint8_t state, const Vector3d& colour) {
  mesh::TriangleMesh faces;
  for (int x = 0; x < grid.size.x(); ++x)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int z = 0; z < grid.size.z(); ++z) {
        const Vector3i v(x, y, z);
        if (grid.at(v) != state) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (int side = -1; side <= 1; side += 2) {
            const auto beside = grid.at(v + side * Vector3i::Unit(axis));
            if (beside && *beside != kEmpty) continue;
            const Vector3d middle = v.cast<double>() + Vector3d::Constant(0.5) + side * 0.5 * Vector3d::Unit(axis);
            const Vector3d a = 0.5 * Vector3d::Unit((axis + 1) % 3), b = side * 0.5 * Vector3d::Unit((axis + 2) % 3);
            const int first = static_cast<int>(faces.vertices.size());
            for (const Vector3d& p : {Vector3d(middle - a - b), Vector3d(middle + a - b), Vector3d(middle + a + b), Vector3d(middle - a + b)}) {
              faces.vertices.push_back(grid.X_WG * (grid.voxel_m * p));
              faces.colours.push_back(colour);
            }
            faces.triangles.emplace_back(first, first + 1, first + 2);
            faces.triangles.emplace_back(first, first + 2, first + 3);
          }
      }
  return faces;
}

mesh::TriangleMesh robot_mesh(const std::shared_ptr<const robot::RobotModel>& robot, const Eigen::VectorXd& configuration) {
  robot::Kinematics kinematics(robot);
  kinematics.set(configuration);
  mesh::PartBuilder body(1);
  for (std::size_t i = 0; i < robot->capsules().size(); ++i) {
    Vector3d a, b;
    kinematics.capsule(static_cast<int>(i), a, b);
    const double r = robot->capsules()[i].radius;
    Vector3d along = b - a;
    along = along.norm() > 1e-9 ? Vector3d(along.normalized()) : Vector3d::UnitZ();
    std::vector<Vector3d> line;
    std::vector<double> radii;
    constexpr int kRound = 6;
    for (int k = 0; k <= kRound; ++k) {
      const double angle = std::numbers::pi / 2 * (k + 0.3) / (kRound + 0.3);
      line.push_back(a - r * std::cos(angle) * along);
      radii.push_back(r * std::sin(angle));
    }
    for (int k = kRound; k >= 0; --k) {
      const double angle = std::numbers::pi / 2 * (k + 0.3) / (kRound + 0.3);
      line.push_back(b + r * std::cos(angle) * along);
      radii.push_back(r * std::sin(angle));
    }
    // A capsule without length has its two middle rings in one place.
    if ((b - a).norm() < 1e-6) {
      line.erase(line.begin() + kRound);
      radii.erase(radii.begin() + kRound);
    }
    body.tube(line, radii, 20, mesh::Material::paint);
  }
  mesh::TriangleMesh mesh = body.mesh();
  mesh.corner_uv.clear();
  mesh::compute_normals(mesh);
  return mesh;
}

RecordedGrid only_near_known(const RecordedGrid& grid, int reach) {
  RecordedGrid near = grid;
  std::size_t i = 0;
  for (int x = 0; x < grid.size.x(); ++x)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int z = 0; z < grid.size.z(); ++z, ++i) {
        if (grid.states[i] != kUnknown) continue;
        bool found = false;
        for (int dx = -reach; dx <= reach && !found; ++dx)
          for (int dy = -reach; dy <= reach && !found; ++dy)
            for (int dz = -reach; dz <= reach && !found; ++dz) found = grid.at({x + dx, y + dy, z + dz}) == kKnown;
        if (!found) near.states[i] = kEmpty;
      }
  return near;
}

std::vector<std::string> write_figures(const std::string& folder_of_run, const std::string& folder, const FigureOptions& options) {
  require(options.width >= 100 && options.height >= 100 && options.width <= 4096 && options.height <= 4096, ErrorCode::bad_input,
          "a figure may have 100 to 4096 pixels a side");
  const Run run = read_run(folder_of_run);
  const RecordedGrid grid = read_recorded_grid(run.look_folder(run.looks.size() - 1));
  const mesh::TriangleMesh shown = joined(run.model, exposed_faces(only_near_known(grid, kReach), kUnknown, kGreen));
  const mesh::Bounds bounds = mesh::bounds(run.model);
  const double azimuth = options.azimuth_deg ? *options.azimuth_deg * kDegrees : best_azimuth(run, grid, options.elevation_deg * kDegrees);
  std::filesystem::create_directories(folder);
  const std::string stem = folder + "/" + run.report.value("task", "run");
  write_picture(stem + "-postures.png", postures(run, grid, shown, options));
  write_picture(stem + "-unknown.png", unknown_left(shown, bounds, azimuth));
  write_picture(stem + "-looks.png", sequence(run, grid, bounds, azimuth));
  return {stem + "-postures.png", stem + "-unknown.png", stem + "-looks.png"};
}

}  // namespace periplus::supervisor
