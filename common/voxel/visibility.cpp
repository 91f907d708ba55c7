#include "common/voxel/visibility.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <future>
#include <utility>

#include "common/core/error.h"
#include "common/voxel/convex.h"

namespace periplus::voxel {
namespace {

// Corner c of a cell: bit 0 x, bit 1 y, bit 2 z.
Eigen::Vector3d corner(int c) { return {double(c & 1), double(c >> 1 & 1), double(c >> 2 & 1)}; }

// The silhouette of a cell seen from one of 27 regions (below, within, above along each axis): corner indices in
// turn, counter-clockwise seen from the camera.
struct Silhouettes {
  std::int32_t count[27] = {};
  std::int32_t corners[27][6] = {};
};

Silhouettes make_silhouettes() {
  // Corners of the faces -x +x -y +y -z +z, counter-clockwise from outside.
  constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  Silhouettes table;
  for (int code = 0; code < 27; ++code) {
    const int side[3] = {code / 9, code / 3 % 3, code % 3};
    bool edge[8][8] = {};
    for (int axis = 0; axis < 3; ++axis) {
      if (side[axis] == 1) continue;
      const auto& face = kFaces[axis * 2 + (side[axis] == 2)];
      for (int i = 0; i < 4; ++i) edge[face[i]][face[(i + 1) % 4]] = true;
    }
    // An edge that only one facing face has lies on the silhouette.
    std::array<int, 8> next;
    next.fill(-1);
    int start = -1;
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) {
        if (edge[i][j] && !edge[j][i]) {
          next[i] = j;
          start = i;
        }
      }
    }
    for (int at = start; at >= 0; at = next[at]) {
      table.corners[code][table.count[code]++] = at;
      if (next[at] == start) break;
    }
  }
  return table;
}

const Silhouettes& silhouettes() {
  static const Silhouettes table = make_silhouettes();
  return table;
}

constexpr double kNear = 0.001;  // what is nearer to the camera's plane than this is cut off [m]

}  // namespace

