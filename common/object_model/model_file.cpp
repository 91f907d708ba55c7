#include "common/object_model/model_file.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/core/hash.h"
#include "common/geometry/checks.h"
#include "common/object_model/compression.h"
#include "common/object_model/model.pb.h"

namespace periplus::object_model {

namespace {

constexpr std::string_view kMagic = "PERIPLUS-MODEL 4\n";
constexpr std::string_view kMagicsBefore[] = {"PERIPLUS-MODEL 1\n", "PERIPLUS-MODEL 2\n", "PERIPLUS-MODEL 3\n"};
constexpr std::uint32_t kVersion = 4;
constexpr std::size_t kDigest = 64;
constexpr std::size_t kMostViews = 4096, kMostEvents = 4096, kMostFeatures = 8192, kMostDescriptor = 512;
constexpr std::uint32_t kMostPixelsASide = 8192;
constexpr std::uint64_t kMostFileBytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMostBytes = std::uint64_t{2} << 30;  // of all arrays when unpacked

template <class T>
void pack(const std::vector<T>& from, proto::Array& to) {
  to.set_elements(from.size());
  to.set_element_bytes(sizeof(T));
  to.set_deflated(pack_bytes(from.data(), from.size(), sizeof(T)));
}

template <class T>
std::vector<T> unpack(const proto::Array& from, std::size_t elements, const char* what) {
  require(from.elements() == elements && from.element_bytes() == sizeof(T), ErrorCode::bad_size,
          std::string("the model's array `") + what + "` does not fit its grid or image");
  require(may_hold(from.deflated(), elements * sizeof(T)), ErrorCode::bad_size,
          std::string("the model's array `") + what + "` is shorter than its claimed size allows");
  std::vector<T> to(elements);
  unpack_bytes(from.deflated(), elements, sizeof(T), to.data());
  return to;
}

// Bytes that the arrays of a message claim to hold when unpacked.
std::uint64_t claimed(const proto::Array& array) {
  const std::uint64_t each = std::max<std::uint32_t>(1, array.element_bytes());
  return array.elements() > kMostBytes / each ? kMostBytes + 1 : array.elements() * each;
}
std::uint64_t claimed(const proto::View& v) {
  std::uint64_t sum = claimed(v.depth()) + claimed(v.color());
  for (const proto::DepthMap& d : v.depth_maps()) sum += claimed(d.depth()) + claimed(d.behind_minimum());
  return sum;
}
std::uint64_t claimed(const proto::Model& m) {
  std::uint64_t sum = 0;
  for (const proto::Array* array : {&m.occupied(), &m.known(), &m.environment(), &m.known_solids(), &m.points(), &m.seen(), &m.solid(), &m.votes(), &m.tsdf(),
                                   &m.evidence_bricks(), &m.tsdf_bricks(), &m.tsdf_free(), &m.tsdf_distinct(), &m.tsdf_places(), &m.log_odds_bricks(), &m.log_odds()})
    sum += claimed(*array);
  return sum;
}

// Before anything is unpacked: a small file may claim very much.
template <class Views>
void check_claims(const proto::Model& m, const Views& views) {
  require(static_cast<std::size_t>(views.size()) <= kMostViews, ErrorCode::bad_size, "a model has at most 4096 views");
  std::uint64_t sum = claimed(m);
  for (const proto::View& v : views) sum += claimed(v);
  require(sum <= kMostBytes, ErrorCode::bad_size, "the model's grid and views claim over 2 GiB; use fewer or smaller views, or larger voxels");
}

using Numbers = google::protobuf::RepeatedField<double>;

void require_numbers(const Numbers& numbers, int count, const char* what) {
  require(numbers.size() == count, ErrorCode::bad_size, std::string("the model's `") + what + "` needs " + std::to_string(count) + " numbers");
  for (double v : numbers)
    require(std::isfinite(v), ErrorCode::not_finite, std::string("the model's `") + what + "` holds a number that is not finite");
}

void put(const Pose& X, Numbers* to) {
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) to->Add(X.matrix()(row, column));
}

Pose pose(const Numbers& from, const char* what) {
  require_numbers(from, 12, what);
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) X.matrix()(row, column) = from.Get(row * 4 + column);
  require_rigid(X, std::string("the model's `") + what + "`");
  return X;
}

