#include "common/object_model/object_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

#include "common/core/error.h"
#include "common/core/fault_point.h"
#include "common/core/hash.h"
#include "common/scene/mesh_solid.h"
#include "common/scene/scene.h"

namespace periplus::object_model {

namespace {

void check_perception(const Perception& p) {
  require(is_finite(p.X_WC) && p.covariance.allFinite() && std::isfinite(p.silhouette_valid_share), ErrorCode::not_finite,
          "a perception's pose, covariance and valid share must be finite");
  require(!p.depth.empty() && p.depth.size() <= 2, ErrorCode::bad_size, "a perception carries one or two depth maps");
  p.rig.check();
  for (const DepthMap& map : p.depth) {
    map.camera.check();
    require(is_finite(map.X_WC), ErrorCode::not_finite, "a depth map's pose must be finite");
    for (const ImageF* image : {&map.depth, &map.depth_minimum}) {
      require(image->width == map.camera.width && image->height == map.camera.height && image->channels == 1 &&
                  image->data.size() == static_cast<std::size_t>(image->width) * image->height,
              ErrorCode::bad_size, "depth and least depth must have the size of the camera's image");
      for (float z : image->data)
        require(std::isfinite(z) && z >= 0, ErrorCode::not_finite, "depths must be finite and not negative; 0 means none");
    }
  }
}

// Numbers in a form that does not depend on the machine.
class CanonicalHash {
 public:
  void number(std::uint64_t n) {
    unsigned char octets[8];
    for (int b = 0; b < 8; ++b) octets[b] = static_cast<unsigned char>(n >> (8 * b));
    hash_.update(octets, sizeof octets);
  }
  void real(double v) { number(std::bit_cast<std::uint64_t>(v == 0 ? 0.0 : v)); }  // one zero, not two
  void pose(const Pose& X) {
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) real(X.matrix()(row, column));
  }
  void vector(const Eigen::Vector3d& v) {
    for (int n = 0; n < 3; ++n) real(v[n]);
  }
  void plane(const std::vector<std::uint64_t>& words) {
    number(words.size());
    for (std::uint64_t w : words) number(w);
  }
  void bytes(const std::vector<std::uint8_t>& data) {
    number(data.size());
    hash_.update(data.data(), data.size());
  }
  std::string hex() { return hash_.hex(); }

 private:
  Sha256 hash_;
};

}  // namespace

bool same_box(const ObjectBox& a, const ObjectBox& b) {
  return a.X_WB.matrix().isApprox(b.X_WB.matrix(), 1e-9) && a.size.isApprox(b.size, 1e-9);
}

std::vector<voxel::Occluder> occluders_of(const scene::Scene& scene) {
  std::vector<voxel::Occluder> out;
  for (const scene::Solid& solid : scene.solids) switch (solid.shape) {
      case scene::Shape::box:
        out.push_back(voxel::Occluder::box(solid.X_WS, solid.size));
        break;
      case scene::Shape::cylinder:
        out.push_back(voxel::Occluder::cylinder(solid.X_WS, solid.size.x(), solid.size.z()));
        break;
      case scene::Shape::sphere:
        out.push_back(voxel::Occluder::sphere(solid.X_WS.translation(), solid.size.x()));
        break;
      case scene::Shape::mesh: {
        std::vector<Eigen::Vector3d> vertices_W;
        for (const Eigen::Vector3d& p : solid.mesh->mesh().vertices) vertices_W.push_back(solid.X_WS * p);
        auto triangles = voxel::Occluder::mesh(vertices_W, solid.mesh->mesh().triangles);
        out.insert(out.end(), std::make_move_iterator(triangles.begin()), std::make_move_iterator(triangles.end()));
        break;
      }
    }
  return out;
}

