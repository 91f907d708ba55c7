#include "integration-tests/evaluation/coverage.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>
#include <thread>
#include <unordered_map>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/random.h"

namespace periplus::evaluation {

namespace {

constexpr double degree = std::numbers::pi / 180;

// Data of a .npy file of version 1.0 after its header; `type` as NumPy writes it.
std::string npy_data(const std::string& path, const std::string& type, std::size_t bytes) {
  const std::string text = read_file(path);
  require(text.size() > 10 && text.compare(1, 5, "NUMPY") == 0, ErrorCode::bad_input, path + " is not a .npy file");
  const std::size_t header = 10 + static_cast<unsigned char>(text[8]) + 256u * static_cast<unsigned char>(text[9]);
  require(text.size() == header + bytes && text.substr(0, header).find("'" + type + "'") != std::string::npos, ErrorCode::bad_input,
          path + " does not hold " + std::to_string(bytes) + " bytes of " + type);
  return text.substr(header);
}

nlohmann::json read_json(const std::string& path) {
  try {
    return nlohmann::json::parse(read_file(path));
  } catch (const nlohmann::json::exception& e) {
    throw_error(ErrorCode::bad_input, path + ": " + e.what());
  }
}

Pose pose_of(const nlohmann::json& rows) {
  Pose X = Pose::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) X.matrix()(r, c) = rows.at(static_cast<std::size_t>(r)).at(static_cast<std::size_t>(c)).get<double>();
  return X;
}

}  // namespace

LookGrid read_grid(const std::string& look_folder) {
  LookGrid grid;
  const nlohmann::json j = read_json(look_folder + "/grid.json");
  try {
    grid.voxel_m = j.at("voxel_m").get<double>();
    grid.size = {j.at("size").at(0).get<int>(), j.at("size").at(1).get<int>(), j.at("size").at(2).get<int>()};
    grid.X_WG = pose_of(j.at("pose_world_grid"));
  } catch (const nlohmann::json::exception& e) {
    throw_error(ErrorCode::bad_input, look_folder + "/grid.json: " + e.what());
  }
  require((grid.size.array() > 0).all() && (grid.size.array() <= 512).all() && grid.voxel_m > 0, ErrorCode::bad_input,
          look_folder + "/grid.json has no usable size");
  const std::string data = npy_data(look_folder + "/grid.npy", "|u1", static_cast<std::size_t>(grid.size.x()) * grid.size.y() * grid.size.z());
  grid.states.assign(data.begin(), data.end());
  return grid;
}

void DepthCount::add(const std::string& look_folder, const LookGrid& grid) {
  if (size_ != grid.size || X_WG_.matrix() != grid.X_WG.matrix()) {
    X_WG_ = grid.X_WG;
    size_ = grid.size;
    counts_.assign(grid.states.size(), 0);
    for (const std::string& before : looks_) count(before, grid);
  }
  count(look_folder, grid);
  looks_.push_back(look_folder);
}

void DepthCount::count(const std::string& look_folder, const LookGrid& grid) {
  const nlohmann::json j = read_json(look_folder + "/look.json");
  Pinhole camera;
  Pose X_WC;
  try {
    const nlohmann::json& rig = j.at("rig");
    camera = {rig.at("width").get<int>(), rig.at("height").get<int>(), rig.at("fx").get<double>(), rig.at("fy").get<double>(), rig.at("cx").get<double>(),
              rig.at("cy").get<double>()};
    X_WC = pose_of(j.at("pose_world_camera"));
  } catch (const nlohmann::json::exception& e) {
    throw_error(ErrorCode::bad_input, look_folder + "/look.json: " + e.what());
  }
  camera.check();
  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  const std::string data = npy_data(look_folder + "/depth.npy", "<f4", pixels * sizeof(float));
  std::vector<float> depth(pixels);
  std::memcpy(depth.data(), data.data(), data.size());
  const Pose X_GC = grid.X_WG.inverse() * X_WC;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const float z = depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u)];
      if (!(z > 0)) continue;
      const Eigen::Vector3d p = X_GC * camera.back_project(u, v, z) / grid.voxel_m;
      if ((p.array() < 0).any() || (p.array() >= grid.size.cast<double>().array()).any()) continue;
      const Eigen::Vector3i i = p.cast<int>();
      ++counts_[(static_cast<std::size_t>(i.x()) * static_cast<std::size_t>(grid.size.y()) + static_cast<std::size_t>(i.y())) * static_cast<std::size_t>(grid.size.z()) +
                static_cast<std::size_t>(i.z())];
    }
}