void put(const Eigen::Vector3d& v, Numbers* to) {
  for (int n = 0; n < 3; ++n) to->Add(v[n]);
}

Eigen::Vector3d vector(const Numbers& from, const char* what) {
  require_numbers(from, 3, what);
  return {from.Get(0), from.Get(1), from.Get(2)};
}

double finite(double v, const char* what) { return std::isfinite(v) ? v : require_finite(v, std::string("the model's `") + what + "`"); }

void put(const StoredDepth& from, proto::DepthMap& to) {
  to.set_width(static_cast<std::uint32_t>(from.camera.width));
  to.set_height(static_cast<std::uint32_t>(from.camera.height));
  to.set_fx(from.camera.fx);
  to.set_fy(from.camera.fy);
  to.set_cx(from.camera.cx);
  to.set_cy(from.camera.cy);
  put(from.X_CM, to.mutable_pose_left_eye_map());
  to.set_sigma_per_z2(from.sigma_per_z2);
  pack(from.depth.data, *to.mutable_depth());
  if (from.minimum.empty()) return;
  std::vector<std::uint16_t> behind(from.depth.data.size());
  for (std::size_t i = 0; i < behind.size(); ++i) behind[i] = static_cast<std::uint16_t>(from.depth.data[i] - from.minimum.data[i]);
  pack(behind, *to.mutable_behind_minimum());
}

void put(const View& from, proto::View& to) {
  to.set_view_id(from.view_id);
  to.set_stamp_ns(from.stamp_ns);
  to.set_width(static_cast<std::uint32_t>(from.rig.camera.width));
  to.set_height(static_cast<std::uint32_t>(from.rig.camera.height));
  to.set_fx(from.rig.camera.fx);
  to.set_fy(from.rig.camera.fy);
  to.set_cx(from.rig.camera.cx);
  to.set_cy(from.rig.camera.cy);
  to.set_baseline(from.rig.baseline);
  put(from.X_WC, to.mutable_pose_world_camera());
  for (int n = 0; n < 36; ++n) to.add_covariance(from.covariance(n / 6, n % 6));
  to.set_silhouette_valid_share(from.silhouette_valid_share);
  for (const StoredDepth& d : from.depth) put(d, *to.add_depth_maps());
  if (!from.color.empty()) {
    to.set_color_width(static_cast<std::uint32_t>(from.color.width));
    to.set_color_height(static_cast<std::uint32_t>(from.color.height));
    pack(from.color.data, *to.mutable_color());
  }
  for (const Feature& f : from.features) {
    proto::Feature& w = *to.add_features();
    w.set_u(f.u);
    w.set_v(f.v);
    w.set_size(f.size);
    w.set_angle(f.angle);
    put(f.p_W, w.mutable_position());
    put(f.normal_W, w.mutable_normal());
    w.set_size_m(f.size_m);
    w.set_descriptor_octets(f.descriptor.data(), f.descriptor.size());
    w.set_descriptor_kind(static_cast<std::uint32_t>(f.kind));
  }
  to.set_revision(from.result.revision);
  to.mutable_counts()->set_unknown(from.result.counts.unknown);
  to.mutable_counts()->set_known(from.result.counts.known);
  to.mutable_counts()->set_empty(from.result.counts.empty);
  to.mutable_counts()->set_environment(from.result.counts.environment);
  to.set_found_gain_px(from.result.found_gain_px);
  to.set_found_gain_voxels(from.result.found_gain_voxels);
}