// Bricks beside the camera (within its slab along some axis) are hidden by none but such that are beside it along the same axes, and
// bricks on different sides of it hide each other neither. So: those beside it along more axes first, then side by side, each
// outward by the sum of the distances along the axes: those of equal sums do not hide each other.
void VisibilityScene::order_bricks(const Eigen::Vector3d& eye, VisibilityWorkspace& workspace) const {
  std::array<std::vector<BrickPart>, 3>& parts = workspace.parts;
  std::array<std::vector<std::int8_t>, 3>& part_count = workspace.part_count;
  std::array<std::array<std::int16_t, 128>, 3> side, distance;
  int longest = 1;
  for (int a = 0; a < 3; ++a) {
    const int count = bricks_[a];
    parts[a].assign(3 * static_cast<std::size_t>(count), {});
    part_count[a].assign(static_cast<std::size_t>(count), 1);
    const int own = static_cast<int>(std::floor(std::clamp(eye[a] / 8, -1.0, double(count))));
    for (int i = 0; i < count; ++i) {
      BrickPart* part = &parts[a][3 * static_cast<std::size_t>(i)];
      side[a][i] = static_cast<std::int16_t>(i > own ? 0 : i == own ? 1 : 2);
      distance[a][i] = static_cast<std::int16_t>(std::abs(i - own));
      if (i != own) {
        *part = {static_cast<std::int8_t>(side[a][i]), 0, 7};
        continue;
      }
      // The camera's own voxel, if it is not just on a side of it, then those beyond.
      const BrickPart* first = part;
      const int low = static_cast<int>(std::floor(eye[a])) - 8 * i, up = static_cast<int>(std::ceil(eye[a])) - 8 * i;
      if (low < up) *part++ = {1, static_cast<std::int8_t>(low), static_cast<std::int8_t>(low)};
      if (up < 8) *part++ = {0, static_cast<std::int8_t>(up), 7};
      if (low > 0) *part++ = {2, 0, static_cast<std::int8_t>(low - 1)};
      part_count[a][static_cast<std::size_t>(i)] = static_cast<std::int8_t>(part - first);
    }
    longest += count + 1;
  }
  // Counting sort by side and level.
  static const std::array<int, 27> rank = [] {
    std::array<int, 27> r{};
    int next = 0;
    for (int beside = 3; beside >= 0; --beside) {
      for (int code = 0; code < 27; ++code) {
        if ((code / 9 == 1) + (code / 3 % 3 == 1) + (code % 3 == 1) == beside) r[static_cast<std::size_t>(code)] = next++;
      }
    }
    return r;
  }();
  const auto level_of = [&](const VisibilityBrick& b) {
    const int code = side[0][b.at[0]] * 9 + side[1][b.at[1]] * 3 + side[2][b.at[2]];
    return rank[static_cast<std::size_t>(code)] * longest + distance[0][b.at[0]] + distance[1][b.at[1]] + distance[2][b.at[2]];
  };
  std::vector<std::int32_t>& end = workspace.turn_end;
  end.assign(static_cast<std::size_t>(27 * longest + 1), 0);
  workspace.brick_level.resize(lists_->bricks.size());
  for (std::size_t i = 0; i < lists_->bricks.size(); ++i) {
    workspace.brick_level[i] = level_of(lists_->bricks[i]);
    ++end[static_cast<std::size_t>(workspace.brick_level[i] + 1)];
  }
  for (std::size_t i = 1; i < end.size(); ++i) end[i] += end[i - 1];
  workspace.turns.resize(lists_->bricks.size());
  for (std::size_t i = 0; i < lists_->bricks.size(); ++i) {
    const std::int32_t level = workspace.brick_level[i];
    workspace.turns[static_cast<std::size_t>(end[static_cast<std::size_t>(level)]++)] = {static_cast<std::int32_t>(i), level};
  }
}

// One rendering: projection and coverage of single convex bodies; the grid's voxels are the kernel's.
struct VisibilityScene::Raster {
  int width, height, rows;  // rows: words a strip, see visibility_kernel.h
  std::uint32_t* coverage;
  // Homogeneous pixel coordinates of a point of the grid frame [voxels]: m * (x, y, z, 1) = (u w, v w, w), w in metres.
  Eigen::Matrix<double, 3, 4> m;
  std::vector<Eigen::Vector2d> projected;        // scratch
  std::vector<std::pair<double, double>> ends;

  // Nothing covered but what is outside of the image; or all (`closed`).
  void clear(std::vector<std::uint32_t>& words, bool closed) {
    const std::size_t strip = static_cast<std::size_t>(rows), whole = static_cast<std::size_t>(width / 32), used = static_cast<std::size_t>((width + 31) / 32);
    words.resize((used + 2) * strip);
    coverage = words.data();
    if (closed) {
      std::fill(words.begin(), words.end(), ~0u);
      return;
    }
    std::fill(coverage, coverage + used * strip, 0);
    if (whole != used) std::fill(coverage + whole * strip, coverage + used * strip, ~0u << (width & 31));
    std::fill(coverage + used * strip, coverage + (used + 2) * strip, ~0u);
    for (std::size_t s = 0; s < used; ++s) std::fill(coverage + s * strip + static_cast<std::size_t>(height), coverage + (s + 1) * strip, ~0u);
  }

  // Uncovers pixels [x0, x1) x [y0, y1) of the image, at least one.
  void open(int x0, int y0, int x1, int y1) {
    for (int s = x0 >> 5; s <= (x1 - 1) >> 5; ++s) {
      std::uint32_t keep = 0;
      if (s == x0 >> 5) keep |= ~(~0u << (x0 & 31));
      if (s == (x1 - 1) >> 5) keep |= ~(~0u >> (31 - ((x1 - 1) & 31)));
      std::uint32_t* column = coverage + static_cast<std::size_t>(s) * static_cast<std::size_t>(rows);
      for (int y = y0; y < y1; ++y) column[y] &= keep;
    }
  }