KnownVoxels DepthCount::known(const LookGrid& grid, int least) const {
  KnownVoxels known;
  known.voxel_m = grid.voxel_m;
  std::size_t i = 0;
  for (int x = 0; x < grid.size.x(); ++x)
    for (int y = 0; y < grid.size.y(); ++y)
      for (int z = 0; z < grid.size.z(); ++z, ++i)
        if (grid.states[i] == 2 && i < counts_.size() && counts_[i] >= static_cast<std::uint32_t>(least))
          known.centers.push_back(grid.X_WG * (grid.voxel_m * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5)));
  return known;
}

bool box_holds_sample(const SurfaceSamples& samples, const Pose& X_WB, const Eigen::Vector3d& size) {
  const Pose X_BW = X_WB.inverse();
  return std::any_of(samples.points.begin(), samples.points.end(),
                     [&](const Eigen::Vector3d& p) { return ((X_BW * p).cwiseAbs().array() <= size.array() / 2).all(); });
}

std::vector<Pose> reachable_poses(const SurfaceSamples& samples, const ReachOptions& o, const Stands& stands) {
  Random random(o.seed);
  Eigen::Vector3d low = samples.points.at(0), high = low;
  for (const Eigen::Vector3d& p : samples.points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Eigen::Vector3d center = (low + high) / 2;
  const double reach = o.distance_max + (high - low).norm() / 2;
  std::vector<Pose> poses;
  for (int draw = 0; draw < 200 * o.poses && static_cast<int>(poses.size()) < o.poses; ++draw) {
    const Eigen::Vector3d p(random.uniform(center.x() - reach, center.x() + reach), random.uniform(center.y() - reach, center.y() + reach),
                            random.uniform(o.height_min, o.height_max));
    // Looks at a random place of the object's box, within the pitch the neck allows.
    const Eigen::Vector3d target(random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()), random.uniform(low.z(), high.z()));
    const Eigen::Vector3d d = target - p;
    const double pitch = std::clamp(std::atan2(-d.z(), std::hypot(d.x(), d.y())), o.pitch_min * degree, o.pitch_max * degree);
    // Nearest sample, by every 16th: the distance band has no sharp edge.
    double nearest = 1e30;
    for (std::size_t i = 0; i < samples.points.size(); i += 16) nearest = std::min(nearest, (samples.points[i] - p).norm());
    if (nearest < o.distance_min || nearest > o.distance_max) continue;
    const Pose X_WC = look_along(p, std::atan2(d.y(), d.x()), pitch);
    if (stands(X_WC)) poses.push_back(X_WC);
  }
  return poses;
}

std::vector<bool> reachable_samples(const SurfaceSamples& samples, const StereoRig& rig, const std::vector<Pose>& poses, const ReachOptions& o,
                                    const Blocked& blocked) {
  const double cosine = std::cos(o.incidence_max * degree);
  std::vector<char> reached(samples.points.size(), 0);
  const auto in_image = [&](const Eigen::Vector3d& p_C) {
    if (p_C.z() <= 0.05) return false;
    const Eigen::Vector2d uv = rig.camera.project(p_C);
    return uv.x() >= 0 && uv.y() >= 0 && uv.x() <= rig.camera.width - 1 && uv.y() <= rig.camera.height - 1;
  };
  const auto work = [&](std::size_t first, std::size_t step) {
    for (std::size_t i = first; i < samples.points.size(); i += step) {
      const Eigen::Vector3d& p = samples.points[i];
      const Eigen::Vector3d& n = samples.normals[i];
      const Eigen::Vector3d above = p + 1e-4 * n;  // so that the surface itself does not block
      for (const Pose& X_WC : poses) {
        const Eigen::Vector3d left = X_WC.translation(), right = X_WC * Eigen::Vector3d(rig.baseline, 0, 0);
        if (n.dot(left - p) < cosine * (left - p).norm() || n.dot(right - p) < cosine * (right - p).norm()) continue;
        const Eigen::Vector3d p_L = X_WC.inverse() * p;
        if (p_L.z() < o.depth_min || p_L.z() > o.depth_max) continue;
        if (!in_image(p_L) || !in_image(p_L - Eigen::Vector3d(rig.baseline, 0, 0))) continue;
        if (blocked(above, left) || blocked(above, right)) continue;
        reached[i] = 1;
        break;
      }
    }
  };
  std::thread second(work, 1, 2);
  work(0, 2);
  second.join();
  return {reached.begin(), reached.end()};
}

