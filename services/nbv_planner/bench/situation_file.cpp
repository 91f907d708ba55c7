#include "services/nbv_planner/bench/situation_file.h"

#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>

#include "common/core/error.h"
#include "common/object_model/compression.h"
#include "common/scene/scene.h"

namespace periplus::nbv::bench {
namespace {

constexpr const char* kMagic = "periplus-situations-1";
using Planes = std::vector<std::uint64_t>;

Planes planes_of(const voxel::OccupancyGrid& grid) {
  Planes all = grid.occupied();
  all.insert(all.end(), grid.known().begin(), grid.known().end());
  all.insert(all.end(), grid.environment().begin(), grid.environment().end());
  return all;
}

Planes difference(Planes a, const Planes& b) {
  if (a.size() != b.size()) return a;
  for (std::size_t i = 0; i < a.size(); ++i) a[i] ^= b[i];
  return a;
}

}  // namespace

std::string write_situations(const std::vector<RecordedSituation>& situations) {
  std::ostringstream out;
  out << std::setprecision(17) << kMagic << "\n";
  Planes last;
  for (const RecordedSituation& r : situations) {
    const Situation& s = r.situation;
    const robot::ViewLimits& l = s.limits;
    const voxel::GridGeometry& g = s.grid->geometry();
    require(g.X_WG.linear().isIdentity(), ErrorCode::bad_input, "only grids along the world's axes can be recorded");
    out << "situation " << r.name << " " << r.looks << "\n"
        << "limits " << l.height_min << " " << l.height_max << " " << l.pitch_min << " " << l.pitch_max << " " << l.roll_max << " "
        << l.distance_min << " " << l.distance_max << "\n"
        << "body " << s.body.lower.transpose() << " " << s.body.upper.transpose() << "\n"
        << "rig " << s.rig.camera.width << " " << s.rig.camera.height << " " << s.rig.camera.fx << " " << s.rig.camera.fy << " "
        << s.rig.camera.cx << " " << s.rig.camera.cy << " " << s.rig.baseline << "\n"
        << "grid " << g.voxel_size << " " << g.size.transpose() << " " << g.X_WG.translation().transpose() << "\n"
        << "scene " << r.scene.size() << "\n" << r.scene << "\n";
    const Planes planes = planes_of(*s.grid), rest = difference(planes, last);
    const std::string packed = object_model::pack_bytes(rest.data(), rest.size(), sizeof(std::uint64_t));
    out << "planes " << packed.size() << "\n" << packed << "\n";
    last = planes;
  }
  return out.str();
}

std::vector<RecordedSituation> read_situations(const std::string& file) {
  std::istringstream in(file);
  const auto refuse = [&](const std::string& what) {
    throw_error(ErrorCode::bad_input, "situations, octet " + std::to_string(static_cast<long>(in.tellg())) + ": " + what);
  };
  const auto block = [&] {
    std::size_t octets = 0;
    if (!(in >> octets) || octets > file.size() || in.get() != '\n') refuse("a block needs its number of octets");
    std::string bytes(octets, '\0');
    if (!in.read(bytes.data(), static_cast<std::streamsize>(octets))) refuse("a block ends too early");
    return bytes;
  };
  std::string key;
  if (!(in >> key) || key != kMagic) refuse(std::string("does not begin with ") + kMagic);
  std::vector<RecordedSituation> all;
  voxel::GridGeometry g;
  Planes last;
  while (in >> key) {
    if (key == "situation") {
      RecordedSituation r;
      in >> r.name >> r.looks;
      all.push_back(std::move(r));
      continue;
    }
    if (all.empty()) refuse("begins with no situation");
    Situation& s = all.back().situation;
    if (key == "limits") {
      robot::ViewLimits& l = s.limits;
      in >> l.height_min >> l.height_max >> l.pitch_min >> l.pitch_max >> l.roll_max >> l.distance_min >> l.distance_max;
    } else if (key == "body") {
      for (Eigen::Vector3d* v : {&s.body.lower, &s.body.upper}) in >> v->x() >> v->y() >> v->z();
    } else if (key == "rig") {
      Pinhole& c = s.rig.camera;
      in >> c.width >> c.height >> c.fx >> c.fy >> c.cx >> c.cy >> s.rig.baseline;
    } else if (key == "grid") {
      Eigen::Vector3d p;
      in >> g.voxel_size >> g.size.x() >> g.size.y() >> g.size.z() >> p.x() >> p.y() >> p.z();
      if (!in) refuse("not a grid");
      g.X_WG = make_pose(p, Eigen::Matrix3d::Identity());
      g.check();
    } else if (key == "scene") {
      all.back().scene = block();
      s.scene = scene::parse_scene(all.back().scene, all.back().name);
      s.collision = std::make_shared<scene::CollisionWorld>(s.scene);
    } else if (key == "planes") {
      auto grid = std::make_shared<voxel::OccupancyGrid>(g);
      const std::size_t words = grid->occupied().size();
      Planes planes(3 * words);
      const std::string packed = block();
      object_model::unpack_bytes(packed, planes.size(), sizeof(std::uint64_t), planes.data());
      planes = difference(std::move(planes), last);
      last = planes;
      const auto part = [&](std::size_t i) {
        return Planes(planes.begin() + static_cast<std::ptrdiff_t>(i * words), planes.begin() + static_cast<std::ptrdiff_t>((i + 1) * words));
      };
      grid->adopt(part(0), part(1), part(2));
      grid->revision = static_cast<std::uint32_t>(all.back().looks + 1);
      s.grid = grid;
      check(s);
    } else {
      refuse("'" + key + "' is no key");
    }
    if (!in) refuse("'" + key + "' has not the numbers it needs");
  }
  for (const RecordedSituation& r : all) {
    if (r.situation.grid == nullptr) refuse("situation " + r.name + " has no planes");
  }
  return all;
}

std::vector<RecordedSituation> load_situations(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  require(in.good(), ErrorCode::io, "cannot read " + path);
  return read_situations(std::string(std::istreambuf_iterator<char>(in), {}));
}

}  // namespace periplus::nbv::bench