void check_image_size(std::uint32_t width, std::uint32_t height) {
  require(width >= 1 && height >= 1 && width <= kMostPixelsASide && height <= kMostPixelsASide, ErrorCode::bad_size,
          "an image of the model has a side outside 1..8192 pixels");
}

StoredDepth stored_depth(const proto::DepthMap& from) {
  StoredDepth to;
  check_image_size(from.width(), from.height());
  to.camera = {static_cast<int>(from.width()), static_cast<int>(from.height()), from.fx(), from.fy(), from.cx(), from.cy()};
  to.camera.check();
  to.X_CM = pose(from.pose_left_eye_map(), "pose_left_eye_map");
  const std::size_t pixels = static_cast<std::size_t>(from.width()) * from.height();
  to.depth = Image<std::uint16_t>(to.camera.width, to.camera.height, 1);
  to.depth.data = unpack<std::uint16_t>(from.depth(), pixels, "depth");
  to.sigma_per_z2 = from.sigma_per_z2();
  require(to.sigma_per_z2 >= 0 && to.sigma_per_z2 <= 1, ErrorCode::bad_input, "a view's `sigma_per_z2` must lie between 0 and 1");
  if (!from.has_behind_minimum()) return to;
  to.minimum = to.depth;
  const auto behind = unpack<std::uint16_t>(from.behind_minimum(), pixels, "behind_minimum");
  for (std::size_t i = 0; i < pixels; ++i) {
    require(behind[i] <= to.depth.data[i], ErrorCode::bad_input, "a view's least depth lies before the camera");
    to.minimum.data[i] = static_cast<std::uint16_t>(to.depth.data[i] - behind[i]);
  }
  return to;
}

// Of version 1: the left eye's, of the size of its camera.
StoredDepth depth_of_version_1(const proto::View& from, const Pinhole& camera) {
  require(static_cast<int>(from.depth_width()) == camera.width && static_cast<int>(from.depth_height()) == camera.height, ErrorCode::bad_size,
          "a view's depth does not have the size of its camera's image");
  StoredDepth to;
  to.camera = camera;
  to.depth = Image<std::uint16_t>(camera.width, camera.height, 1);
  to.depth.data = unpack<std::uint16_t>(from.depth(), to.depth.data.size(), "depth");
  return to;
}

std::shared_ptr<const View> view(const proto::View& from) {
  auto to = std::make_shared<View>();
  require(!from.view_id().empty() && from.view_id().size() <= 64, ErrorCode::bad_input, "a view's id must have 1 to 64 characters");
  to->view_id = from.view_id();
  to->stamp_ns = from.stamp_ns();
  check_image_size(from.width(), from.height());
  to->rig.camera = {static_cast<int>(from.width()), static_cast<int>(from.height()), from.fx(), from.fy(), from.cx(), from.cy()};
  to->rig.baseline = from.baseline();
  to->rig.check();
  to->X_WC = pose(from.pose_world_camera(), "pose_world_camera");
  require_numbers(from.covariance(), 36, "covariance");
  for (int n = 0; n < 36; ++n) to->covariance(n / 6, n % 6) = from.covariance(n);
  to->silhouette_valid_share = finite(from.silhouette_valid_share(), "silhouette_valid_share");
  require(from.depth_maps_size() <= 2, ErrorCode::bad_size, "a view keeps at most two depth maps");
  for (const proto::DepthMap& d : from.depth_maps()) to->depth.push_back(stored_depth(d));
  if (from.has_depth()) to->depth.push_back(depth_of_version_1(from, to->rig.camera));
  if (from.has_color()) {
    check_image_size(from.color_width(), from.color_height());
    to->color.width = static_cast<int>(from.color_width());
    to->color.height = static_cast<int>(from.color_height());
    to->color.channels = 3;
    to->color.data = unpack<std::uint8_t>(from.color(), static_cast<std::size_t>(from.color_width()) * from.color_height() * 3, "color");
  }
  require(static_cast<std::size_t>(from.features_size()) <= kMostFeatures, ErrorCode::bad_size, "a view has at most 8192 features");
  for (const proto::Feature& w : from.features()) {
    Feature f;
    f.u = static_cast<float>(finite(w.u(), "u"));
    f.v = static_cast<float>(finite(w.v(), "v"));
    f.size = static_cast<float>(finite(w.size(), "size"));
    f.angle = static_cast<float>(finite(w.angle(), "angle"));
    f.p_W = vector(w.position(), "position");
    f.normal_W = vector(w.normal(), "normal");
    f.size_m = finite(w.size_m(), "size_m");
    require(w.descriptor_octets().size() <= kMostDescriptor, ErrorCode::bad_size, "a feature's descriptor has at most 512 octets");
    const auto kind = descriptor_kind(w.descriptor_kind());
    require(kind.has_value(), ErrorCode::bad_input,
            "a feature's descriptor is of kind " + std::to_string(w.descriptor_kind()) + ", which this program does not know: use the program that wrote it");
    f.kind = *kind;
    f.descriptor.assign(w.descriptor_octets().begin(), w.descriptor_octets().end());
    to->features.push_back(std::move(f));
  }
  to->result.revision = from.revision();
  to->result.counts = {from.counts().unknown(), from.counts().known(), from.counts().empty(), from.counts().environment()};
  to->result.found_gain_px = finite(from.found_gain_px(), "found_gain_px");
  to->result.found_gain_voxels = finite(from.found_gain_voxels(), "found_gain_voxels");
  return to;
}