ObjectModel::ObjectModel(const std::string& object_id, const ObjectBox& box, double voxel_size, const Surroundings& surroundings,
                         std::uint32_t revision) {
  const voxel::GridGeometry g = voxel::GridGeometry::from_box(box.X_WB, box.size, voxel_size);
  state_.object_id = object_id;
  state_.environment_revision = surroundings.revision;
  state_.begun_box = state_.box = box;
  state_.grid = voxel::OccupancyGrid(g);
  state_.grid.revision = revision;
  state_.evidence = Evidence(g);
  state_.log_odds = LogOdds(g);
  state_.tsdf = Tsdf(g);
  if (surroundings.collision) {
    // A little less than a voxel, so that one which only shares a face with the table is not the table's.
    const Eigen::Vector3d size = Eigen::Vector3d::Constant(voxel_size * 0.98);
    const auto touches = [&](const Eigen::Vector3d& center_G, const Eigen::Vector3d& side) {
      Pose X_WV = g.X_WG;
      X_WV.translation() = g.X_WG * center_G;
      return surroundings.collision->box_touches_solid(X_WV, side);
    };
    const Eigen::Vector3i nb = g.bricks();
    for (int bx = 0; bx < nb.x(); ++bx)
      for (int by = 0; by < nb.y(); ++by)
        for (int bz = 0; bz < nb.z(); ++bz) {
          const Eigen::Vector3i first(bx * 8, by * 8, bz * 8);
          if (!touches((first.cast<double>().array() + 4) * voxel_size, Eigen::Vector3d::Constant(8 * voxel_size))) continue;
          for (int n = 0; n < 512; ++n) {
            const Eigen::Vector3i v = first + Eigen::Vector3i(n >> 6, (n >> 3) & 7, n & 7);
            if (g.contains(v) && touches((v.cast<double>().array() + 0.5) * voxel_size, size))
              state_.grid.set_state(v, voxel::VoxelState::environment);
          }
        }
  }
  state_.known_solids = state_.grid.environment();
  faces_ = std::make_shared<const voxel::ExposedFaces>(state_.grid);
}

ObjectModel::ObjectModel(ModelState state) : state_(std::move(state)) {
  const voxel::GridGeometry& g = state_.grid.geometry();
  g.check();
  const std::size_t bricks = voxel::brick_count(g);
  require(state_.known_solids.size() == state_.grid.occupied().size() && state_.evidence.bricks().size() == bricks &&
              state_.log_odds.bricks().size() == bricks && state_.tsdf.bricks().size() == bricks &&
              state_.tsdf.free().size() == bricks,
          ErrorCode::bad_size, "the parts of the stored model do not fit its grid");
  const auto check = [](const TsdfSample& s) {
    require(std::isfinite(s.distance) && std::isfinite(s.weight) && s.weight >= 0 && std::isfinite(s.r) && std::isfinite(s.g) &&
                std::isfinite(s.b) && std::isfinite(s.color_weight),
            ErrorCode::not_finite, "the stored signed distances hold a number that is not finite");
  };
  for (std::size_t b = 0; b < bricks; ++b) {
    check(state_.tsdf.free()[b]);
    if (const PackedTsdfBrick* brick = state_.tsdf.bricks().find(b)) std::for_each(brick->distinct().begin(), brick->distinct().end(), check);
  }
  faces_ = std::make_shared<const voxel::ExposedFaces>(state_.grid);
}

std::shared_ptr<const View> ObjectModel::view(const std::string& view_id) const {
  for (const auto& v : state_.views)
    if (v->view_id == view_id) return v;
  return nullptr;
}

Integration ObjectModel::integrate(const Perception& perception, const Surroundings& surroundings, const CarvingSettings& settings) {
  if (const auto before = view(perception.view_id)) return before->result;
  settings.check();
  check_perception(perception);
  auto kept = std::make_shared<View>();
  kept->view_id = perception.view_id;
  kept->stamp_ns = perception.stamp_ns;
  kept->rig = perception.rig;
  kept->X_WC = perception.X_WC;
  kept->covariance = perception.covariance;
  kept->silhouette_valid_share = perception.silhouette_valid_share;
  for (const DepthMap& map : perception.depth) kept->depth.push_back(store_depth(map, perception.X_WC));
  kept->color = perception.color;
  kept->features = perception.features;
  return add(std::move(kept), surroundings, settings);
}

