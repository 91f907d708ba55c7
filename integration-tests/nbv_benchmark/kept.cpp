#include "integration-tests/nbv_benchmark/kept.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <unordered_map>

#include "common/core/error.h"
#include "common/core/file.h"
#include "integration-tests/nbv_benchmark/benchmark.h"

namespace periplus::nbv_benchmark {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// NumPy's format 1.0, compressed.
void write_npy(const fs::path& path, const char* type, std::size_t rows, std::size_t columns, const void* data, std::size_t bytes) {
  std::string header = std::string("{'descr': '") + type + "', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " + std::to_string(columns) + "), }";
  while ((10 + header.size() + 1) % 64 != 0) header += ' ';
  header += '\n';
  std::string text = "\x93NUMPY";
  text += '\x01';
  text += '\0';
  text += static_cast<char>(header.size() & 255);
  text += static_cast<char>(header.size() >> 8);
  text += header;
  text.append(static_cast<const char*>(data), bytes);
  const gzFile file = gzopen(path.c_str(), "wb3");
  require(file != nullptr, ErrorCode::io, "cannot write " + path.string());
  const bool whole = gzwrite(file, text.data(), static_cast<unsigned>(text.size())) == static_cast<int>(text.size());
  require(gzclose(file) == Z_OK && whole, ErrorCode::io, "cannot write " + path.string());
}

// The values of a rows x columns array; -1 rows: any number.
template <class T>
std::vector<T> read_npy(const fs::path& path, const char* type, long rows, std::size_t columns) {
  const gzFile file = gzopen(path.c_str(), "rb");
  require(file != nullptr, ErrorCode::io, "cannot read " + path.string());
  std::string text;
  char block[65536];
  int n = 0;
  while ((n = gzread(file, block, sizeof block)) > 0 && text.size() < (std::size_t{1} << 30)) text.append(block, static_cast<std::size_t>(n));
  gzclose(file);
  require(n == 0 && text.size() > 10 && text.compare(1, 5, "NUMPY") == 0, ErrorCode::bad_input, path.string() + " is not a whole .npy.gz file");
  const std::size_t header = 10 + static_cast<unsigned char>(text[8]) + 256u * static_cast<unsigned char>(text[9]);
  require(text.size() >= header && text.substr(0, header).find(std::string("'") + type + "'") != std::string::npos, ErrorCode::bad_input,
          path.string() + " does not hold " + type);
  const std::size_t values = (text.size() - header) / sizeof(T);
  require((text.size() - header) % (sizeof(T) * columns) == 0 && (rows < 0 || values == static_cast<std::size_t>(rows) * columns), ErrorCode::bad_input,
          path.string() + " has another size than expected");
  std::vector<T> out(values);
  std::memcpy(out.data(), text.data() + header, values * sizeof(T));
  return out;
}

json rows_of(const Pose& X) {
  json rows = json::array();
  for (int r = 0; r < 3; ++r) rows.push_back({X.matrix()(r, 0), X.matrix()(r, 1), X.matrix()(r, 2), X.matrix()(r, 3)});
  return rows;
}

Pose pose_of(const json& rows) {
  Pose X = Pose::Identity();
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 4; ++c) X.matrix()(static_cast<int>(r), static_cast<int>(c)) = rows.at(r).at(c).get<double>();
  return X;
}

std::string look_name(std::size_t view, std::size_t eye) {
  char name[64];
  std::snprintf(name, sizeof name, "view-%02zu-%s.npy.gz", view + 1, eye == 0 ? "left" : "right");
  return name;
}

void save(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  require(file.good(), ErrorCode::io, "cannot write " + path.string());
}

// Samples by cells of a lattice as wide as the distance of coverage.
class SampleHash {
 public:
  SampleHash(const std::vector<double>& samples, double cell) : samples_(samples), cell_(cell) {
    for (std::size_t i = 0; i < samples.size() / 8; ++i) cells_[key(lattice(point(i)))].push_back(i);
  }
  void cover(const Eigen::Vector3d& p, std::vector<bool>& covered) const {
    const Eigen::Vector3i at = lattice(p);
    for (int n = 0; n < 27; ++n) {
      const auto cell = cells_.find(key(at + Eigen::Vector3i(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1)));
      if (cell == cells_.end()) continue;
      for (const std::size_t i : cell->second)
        if (!covered[i] && (point(i) - p).norm() <= cell_) covered[i] = true;
    }
  }

 private:
  Eigen::Vector3d point(std::size_t i) const { return {samples_[8 * i], samples_[8 * i + 1], samples_[8 * i + 2]}; }
  Eigen::Vector3i lattice(const Eigen::Vector3d& p) const { return (p / cell_).array().floor().cast<int>(); }
  static std::uint64_t key(const Eigen::Vector3i& v) {
    std::uint64_t k = 0;
    for (int axis = 0; axis < 3; ++axis) k = k << 21 | (static_cast<std::uint64_t>(v[axis] + (1 << 20)) & 0x1fffff);
    return k;
  }
  const std::vector<double>& samples_;
  double cell_;
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells_;
};

double share_of(const std::vector<bool>& covered, const std::vector<double>& samples, int flag) {
  std::size_t of = 0, both = 0;
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (flag >= 0 && samples[8 * i + static_cast<std::size_t>(flag)] == 0) continue;
    ++of;
    both += covered[i];
  }
  return of == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(of);
}