// The bricks that a field holds, in order; and their values one after another.
template <class Brick>
std::vector<std::uint32_t> held(const voxel::BrickField<Brick>& field) {
  std::vector<std::uint32_t> out;
  for (std::size_t b = 0; b < field.size(); ++b)
    if (field.find(b)) out.push_back(static_cast<std::uint32_t>(b));
  return out;
}

template <class T, class Brick, class Values>
std::vector<T> gathered(const voxel::BrickField<Brick>& field, const std::vector<std::uint32_t>& held, Values&& values) {
  std::vector<T> out;
  out.reserve(held.size() * voxel::kBrickVoxels);
  for (const std::uint32_t b : held) {
    const auto& from = values(*field.find(b));
    out.insert(out.end(), from.begin(), from.end());
  }
  return out;
}

std::vector<std::uint32_t> bricks(const proto::Array& from, std::size_t bricks, const char* what) {
  require(from.elements() <= bricks, ErrorCode::bad_size, std::string("the model's `") + what + "` names more bricks than its grid has");
  const auto out = unpack<std::uint32_t>(from, from.elements(), what);
  for (std::size_t n = 0; n < out.size(); ++n) {
    require(out[n] < bricks && (n == 0 || out[n] > out[n - 1]), ErrorCode::bad_input,
            std::string("the model's `") + what + "` must name bricks of its grid in order, each once");
  }
  return out;
}

template <class T, class Brick, class Values>
void scatter(const std::vector<T>& from, const std::vector<std::uint32_t>& held, voxel::BrickField<Brick>& field, Values&& values) {
  for (std::size_t n = 0; n < held.size(); ++n)
    std::copy_n(&from[n * voxel::kBrickVoxels], voxel::kBrickVoxels, values(field.hold(held[n])).begin());
}

// Distances as version 3 wrote them: a sample for each voxel of the bricks named.
void read_every_sample(const proto::Model& from, const std::vector<std::uint32_t>& bricks, Tsdf& to) {
  const auto samples = unpack<TsdfSample>(from.tsdf(), bricks.size() * voxel::kBrickVoxels, "tsdf");
  TsdfBrick brick;
  for (std::size_t n = 0; n < bricks.size(); ++n) {
    std::copy_n(&samples[n * voxel::kBrickVoxels], voxel::kBrickVoxels, brick.begin());
    to.bricks().hold(bricks[n]) = PackedTsdfBrick(brick);
  }
}