  std::uint32_t fill(int row, int left, int right) {
    const int first = left >> 5, last = (right - 1) >> 5;
    std::uint32_t fresh = 0;
    for (int s = first; s <= last; ++s) {
      std::uint32_t mask = ~0u;
      if (s == first) mask &= ~0u << (left & 31);
      if (s == last) mask &= ~0u >> (31 - ((right - 1) & 31));
      std::uint32_t& word = coverage[static_cast<std::size_t>(s) * static_cast<std::size_t>(rows) + static_cast<std::size_t>(row)];
      const std::uint32_t open = mask & ~word;
      if (open == 0) continue;
      fresh += open == ~0u ? 32u : static_cast<std::uint32_t>(std::popcount(open));
      word |= mask;
    }
    return fresh;
  }

  // Any convex set of points; what lies behind the camera is cut off.
  std::uint32_t fill_convex(const Points& points) {
    // Wholly outside one side of the image?
    bool left_of = true, right_of = true, above = true, below = true, cut = false;
    projected.clear();
    for (const auto& p : points) {
      const Eigen::Vector3d h = m.leftCols<3>() * p + m.col(3);
      left_of &= h.x() < 0;
      right_of &= h.x() > width * h.z();
      above &= h.y() < 0;
      below &= h.y() > height * h.z();
      cut |= h.z() < kNear;
      projected.emplace_back(h.head<2>() / h.z());
    }
    if (left_of || right_of || above || below) return 0;
    if (cut) {
      projected.clear();
      for (const auto& p : clip(points, [&](const Eigen::Vector3d& q) { return m.row(2).head<3>().dot(q) + m(2, 3) - kNear; })) {
        const Eigen::Vector3d h = m.leftCols<3>() * p + m.col(3);
        projected.emplace_back(h.head<2>() / h.z());
      }
    }
    const auto hull = convex_hull(projected);
    if (hull.size() < 3) return 0;
    double top = hull[0].y(), bottom = top;
    for (const auto& p : hull) {
      top = std::min(top, p.y());
      bottom = std::max(bottom, p.y());
    }
    const int y0 = static_cast<int>(std::ceil(std::clamp(top, 0.0, double(height))));
    const int y1 = static_cast<int>(std::ceil(std::clamp(bottom, 0.0, double(height))));
    if (y0 >= y1) return 0;
    // Each row's ends: where edges cross it, the lower end of an edge left out.
    ends.assign(static_cast<std::size_t>(y1 - y0), {1e300, -1e300});
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Eigen::Vector2d &a = hull[i], &b = hull[(i + 1) % hull.size()];
      const double low = std::min(a.y(), b.y()), high = std::max(a.y(), b.y());
      const int first = static_cast<int>(std::ceil(std::clamp(low, double(y0), double(y1))));
      const int end = static_cast<int>(std::ceil(std::clamp(high, double(y0), double(y1))));
      if (first >= end) continue;
      const double slope = (b.x() - a.x()) / (b.y() - a.y());
      for (int y = first; y < end; ++y) {
        const double x = a.x() + (y - a.y()) * slope;
        auto& [left, right] = ends[static_cast<std::size_t>(y - y0)];
        left = std::min(left, x);
        right = std::max(right, x);
      }
    }
    std::uint32_t fresh = 0;
    for (int y = y0; y < y1; ++y) {
      const auto& [left, right] = ends[static_cast<std::size_t>(y - y0)];
      const int l = static_cast<int>(std::ceil(std::clamp(left, 0.0, double(width))));
      const int r = static_cast<int>(std::ceil(std::clamp(right, 0.0, double(width))));
      if (l < r) fresh += fill(y, l, r);
    }
    return fresh;
  }

  std::uint32_t fill_near_voxel(int x, int y, int z) {
    Points points;
    for (int c = 0; c < 8; ++c) points.push_back(corner(c) + Eigen::Vector3d(x, y, z));
    return fill_convex(points);
  }
};