void recompute_run(const fs::path& run_file, Recomputed& out) {
  const json j = json::parse(read_file(run_file.string()));
  const json& c = j.at("camera");
  const Pinhole camera{c.at("width").get<int>(), c.at("height").get<int>(), c.at("fx").get<double>(), c.at("fy").get<double>(), c.at("cx").get<double>(),
                       c.at("cy").get<double>()};
  camera.check();
  const double distance = j.at("distance_m").get<double>(), baseline = j.at("baseline_m").get<double>();
  require(distance > 0 && std::isfinite(baseline), ErrorCode::bad_input, run_file.string() + ": no usable distance");
  const double table = j.at("table_m").is_null() ? -std::numeric_limits<double>::infinity() : j.at("table_m").get<double>();
  const std::vector<double> samples = read_npy<double>(run_file.parent_path().parent_path() / "samples.npy.gz", "<f8", -1, 8);
  const SampleHash hash(samples, distance);
  std::vector<bool> covered(samples.size() / 8, false);
  for (std::size_t view = 0; view < j.at("poses_object_camera").size(); ++view) {
    const Pose X_OL = pose_of(j.at("poses_object_camera").at(view));
    for (std::size_t eye = 0; eye < (baseline > 0 ? 2u : 1u); ++eye) {
      const Pose X_OC = X_OL * Pose(Eigen::Translation3d(eye == 0 ? 0 : baseline, 0, 0));
      const std::vector<float> depth =
          read_npy<float>(run_file.parent_path() / look_name(view, eye), "<f4", camera.height, static_cast<std::size_t>(camera.width));
      for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u) {
          const double z = depth[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u)];
          if (!(z > 0)) continue;
          const Eigen::Vector3d p = X_OC * camera.back_project(u, v, z);
          if (p.z() <= table) continue;
          hash.cover(p, covered);
        }
    }
    const std::pair<const char*, int> measures[] = {{"all", -1}, {"visible", 6}, {"reachable", 7}};
    for (const auto& [name, flag] : measures) {
      const double reported = j.at("coverage").at(name).at(view).get<double>(), now = share_of(covered, samples, flag);
      out.largest = std::max(out.largest, std::abs(reported - now));
      if (std::abs(reported - now) * static_cast<double>(covered.size()) <= 1.5) continue;
      char text[160];
      std::snprintf(text, sizeof text, ": view %zu, coverage of %s: reported %.6f, recomputed %.6f", view + 1, name, reported, now);
      out.differences.push_back(run_file.string() + text);
    }
    ++out.views;
  }
  ++out.runs;
}

}  // namespace

KeptObject::KeptObject(const std::string& root, const std::string& setting, const Subject& subject, const Arena& arena, const Mask& reachable,
                       double distance)
    : arena_(arena), distance_(distance) {
  if (root.empty()) return;
  std::string name = setting;
  std::replace(name.begin(), name.end(), '/', '-');
  const fs::path folder = fs::path(root) / name / subject.file.name;
  fs::create_directories(folder);
  folder_ = folder.string();
  std::vector<double> rows;
  for (std::size_t i = 0; i < subject.samples.size(); ++i) {
    const mesh::SurfaceSample& s = subject.samples[i];
    rows.insert(rows.end(), {s.point.x(), s.point.y(), s.point.z(), s.normal.x(), s.normal.y(), s.normal.z(), arena.visible.test(i) ? 1.0 : 0.0,
                             reachable.test(i) ? 1.0 : 0.0});
  }
  write_npy(folder / "samples.npy.gz", "<f8", subject.samples.size(), 8, rows.data(), rows.size() * sizeof(double));
}

void KeptObject::add_look(const std::string& planner, int view, const Look& look) const {
  if (folder_.empty()) return;
  const fs::path folder = fs::path(folder_) / planner;
  fs::create_directories(folder);
  for (std::size_t eye = 0; eye < look.depth.size(); ++eye) {
    const ImageF& depth = look.depth[eye].depth;
    write_npy(folder / look_name(static_cast<std::size_t>(view), eye), "<f4", static_cast<std::size_t>(depth.height), static_cast<std::size_t>(depth.width),
              depth.data.data(), depth.data.size() * sizeof(float));
  }
}

void KeptObject::finish(const std::string& planner, const std::vector<ViewRecord>& views) const {
  if (folder_.empty()) return;
  const Pinhole& c = arena_.rig.camera;
  json j = {{"camera", {{"width", c.width}, {"height", c.height}, {"fx", c.fx}, {"fy", c.fy}, {"cx", c.cx}, {"cy", c.cy}}},
            {"baseline_m", arena_.pair ? arena_.rig.baseline : 0.0},
            {"distance_m", distance_},
            {"table_m", nullptr}};
  if (const auto table = table_height_object(arena_)) j["table_m"] = *table;
  for (const ViewRecord& v : views) {
    j["poses_object_camera"].push_back(rows_of(v.X_OC));
    j["coverage"]["all"].push_back(v.all);
    j["coverage"]["visible"].push_back(v.visible);
    j["coverage"]["reachable"].push_back(v.reachable);
  }
  save(fs::path(folder_) / planner / "run.json", j.dump(1) + "\n");
}

Recomputed recompute(const std::string& root) {
  require(fs::is_directory(root), ErrorCode::io, "there is no folder " + root);
  std::vector<fs::path> runs;
  for (const fs::directory_entry& e : fs::recursive_directory_iterator(root))
    if (e.path().filename() == "run.json") runs.push_back(e.path());
  require(!runs.empty(), ErrorCode::bad_input, root + " holds no run; make some with --keep");
  std::sort(runs.begin(), runs.end());
  Recomputed out;
  for (const fs::path& run : runs) {
    try {
      recompute_run(run, out);
    } catch (const json::exception& e) {
      throw_error(ErrorCode::bad_input, run.string() + ": " + e.what());
    }
  }
  return out;
}

}  // namespace periplus::nbv_benchmark