std::vector<bool> visible_samples(const SurfaceSamples& samples, int directions, double incidence_max, std::uint64_t seed, const Blocked& blocked) {
  std::vector<char> seen(samples.points.size(), 0);
  const double cosine = std::cos(incidence_max * degree);
  const auto work = [&](std::size_t first, std::size_t step) {
    for (std::size_t i = first; i < samples.points.size(); i += step) {
      Random random(seed + i);
      const Eigen::Vector3d& n = samples.normals[i];
      const Eigen::Vector3d above = samples.points[i] + 1e-4 * n;
      const Eigen::Vector3d side = (std::abs(n.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY()).cross(n).normalized();
      const Eigen::Vector3d other = n.cross(side);
      for (int k = 0; k < directions && !seen[i]; ++k) {
        const double c = random.uniform(cosine, 1.0), s = std::sqrt(1 - c * c), a = random.uniform(0, 2 * std::numbers::pi);
        const Eigen::Vector3d d = c * n + s * (std::cos(a) * side + std::sin(a) * other);
        for (const double distance : {2.0, 0.6}) {
          const Eigen::Vector3d eye = above + distance * d;
          if (eye.z() > 0 && !blocked(above, eye)) {
            seen[i] = 1;
            break;
          }
        }
      }
    }
  };
  std::thread second(work, 1, 2);
  work(0, 2);
  second.join();
  return {seen.begin(), seen.end()};
}

std::vector<bool> covered_samples(const SurfaceSamples& samples, const KnownVoxels& known) {
  // Hash of cells of one voxel: a centre within one voxel size lies in one of the 27 cells around.
  const double h = known.voxel_m;
  const auto key = [](const Eigen::Vector3i& c) {
    return (static_cast<std::uint64_t>(c.x() & 0x1fffff) << 42) | (static_cast<std::uint64_t>(c.y() & 0x1fffff) << 21) |
           static_cast<std::uint64_t>(c.z() & 0x1fffff);
  };
  const auto cell = [&](const Eigen::Vector3d& p) -> Eigen::Vector3i { return (p / h).array().floor().cast<int>(); };
  std::unordered_map<std::uint64_t, std::vector<Eigen::Vector3d>> cells;
  for (const Eigen::Vector3d& c : known.centers) cells[key(cell(c))].push_back(c);
  std::vector<bool> covered(samples.points.size(), false);
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Eigen::Vector3i c = cell(samples.points[i]);
    for (int dx = -1; dx <= 1 && !covered[i]; ++dx)
      for (int dy = -1; dy <= 1 && !covered[i]; ++dy)
        for (int dz = -1; dz <= 1 && !covered[i]; ++dz)
          if (const auto it = cells.find(key(c + Eigen::Vector3i(dx, dy, dz))); it != cells.end())
            for (const Eigen::Vector3d& q : it->second)
              if ((q - samples.points[i]).norm() <= h) {
                covered[i] = true;
                break;
              }
  }
  return covered;
}

double share(const std::vector<bool>& covered, const std::vector<bool>& of) {
  std::size_t both = 0, all = 0;
  for (std::size_t i = 0; i < of.size(); ++i) {
    all += of[i];
    both += of[i] && covered[i];
  }
  return all == 0 ? 0 : static_cast<double>(both) / static_cast<double>(all);
}

RunCoverage cover_looks(const std::string& run_folder, nlohmann::json& looks, const SurfaceSamples& samples, const std::vector<bool>& reachable,
                        const std::vector<bool>& visible) {
  RunCoverage run;
  DepthCount depth_count;
  const std::vector<bool> all(samples.points.size(), true);
  for (nlohmann::json& look : looks) {
    char name[24];
    std::snprintf(name, sizeof name, "/looks/%02d", look.at("look").get<int>());
    try {
      const LookGrid grid = read_grid(run_folder + name);
      depth_count.add(run_folder + name, grid);
      const std::vector<bool> covered = covered_samples(samples, depth_count.known(grid));
      look["coverage"] = run.reachable = share(covered, reachable);
      look["coverage_visible"] = run.visible = share(covered, visible);
      run.all = share(covered, all);
    } catch (const Error& error) {
      look["coverage_error"] = error.what();
      run.skipped.push_back(error.what());
    }
  }
  return run;
}

ErrorStatistics statistics(std::vector<double> d) {
  if (d.empty()) return {};
  std::sort(d.begin(), d.end());
  double sum = 0;
  for (const double v : d) sum += v;
  return {sum / static_cast<double>(d.size()), d[static_cast<std::size_t>(0.95 * static_cast<double>(d.size() - 1))], d.back()};
}

}  // namespace periplus::evaluation