// Rectangles about them; what hides them is drawn only there then.
std::int32_t VisibilityScene::open_counted(Raster& raster, const Eigen::Vector3d& eye, const ViewOptions& options, VisibilityWorkspace& workspace) const {
  const Eigen::Matrix<float, 3, 4> m = raster.m.cast<float>();
  const Eigen::Matrix3f half = m.leftCols<3>() / 2;
  const float depth_min = static_cast<float>(options.depth_min), depth_max = static_cast<float>(options.depth_max);
  const auto pixel = [](float x, int size) { return static_cast<int>(std::clamp(x, 0.0f, static_cast<float>(size))); };
  int own[3];
  for (int a = 0; a < 3; ++a) own[a] = static_cast<int>(std::floor(std::clamp(eye[a] / 8, -1.0, double(bricks_[a]))));
  std::int32_t last = -1;  // level
  for (const Counted& c : lists_->counted) {
    const std::int32_t* at = lists_->bricks[static_cast<std::size_t>(c.brick)].at;
    const bool beside = at[0] == own[0] || at[1] == own[1] || at[2] == own[2];
    const int octant = (at[0] < own[0] ? 1 : 0) | (at[1] < own[1] ? 2 : 0) | (at[2] < own[2] ? 4 : 0);
    if (!beside && (c.octants >> octant & 1) == 0) continue;
    const Eigen::Vector3f middle(c.middle[0], c.middle[1], c.middle[2]), extent(c.extent[0], c.extent[1], c.extent[2]);
    const Eigen::Vector3f p = m.leftCols<3>() * middle + m.col(3);
    const float reach = half.row(2).cwiseAbs().dot(extent), nearest = p.z() - reach;
    if (nearest > depth_max || p.z() + reach < depth_min) continue;
    if (nearest < 2 * static_cast<float>(kNear)) {
      raster.open(0, 0, raster.width, raster.height);
      return static_cast<std::int32_t>(workspace.turns.size());
    }
    const float u = p.x() / p.z(), v = p.y() / p.z();
    const float ru = (half.row(0) - u * half.row(2)).cwiseAbs().dot(extent) / nearest, rv = (half.row(1) - v * half.row(2)).cwiseAbs().dot(extent) / nearest;
    // A pixel more each way for what rounding may take.
    const int x0 = pixel(u - ru - 1, raster.width), y0 = pixel(v - rv - 1, raster.height), x1 = pixel(u + ru + 2, raster.width), y1 = pixel(v + rv + 2, raster.height);
    if (x0 >= x1 || y0 >= y1) continue;
    raster.open(x0, y0, x1, y1);
    last = std::max(last, workspace.brick_level[static_cast<std::size_t>(c.brick)]);
  }
  return last < 0 ? 0 : workspace.turn_end[static_cast<std::size_t>(last)];
}

bool has_simd(Simd simd) {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2");
  static const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                             __builtin_cpu_supports("avx512vl");
  static const bool popcnt = avx512 && __builtin_cpu_supports("avx512vpopcntdq");
#else
  constexpr bool avx2 = false, avx512 = false, popcnt = false;
#endif
  switch (simd) {
    case Simd::avx2: return avx2;
    case Simd::avx512: return avx512;
    case Simd::avx512_popcnt: return popcnt;
    default: return true;
  }
}

Simd resolve(Simd simd) {
  if (simd != Simd::best) return simd;
  for (Simd s : {Simd::avx512_popcnt, Simd::avx512, Simd::avx2}) {
    if (has_simd(s)) return s;
  }
  return Simd::portable;
}