void read_distinct_samples(const proto::Model& from, const std::vector<std::uint32_t>& bricks, Tsdf& to) {
  const auto distinct = unpack<std::uint16_t>(from.tsdf_distinct(), bricks.size(), "tsdf_distinct");
  std::size_t all_samples = 0, all_words = 0;
  for (const std::uint16_t n : distinct) {
    require(n >= 1 && n <= voxel::kBrickVoxels, ErrorCode::bad_size, "the model's `tsdf_distinct` must lie between 1 and 512");
    all_samples += n;
    all_words += PackedTsdfBrick::word_count(n);
  }
  const auto samples = unpack<TsdfSample>(from.tsdf(), all_samples, "tsdf");
  const auto words = unpack<std::uint64_t>(from.tsdf_places(), all_words, "tsdf_places");
  auto sample = samples.begin();
  auto word = words.begin();
  for (std::size_t n = 0; n < bricks.size(); ++n) {
    const auto last_sample = sample + distinct[n];
    const auto last_word = word + static_cast<std::ptrdiff_t>(PackedTsdfBrick::word_count(distinct[n]));
    to.bricks().hold(bricks[n]) = PackedTsdfBrick({sample, last_sample}, {word, last_word});
    sample = last_sample;
    word = last_word;
  }
}

void read_bricks(const proto::Model& from, ModelState& to) {
  const auto evidence = bricks(from.evidence_bricks(), to.evidence.bricks().size(), "evidence_bricks");
  const std::size_t counters = evidence.size() * voxel::kBrickVoxels;
  scatter(unpack<std::uint16_t>(from.points(), counters, "points"), evidence, to.evidence.bricks(), [](EvidenceBrick& b) -> auto& { return b.points; });
  scatter(unpack<std::uint16_t>(from.seen(), counters, "seen"), evidence, to.evidence.bricks(), [](EvidenceBrick& b) -> auto& { return b.seen; });
  scatter(unpack<std::uint16_t>(from.solid(), counters, "solid"), evidence, to.evidence.bricks(), [](EvidenceBrick& b) -> auto& { return b.solid; });
  scatter(unpack<std::uint8_t>(from.votes(), counters, "votes"), evidence, to.evidence.bricks(), [](EvidenceBrick& b) -> auto& { return b.votes; });
  if (from.has_is_probabilistic()) to.mode = from.is_probabilistic() ? CarvingMode::probabilistic : CarvingMode::conservative;
  if (from.is_probabilistic()) {
    const auto log_odds = bricks(from.log_odds_bricks(), to.log_odds.bricks().size(), "log_odds_bricks");
    scatter(unpack<std::int16_t>(from.log_odds(), log_odds.size() * voxel::kBrickVoxels, "log_odds"), log_odds, to.log_odds.bricks(),
            [](LogOddsBrick& b) -> auto& { return b; });
  }
  to.tsdf.free() = unpack<TsdfSample>(from.tsdf_free(), to.tsdf.bricks().size(), "tsdf_free");
  const auto tsdf = bricks(from.tsdf_bricks(), to.tsdf.bricks().size(), "tsdf_bricks");
  if (from.version() < 4)
    read_every_sample(from, tsdf, to.tsdf);
  else
    read_distinct_samples(from, tsdf, to.tsdf);
}