void carve(const View& view, const Surroundings& surroundings, const CarvingSettings& settings, bool distances, ModelState& state,
           voxel::BrickMarks* changed) {
  const voxel::GridGeometry& g = state.grid.geometry();
  const CarvingRule rule = carving_rule(view.silhouette_valid_share, point_sigma(view.covariance, (view.X_WC.translation() - state.box.X_WB.translation()).norm()),
                                        g.voxel_size, settings);
  if (!state.mode) state.mode = settings.mode;
  const bool probabilistic = state.mode == CarvingMode::probabilistic;
  bool left = true;
  for (const StoredDepth& stored : view.depth) {
    DepthMap map = restore_depth(stored, view.X_WC);
    if (probabilistic) map = without_outliers(map, settings.log_odds.support_share, settings.log_odds.support_voxels * g.voxel_size);
    const PixelLimits limits = pixel_limits(map, g, settings, rule.close_gaps, surroundings.collision.get());
    fault_point(left ? "model.left.limited" : "model.right.limited");
    if (probabilistic)
      state.log_odds.integrate(map, limits, view.rig.camera.fx * view.rig.baseline, rule, settings);
    fault_point(left ? "model.left.weighed" : "model.right.weighed");
    if (probabilistic)
      add_points(map, limits, g, rule.margin_voxels, state.evidence);
    else
      carve_and_count(map, limits, rule.margin_voxels, rule.votes, state.grid, state.evidence, changed);
    fault_point(left ? "model.left.counted" : "model.right.counted");
    // The colours are the left eye's.
    if (distances) state.tsdf.integrate(map, limits, left ? view.color : ImageU8{}, settings.truncation_voxels * g.voxel_size);
    left = false;
  }
  fault_point("model.surface");
  if (probabilistic)
    state.log_odds.label(state.known_solids, settings, state.evidence, state.grid, changed);
  else
    label(state.known_solids, settings, state.evidence, state.grid, changed);
  fault_point("model.labelled");
}

Integration ObjectModel::add(std::shared_ptr<View> view, const Surroundings& surroundings, const CarvingSettings& settings) {
  voxel::VisibilityWorkspace workspace;
  const auto unknown_pixels = [&](const voxel::VisibilityScene& scene) { return scene.evaluate_pair(view->X_WC, view->rig, {}, workspace).pixels; };
  const voxel::VisibilityScene before(faces_, surroundings.occluders, {}, scene_.get());
  const auto pixels_before = unknown_pixels(before);
  fault_point("model.seen_before");
  const auto unknown_before = state_.grid.counts().unknown;

  voxel::BrickMarks changed(voxel::brick_count(state_.grid.geometry()));
  carve(*view, surroundings, settings, true, state_, &changed);
  auto faces = std::make_shared<voxel::ExposedFaces>(*faces_);
  faces->update(state_.grid, changed);
  scene_ = std::make_shared<const voxel::VisibilityScene>(faces, surroundings.occluders, std::vector<Eigen::Vector3i>(), &before);
  faces_ = std::move(faces);
  ++state_.grid.revision;

  view->result.revision = state_.grid.revision;
  view->result.counts = state_.grid.counts();
  view->result.found_gain_px = static_cast<double>(pixels_before) - static_cast<double>(unknown_pixels(*scene_));
  view->result.found_gain_voxels = static_cast<double>(unknown_before) - static_cast<double>(view->result.counts.unknown);
  const Integration result = view->result;
  state_.views.push_back(std::move(view));
  fault_point("model.added");
  return result;
}

bool ObjectModel::can_be_revised() const {
  return !state_.imported && std::all_of(state_.views.begin(), state_.views.end(), [](const auto& v) {
    return !v->depth.empty() && std::none_of(v->depth.begin(), v->depth.end(), [](const StoredDepth& d) { return d.minimum.empty(); });
  });
}

ObjectModel ObjectModel::begun_again(const ObjectBox& box, const Surroundings& surroundings, const CarvingSettings& settings) const {
  settings.check();
  require(can_be_revised(), ErrorCode::bad_input,
          state_.imported ? "the grid was imported and does not follow from views: it cannot be carved again"
                          : "a view was stored by a version that kept too little of its depth to carve again; begin the object anew");
  require(surroundings.revision == state_.environment_revision, ErrorCode::model_object_differs,
          "the object was begun in another environment; set that one to carve its views again");
  ObjectModel out(state_.object_id, box, state_.grid.geometry().voxel_size, surroundings, state_.grid.revision + 1);
  out.state_.begun_box = state_.begun_box;
  out.state_.history = state_.history;
  out.state_.mode = state_.mode;
  return out;
}

ObjectModel ObjectModel::within(const ObjectBox& box, const Surroundings& surroundings, const CarvingSettings& settings) const {
  ObjectModel out = begun_again(box, surroundings, settings);
  for (const auto& view : state_.views) out.add(std::make_shared<View>(*view), surroundings, settings);
  return out;
}