const char* to_string(Simd simd) {
  switch (simd) {
    case Simd::portable: return "portable";
    case Simd::avx2: return "avx2";
    case Simd::avx512: return "avx512";
    case Simd::avx512_popcnt: return "avx512_popcnt";
    default: return "best";
  }
}

namespace {
VisibilityKernel kernel_of(Simd simd) {
  simd = resolve(simd);
  require(has_simd(simd), ErrorCode::bad_input, std::string("this processor has no ") + to_string(simd) + "; use Simd::best");
  switch (simd) {
    case Simd::avx512_popcnt: return visibility_kernel_avx512_popcnt;
    case Simd::avx512: return visibility_kernel_avx512;
    case Simd::avx2: return visibility_kernel_avx2;
    default: return visibility_kernel_portable;
  }
}
}  // namespace

void VisibilityScene::evaluate(const Pose& X_WC, const Pinhole& camera, const ViewOptions& options, VisibilityWorkspace& workspace,
                               VisibilityResult& result) const {
  require(is_finite(X_WC), ErrorCode::not_finite, "the camera pose has a number that is not finite; give a rigid pose");
  const double intrinsics[] = {camera.fx, camera.fy, camera.cx, camera.cy};
  require(camera.width >= 1 && camera.width <= 8192 && camera.height >= 1 && camera.height <= 8192 && camera.fx > 0 && camera.fy > 0 &&
              std::all_of(std::begin(intrinsics), std::end(intrinsics), [](double x) { return std::isfinite(x); }),
          ErrorCode::bad_input, "a camera needs sides of 1 to 8192 px, positive focal lengths and a finite principal point");
  require(options.depth_min <= options.depth_max && options.more_than_pixels >= 0, ErrorCode::bad_input,
          "a depth range needs depth_min <= depth_max, a pixel threshold 0 or more");
  const VisibilityKernel kernel = kernel_of(workspace.simd);
  result.occluder_pixels = 0;

  Raster raster;
  raster.width = camera.width;
  raster.height = camera.height;
  raster.rows = (camera.height + 31) / 16 * 16;
  // Where nearly everything counts, uncovering takes longer than it saves.
  const bool masked = options.unknown_alone && 2 * lists_->counted.size() < lists_->bricks.size();
  raster.clear(workspace.coverage, masked);
  const Pose X_CG = X_WC.inverse() * geometry_.X_WG;
  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  raster.m.leftCols<3>() = K * X_CG.linear() * geometry_.voxel_size;
  raster.m.col(3) = K * X_CG.translation();
  const Eigen::Vector3d eye = geometry_.X_WG.inverse() * X_WC.translation() / geometry_.voxel_size;

  order_bricks(eye, workspace);
  const std::int32_t turn_count = masked ? open_counted(raster, eye, options, workspace) : static_cast<std::int32_t>(workspace.turns.size());

  // A ray is outside the box as long as it is beyond a side that faces the camera: those parts of the solids come first.
  for (int d = 0; d < 6; ++d) {
    if (d % 2 == 0 ? eye[d / 2] >= 0 : eye[d / 2] <= geometry_.size[d / 2]) continue;
    for (const Points& part : beyond_[d]) result.occluder_pixels += raster.fill_convex(part);
  }

  VisibilityKernelInput in{};
  in.bricks = lists_->bricks.data();
  in.codes = lists_->codes.data();
  in.turns = workspace.turns.data();
  in.turn_count = turn_count;
  in.center[0] = camera.width / 2;
  in.center[1] = camera.height / 2;
  for (int a = 0; a < 3; ++a) {
    in.size[a] = geometry_.size[a];
    in.parts[a] = workspace.parts[a].data();
    in.part_count[a] = workspace.part_count[a].data();
    for (int j = 0; j < 4; ++j) in.m[a][j] = static_cast<float>(raster.m(a, j) - (a < 2 ? in.center[a] * raster.m(2, j) : 0.0));
  }
  in.near = static_cast<float>(kNear);
  in.width = raster.width;
  in.height = raster.height;
  in.rows = raster.rows;
  in.coverage = raster.coverage;
  in.corners = silhouettes().corners;
  in.corner_count = silhouettes().count;
  in.context = &raster;
  in.fill_near = [](void* context, int x, int y, int z) { return static_cast<Raster*>(context)->fill_near_voxel(x, y, z); };

  in.depth_min = static_cast<float>(options.depth_min);
  in.depth_max = static_cast<float>(options.depth_max);
  in.more_than_pixels = static_cast<std::uint32_t>(options.more_than_pixels);

  VisibilityKernelOutput out{};
  out.unknown = result.unknown.reserve(lists_->surface + 16);
  out.watched = result.watched.reserve(watched_ + 16);
  kernel(in, out);
  result.unknown.set_size(out.unknown_count);
  result.watched.set_size(out.watched_count);
  result.unknown_pixels = out.unknown_pixels;
  result.known_pixels = out.known_pixels;
  result.environment_pixels = out.environment_pixels;
  if (options.unknown_alone) result.known_pixels = result.environment_pixels = result.occluder_pixels = 0;
}