// As versions 1 and 2 wrote them: a value for every voxel of the grid.
void read_every_voxel(const proto::Model& from, const voxel::GridGeometry& g, ModelState& to) {
  const std::size_t voxels = static_cast<std::size_t>(g.size.x()) * g.size.y() * g.size.z();
  const auto points = unpack<std::uint16_t>(from.points(), voxels, "points"), seen = unpack<std::uint16_t>(from.seen(), voxels, "seen");
  const auto solid = unpack<std::uint16_t>(from.solid(), voxels, "solid");
  const auto votes = unpack<std::uint8_t>(from.votes(), voxels, "votes");
  const auto tsdf = unpack<TsdfSample>(from.tsdf(), voxels, "tsdf");
  to.mode = CarvingMode::conservative;
  TsdfBrick samples;
  for (std::size_t b = 0; b < to.tsdf.bricks().size(); ++b) {
    samples.fill({});
    bool any = false;
    const Eigen::Vector3i first = 8 * g.brick_position(b);
    for (int n = 0; n < voxel::kBrickVoxels; ++n) {
      const Eigen::Vector3i v = first + Eigen::Vector3i(n >> 6, n >> 3 & 7, n & 7);
      if (!g.contains(v)) continue;
      const std::size_t i = voxel::voxel_index(g, v);
      const VoxelEvidence e{points[i], seen[i], solid[i], votes[i]};
      if (e != VoxelEvidence{}) to.evidence.set(v, e);
      samples[static_cast<std::size_t>(n)] = tsdf[i];
      any |= tsdf[i].weight != 0;
    }
    if (any) to.tsdf.bricks().hold(b) = PackedTsdfBrick(samples);
  }
}

void put_distances(const Tsdf& from, proto::Model& to) {
  const auto bricks = held(from.bricks());
  std::vector<std::uint16_t> distinct;
  std::vector<TsdfSample> samples;
  std::vector<std::uint64_t> words;
  for (const std::uint32_t b : bricks) {
    const PackedTsdfBrick& brick = *from.bricks().find(b);
    distinct.push_back(static_cast<std::uint16_t>(brick.distinct().size()));
    samples.insert(samples.end(), brick.distinct().begin(), brick.distinct().end());
    words.insert(words.end(), brick.words().begin(), brick.words().end());
  }
  pack(from.free(), *to.mutable_tsdf_free());
  pack(bricks, *to.mutable_tsdf_bricks());
  pack(distinct, *to.mutable_tsdf_distinct());
  pack(samples, *to.mutable_tsdf());
  pack(words, *to.mutable_tsdf_places());
}

void put_state(const ModelState& from, proto::Model& to) {
  to.set_object_id(from.object_id);
  to.set_environment_revision(from.environment_revision);
  put(from.box.X_WB, to.mutable_pose_world_box());
  put(from.box.size, to.mutable_box_size());
  if (!same_box(from.begun_box, from.box)) {
    put(from.begun_box.X_WB, to.mutable_pose_begun_box());
    put(from.begun_box.size, to.mutable_begun_box_size());
  }
  const voxel::GridGeometry& g = from.grid.geometry();
  put(g.X_WG, to.mutable_pose_world_grid());
  to.set_voxel_m(g.voxel_size);
  for (int n = 0; n < 3; ++n) to.add_size(static_cast<std::uint32_t>(g.size[n]));
  to.set_revision(from.grid.revision);
  pack(from.grid.occupied(), *to.mutable_occupied());
  pack(from.grid.known(), *to.mutable_known());
  pack(from.grid.environment(), *to.mutable_environment());
  pack(from.known_solids, *to.mutable_known_solids());
  const auto evidence = held(from.evidence.bricks());
  pack(evidence, *to.mutable_evidence_bricks());
  pack(gathered<std::uint16_t>(from.evidence.bricks(), evidence, [](const EvidenceBrick& b) { return b.points; }), *to.mutable_points());
  pack(gathered<std::uint16_t>(from.evidence.bricks(), evidence, [](const EvidenceBrick& b) { return b.seen; }), *to.mutable_seen());
  pack(gathered<std::uint16_t>(from.evidence.bricks(), evidence, [](const EvidenceBrick& b) { return b.solid; }), *to.mutable_solid());
  pack(gathered<std::uint8_t>(from.evidence.bricks(), evidence, [](const EvidenceBrick& b) { return b.votes; }), *to.mutable_votes());
  if (from.mode) to.set_is_probabilistic(*from.mode == CarvingMode::probabilistic);
  if (from.mode == CarvingMode::probabilistic) {
    const auto log_odds = held(from.log_odds.bricks());
    pack(log_odds, *to.mutable_log_odds_bricks());
    pack(gathered<std::int16_t>(from.log_odds.bricks(), log_odds, [](const LogOddsBrick& b) { return b; }), *to.mutable_log_odds());
  }
  put_distances(from.tsdf, to);
  to.set_version(kVersion);
  to.set_imported(from.imported);
  for (const ModelEvent& e : from.history) {
    proto::Event& w = *to.add_history();
    w.set_stamp_ns(e.stamp_ns);
    w.set_what(e.what);
    w.set_detail(e.detail);
    w.set_revision(e.revision);
    w.set_program(e.program);
  }
}