ObjectModel ObjectModel::revised(const std::vector<BetterPose>& better, const std::vector<std::string>& without, const Surroundings& surroundings,
                                 const CarvingSettings& settings) const {
  ObjectModel out = begun_again(state_.box, surroundings, settings);
  std::map<std::string, const BetterPose*> poses;
  std::set<std::string> named(without.begin(), without.end());
  require(named.size() == without.size(), ErrorCode::bad_input, "a view is named twice to be left out");
  for (const BetterPose& b : better) {
    require(is_finite(b.X_WC) && b.covariance.allFinite(), ErrorCode::not_finite, "the pose and covariance of view " + b.view_id + " must be finite");
    require(named.insert(b.view_id).second, ErrorCode::bad_input, "view " + b.view_id + " is named twice");
    poses[b.view_id] = &b;
  }
  for (const std::string& id : named) require(view(id) != nullptr, ErrorCode::bad_input, "the object has no view " + id);

  for (const auto& old : state_.views) {
    if (std::find(without.begin(), without.end(), old->view_id) != without.end()) continue;
    auto again = std::make_shared<View>(*old);
    if (const auto it = poses.find(old->view_id); it != poses.end()) {
      const Pose X_new_old = it->second->X_WC * old->X_WC.inverse();
      again->X_WC = it->second->X_WC;
      again->covariance = it->second->covariance;
      for (Feature& f : again->features) {
        f.p_W = X_new_old * f.p_W;
        f.normal_W = X_new_old.linear() * f.normal_W;
      }
    }
    out.add(std::move(again), surroundings, settings);
  }
  return out;
}

void ObjectModel::note(ModelEvent event) {
  constexpr std::size_t kMostEvents = 4096;
  event.what.resize(std::min<std::size_t>(event.what.size(), 64));
  event.detail.resize(std::min<std::size_t>(event.detail.size(), 256));
  event.program.resize(std::min<std::size_t>(event.program.size(), 64));
  if (state_.history.size() >= kMostEvents) state_.history.erase(state_.history.begin());
  state_.history.push_back(std::move(event));
}

bool ObjectModel::is_measured(const Eigen::Vector3i& voxel, const CarvingSettings& settings) const {
  return state_.grid.state(voxel) == voxel::VoxelState::known &&
         state_.evidence.at(voxel).points >= settings.known_points;
}

std::vector<Landmark> ObjectModel::landmarks(const LandmarkSettings& settings, KeptMatches* kept) const {
  constexpr std::size_t kMost = 65536;
  std::vector<Landmark> out;
  const voxel::GridGeometry& g = state_.grid.geometry();
  for (const SeenLandmark& l : merge_landmarks(state_.views, settings, kept)) {
    const auto voxel = landmark_voxel(l.place, state_.grid);
    if (!voxel) continue;
    out.push_back(l.place);
    if (g.voxel_of(l.place.p_W) != *voxel) {
      const Eigen::Array3d p = (g.X_WG.inverse() * l.place.p_W).array() / g.voxel_size, least = voxel->cast<double>().array() + 0.01;
      out.back().p_W = g.X_WG * Eigen::Vector3d(p.max(least).min(least + 0.98).matrix() * g.voxel_size);
    }
    if (out.size() == kMost) break;
  }
  return out;
}

std::string ObjectModel::digest() const {
  CanonicalHash hash;
  const voxel::GridGeometry& g = state_.grid.geometry();
  hash.number(1);  // version of this form
  hash.pose(g.X_WG);
  hash.real(g.voxel_size);
  for (int n = 0; n < 3; ++n) hash.number(static_cast<std::uint64_t>(g.size[n]));
  hash.plane(state_.grid.occupied());
  hash.plane(state_.grid.known());
  hash.plane(state_.grid.environment());
  hash.number(state_.views.size());
  for (const auto& v : state_.views) {
    hash.pose(v->X_WC);
    hash.real(v->rig.baseline);
    hash.number(v->features.size());
    for (const Feature& f : v->features) {
      for (float value : {f.u, f.v, f.size, f.angle}) hash.real(value);
      hash.vector(f.p_W);
      hash.vector(f.normal_W);
      hash.real(f.size_m);
      hash.bytes(f.descriptor);
    }
  }
  return hash.hex();
}

}  // namespace periplus::object_model