VisibilityResult VisibilityScene::evaluate(const Pose& X_WC, const Pinhole& camera, const ViewOptions& options) const {
  VisibilityWorkspace workspace;
  VisibilityResult result;
  evaluate(X_WC, camera, options, workspace, result);
  return result;
}

PairGain VisibilityScene::evaluate_pair(const Pose& X_WC, const StereoRig& rig, const PairOptions& options,
                                        VisibilityWorkspace& w) const {
  const std::uint32_t threshold = static_cast<std::uint32_t>(std::max(0, options.more_than_pixels));
  const ViewOptions view{options.depth_min, options.depth_max, 0, true};
  PairGain gain;
  const auto count = [&](VoxelPixels both) {
    gain.pixels += both.pixels;
    gain.voxels += both.pixels > threshold;
    return both;
  };
  if (rig.baseline == 0) {
    evaluate(X_WC, rig.camera, view, w, w.left);
    w.right.clear();
    VoxelPixels* both = w.both.reserve(w.left.unknown.size());
    for (const VoxelPixels& v : w.left.unknown) *both++ = count(v);
    w.both.set_size(w.left.unknown.size());
    return gain;
  }
  rig.check();
  const auto render_right = [&](VisibilityWorkspace& scratch) { evaluate(X_WC * Pose(Eigen::Translation3d(rig.baseline, 0, 0)), rig.camera, view, scratch, w.right); };
  std::future<void> right;
  if (w.beside) {
    w.beside->simd = w.simd;
    // Where no thread starts it is drawn by this one.
    right = std::async(std::launch::async | std::launch::deferred, render_right, std::ref(*w.beside));
  }
  evaluate(X_WC, rig.camera, view, w, w.left);
  if (right.valid())
    right.get();
  else
    render_right(w);
  // The table is met at random: entries are fetched ahead.
  constexpr std::size_t kAhead = 24;
  const auto each_of = [&](const VoxelList& list, const auto& call) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (i + kAhead < list.size()) w.left_pixels.prefetch(list[i + kAhead].voxel);
      call(list[i]);
    }
  };
  w.left_pixels.clear(w.left.unknown.size());
  each_of(w.left.unknown, [&](VoxelPixels v) { w.left_pixels.add(v); });
  VoxelPixels* both = w.both.reserve(std::min(w.left.unknown.size(), w.right.unknown.size()));
  std::size_t n = 0;
  each_of(w.right.unknown, [&](VoxelPixels v) {
    const std::uint32_t pixels = std::min(v.pixels, w.left_pixels.pixels(v.voxel));
    if (pixels != 0) both[n++] = count({v.voxel, pixels});
  });
  w.both.set_size(n);
  return gain;
}

}  // namespace periplus::voxel