ModelState state(const proto::Model& from) {
  ModelState to;
  require(from.version() <= kVersion, ErrorCode::bad_input,
          "a model of version " + std::to_string(from.version()) + "; this program reads up to version " + std::to_string(kVersion) + ": use the program that wrote it");
  require(!from.object_id().empty() && from.object_id().size() <= 64, ErrorCode::bad_input, "the object's id must have 1 to 64 characters");
  require(from.environment_revision().size() <= 64, ErrorCode::bad_input, "the environment's revision has at most 64 characters");
  to.object_id = from.object_id();
  to.environment_revision = from.environment_revision();
  to.box.X_WB = pose(from.pose_world_box(), "pose_world_box");
  to.box.size = vector(from.box_size(), "box_size");
  to.begun_box = to.box;
  if (from.begun_box_size_size() > 0) {
    to.begun_box.X_WB = pose(from.pose_begun_box(), "pose_begun_box");
    to.begun_box.size = vector(from.begun_box_size(), "begun_box_size");
  }
  require(from.size_size() == 3, ErrorCode::bad_size, "the grid's size needs three numbers");
  voxel::GridGeometry g;
  g.X_WG = pose(from.pose_world_grid(), "pose_world_grid");
  g.voxel_size = from.voxel_m();
  for (int n = 0; n < 3; ++n) g.size[n] = static_cast<int>(std::min<std::uint32_t>(from.size(n), 1u << 20));
  g.check();
  const Eigen::Vector3i nb = g.bricks();
  const std::size_t words = static_cast<std::size_t>(nb.x()) * nb.y() * nb.z() * 8;
  auto occupied = unpack<std::uint64_t>(from.occupied(), words, "occupied");
  auto known = unpack<std::uint64_t>(from.known(), words, "known");
  auto environment = unpack<std::uint64_t>(from.environment(), words, "environment");
  to.known_solids = unpack<std::uint64_t>(from.known_solids(), words, "known_solids");
  to.evidence = Evidence(g);
  to.log_odds = LogOdds(g);
  to.tsdf = Tsdf(g);
  if (from.version() < 3)
    read_every_voxel(from, g, to);
  else
    read_bricks(from, to);
  to.grid = voxel::OccupancyGrid(g);
  to.grid.revision = from.revision();
  to.grid.adopt(std::move(occupied), std::move(known), std::move(environment));
  to.imported = from.imported();
  require(static_cast<std::size_t>(from.history_size()) <= kMostEvents, ErrorCode::bad_size, "a model's history has at most 4096 events");
  for (const proto::Event& e : from.history()) {
    require(e.what().size() <= 64 && e.detail().size() <= 256 && e.program().size() <= 64, ErrorCode::bad_size, "an event of the model's history is too long");
    to.history.push_back({e.stamp_ns(), e.what(), e.detail(), e.revision(), e.program()});
  }
  return to;
}

std::string serialized(const google::protobuf::Message& message) {
  std::string text;
  require(message.SerializeToString(&text), ErrorCode::bad_size, "the model is too large for its format (2 GiB); use larger voxels");
  return text;
}

template <class Message>
Message parsed(std::string_view text, const char* what) {
  Message message;
  require(text.size() < (std::size_t{1} << 31) && message.ParseFromArray(text.data(), static_cast<int>(text.size())), ErrorCode::bad_input,
          std::string("the ") + what + " is not one of ours, or damaged");
  return message;
}

}  // namespace

std::string write_state(const ObjectModel& model, const std::vector<std::string>& view_sha256) {
  require(view_sha256.size() == model.state().views.size(), ErrorCode::internal, "a stored model names each of its views");
  proto::Model m;
  put_state(model.state(), m);
  for (std::size_t n = 0; n < view_sha256.size(); ++n) {
    proto::ViewReference& r = *m.add_references();
    r.set_view_id(model.state().views[n]->view_id);
    r.set_sha256(view_sha256[n]);
  }
  return serialized(m);
}

std::string write_view(const View& v) {
  proto::View m;
  put(v, m);
  return serialized(m);
}

ObjectModel read_parts(std::string_view state_text, const std::vector<std::string>& views) {
  const auto m = parsed<proto::Model>(state_text, "stored model");
  std::vector<proto::View> parsed_views;
  for (const std::string& text : views) parsed_views.push_back(parsed<proto::View>(text, "stored view"));
  check_claims(m, parsed_views);
  if (m.version() >= 2) {
    require(m.references_size() == static_cast<int>(views.size()), ErrorCode::bad_input,
            "the stored model has " + std::to_string(m.references_size()) + " views, " + std::to_string(views.size()) + " are there");
    for (int n = 0; n < m.references_size(); ++n) {
      const auto at = static_cast<std::size_t>(n);
      require(m.references(n).view_id() == parsed_views[at].view_id() && m.references(n).sha256() == sha256_hex(views[at]), ErrorCode::bad_input,
              "the stored view " + std::to_string(n + 1) + " is not the one that the model names: it is damaged");
    }
  }
  ModelState s = state(m);
  for (const proto::View& v : parsed_views) s.views.push_back(view(v));
  return ObjectModel(std::move(s));
}

bool is_current(std::string_view state_text) { return parsed<proto::Model>(state_text, "stored model").version() == kVersion; }

std::string write_model(const ObjectModel& model) {
  proto::Model m;
  put_state(model.state(), m);
  m.clear_history();
  for (const auto& v : model.state().views) put(*v, *m.add_views());
  const std::string payload = serialized(m);
  return std::string(kMagic) + sha256_hex(payload) + "\n" + payload;
}

ObjectModel read_model(std::string_view file) {
  if (!file.starts_with(kMagic) && std::none_of(std::begin(kMagicsBefore), std::end(kMagicsBefore), [&](std::string_view m) { return file.starts_with(m); })) {
    constexpr std::string_view kName = "PERIPLUS-MODEL ";
    const std::size_t end = file.substr(0, kName.size() + 10).find_first_not_of("0123456789", kName.size());
    if (file.starts_with(kName) && end != std::string_view::npos && end > kName.size() && file[end] == '\n') {
      throw_error(ErrorCode::bad_input, "a Periplus model of version " + std::string(file.substr(kName.size(), end - kName.size())) +
                                            "; this program reads versions 1 to " + std::to_string(kVersion) + ": use the program that wrote it");
    }
    throw_error(ErrorCode::bad_input, "not a Periplus model: it must begin with \"PERIPLUS-MODEL 4\"");
  }
  const std::size_t header = kMagic.size() + kDigest + 1;
  require(file.size() > header, ErrorCode::bad_input, "the model file ends within its header");
  const std::string_view payload = file.substr(header);
  require(file.substr(kMagic.size(), kDigest) == sha256_hex(payload), ErrorCode::bad_input,
          "the model file is damaged: its checksum does not fit; fetch or export it again");
  const auto m = parsed<proto::Model>(payload, "model file");
  check_claims(m, m.views());
  ModelState s = state(m);
  for (const proto::View& v : m.views()) s.views.push_back(view(v));
  return ObjectModel(std::move(s));
}

ObjectModel load_model(const std::string& path) { return read_model(read_file(path, kMostFileBytes)); }

}  // namespace periplus::object_model
