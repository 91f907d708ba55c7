// What a camera would see of an occupancy grid: how many pixels of each unknown voxel (thesis 3.1.2).
//
// A front-to-back coverage rasterisation, exact up to rounding at pixel centres: the voxels of a regular grid can be
// visited in an order in which no later one hides an earlier one, so one bit a pixel is enough. Each voxel's convex
// silhouette becomes spans of a row; its visible pixels are those bits that were still clear. No depth, no ids.
// A pixel belongs to what the ray through its centre (integer coordinates) meets first. Every occupied voxel
// occludes: unknown, known and environment. Solids outside the grid occlude exactly, before the grid. The grid has at most
// 1024 voxels along x and y, 512 along z.
//
// World frame W, grid frame G (occupancy_grid.h), optical camera frame C. Lengths in metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "common/geometry/camera.h"
#include "common/geometry/pose.h"
#include "common/voxel/exposed_faces.h"
#include "common/voxel/occluder.h"
#include "common/voxel/occupancy_grid.h"
#include "common/voxel/pixel_table.h"
#include "common/voxel/visibility_kernel.h"

namespace periplus::voxel {

// A list that a rendering fills in place: its room stays from call to call and is never cleared.
class VoxelList {
 public:
  const VoxelPixels* begin() const { return room_.data(); }
  const VoxelPixels* end() const { return room_.data() + size_; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const VoxelPixels& operator[](std::size_t i) const { return room_[i]; }

  void clear() { size_ = 0; }
  // Room for `most` entries, to be written from there on; then say how many there are.
  VoxelPixels* reserve(std::size_t most) {
    if (room_.size() < most) room_.resize(most);
    return room_.data();
  }
  void set_size(std::size_t size) { size_ = size; }

 private:
  std::vector<VoxelPixels> room_;
  std::size_t size_ = 0;
};

// Which visible voxels count. What does not count still hides what is behind it.
struct ViewOptions {
  // Of the voxel's centre along the optical axis, ends included [m]. The narrower, the faster: what lies beyond is not drawn.
  double depth_min = 0, depth_max = std::numeric_limits<double>::infinity();
  int more_than_pixels = 0;  // only voxels with more visible pixels are listed; sums are over all
  // known_pixels, environment_pixels and occluder_pixels are 0; the lists and unknown_pixels are the same. Little that is
  // unknown takes little time.
  bool unknown_alone = false;
};

// Lists and sums are over the voxels that ViewOptions lets count.
struct VisibilityResult {
  VoxelList unknown;  // visible unknown voxels, nearest bricks first; each once
  VoxelList watched;  // visible watched voxels, of any state
  std::uint64_t unknown_pixels = 0, known_pixels = 0, environment_pixels = 0;
  std::uint64_t occluder_pixels = 0;  // covered by solids in front of the grid

  void clear() {
    unknown.clear();
    watched.clear();
    unknown_pixels = known_pixels = environment_pixels = occluder_pixels = 0;
  }
};

// What both eyes see of the unknown within the depth range of the pair.
struct PairGain {
  int voxels = 0;            // N_u: unknown voxels of which each eye sees more than `more_than_pixels`
  std::uint64_t pixels = 0;  // over the unknown voxels that both see: the smaller of the two eyes' pixel counts
};

struct PairOptions {
  double depth_min = 0.6, depth_max = 2.5;  // of the voxel's centre along the optical axis [m]
  int more_than_pixels = 5;                 // thesis 3.1.2: "above a defined threshold, typically 5"
};

// Instructions to compute with, each with those before it; all give the same bits. `best` is the last that the processor has;
// avx512 is F, BW, DQ and VL (Skylake-X), avx512_popcnt VPOPCNTDQ besides (Ice Lake, Zen 4).
enum class Simd { best, portable, avx2, avx512, avx512_popcnt };
bool has_simd(Simd simd);
Simd resolve(Simd simd);  // what `best` is here; others unchanged
const char* to_string(Simd simd);

// One per thread; reused from call to call so that nothing is allocated in a search.
struct VisibilityWorkspace {
  Simd simd = Simd::best;
  // After evaluate_pair: what each eye sees in the depth range (any number of pixels), and the unknown voxels that both see,
  // with the smaller of their two pixel counts. N_u are those of `both` with more than PairOptions::more_than_pixels.
  VisibilityResult left, right;
  VoxelList both;

  // If there is one, evaluate_pair renders the right eye with it on a thread of its own meanwhile: the same results.
  std::unique_ptr<VisibilityWorkspace> beside;

  // Scratch of the kernel.
  std::vector<std::uint32_t> coverage;
  std::vector<BrickTurn> turns;
  std::vector<std::int32_t> turn_end;    // by level: of its turns
  std::vector<std::int32_t> brick_level;
  std::array<std::vector<BrickPart>, 3> parts;
  std::array<std::vector<std::int8_t>, 3> part_count;
  PixelTable left_pixels;
};

// Built once for a revision of the grid; immutable, may be shared between threads.
class VisibilityScene {
 public:
  // `watched`: voxels of any state whose pixels are to be listed too (those that carry landmarks); those outside the
  // grid are left out.
  explicit VisibilityScene(const OccupancyGrid& grid, const std::vector<Occluder>& occluders = {},
                           const std::vector<Eigen::Vector3i>& watched = {});
  // The same of a grid whose faces are kept; they must not be changed afterwards. `before`: a scene of the same grid at another revision; what
  // has the same faces is taken over from it, which is faster.
  explicit VisibilityScene(std::shared_ptr<const ExposedFaces> faces, const std::vector<Occluder>& occluders = {},
                           const std::vector<Eigen::Vector3i>& watched = {}, const VisibilityScene* before = nullptr);

  // The camera may stand anywhere, inside the grid's box too; a voxel that contains it is not seen. Any pinhole will do, with
  // its principal point outside the image and as large as a panorama of 2560 x 1920.
  // Throws Error(not_finite) for a pose that is not finite, Error(bad_input) for an impossible camera or range.
  void evaluate(const Pose& X_WC, const Pinhole& camera, const ViewOptions& options, VisibilityWorkspace& workspace,
                VisibilityResult& result) const;
  void evaluate(const Pose& X_WC, const Pinhole& camera, VisibilityWorkspace& workspace, VisibilityResult& result) const {
    evaluate(X_WC, camera, {}, workspace, result);
  }
  VisibilityResult evaluate(const Pose& X_WC, const Pinhole& camera, const ViewOptions& options = {}) const;

  // Left eye at X_WC. Leaves workspace.left, right and both. A rig without baseline is one camera: it is evaluated once, `both`
  // is what it sees, and `right` is left empty.
  PairGain evaluate_pair(const Pose& X_WC, const StereoRig& rig, const PairOptions& options,
                         VisibilityWorkspace& workspace) const;

  const GridGeometry& geometry() const { return geometry_; }
  std::uint32_t index(const Eigen::Vector3i& v) const {
    return (static_cast<std::uint32_t>(v.x()) * geometry_.size.y() + v.y()) * geometry_.size.z() + v.z();
  }
  Eigen::Vector3i voxel(std::uint32_t index) const {
    const std::uint32_t ny = geometry_.size.y(), nz = geometry_.size.z();
    return Eigen::Vector3i(index / nz / ny, index / nz % ny, index % nz);
  }

  // Voxels with a face that no occupied voxel covers.
  struct Face {
    std::uint32_t voxel = 0;
    int direction = 0;  // 0 -x, 1 +x, 2 -y, 3 +y, 4 -z, 5 +z of the grid frame
  };
  // Free faces of unknown voxels, every `stride`-th.
  std::vector<Face> unknown_faces(std::size_t stride = 1) const;
  std::size_t unknown_face_count() const;
  // All voxels with a free face, in the order of the bricks.
  std::vector<std::uint32_t> surface() const;

 private:
  struct Raster;
  // A brick with unknown or watched voxels that have a free face.
  struct Counted {
    std::int32_t brick;          // of Lists::bricks
    std::uint8_t octants;        // of camera positions that such a face looks to; bit as in VisibilityBrick
    float middle[3], extent[3];  // box around these voxels, in the grid [voxels]
  };
  // What the kernel reads of the voxels with a free face, in the order of the bricks.
  struct Lists {
    std::vector<VisibilityBrick> bricks;
    std::vector<Counted> counted;
    std::vector<std::uint32_t> codes;
    std::size_t surface = 0;  // voxels with a free face
  };
  static void list_brick(const ExposedBrick& p, const Eigen::Vector3i& at, const std::array<std::uint64_t, 8>* watch, Lists& lists);
  static void take_over(const Lists& before, std::size_t from, const Counted* counted, Lists& lists);
  std::shared_ptr<const Lists> list_voxels(const std::vector<Eigen::Vector3i>& watched, const VisibilityScene* before) const;
  void put_occluders(const std::vector<Occluder>& occluders);
  // To workspace.turns, outward from the eye (grid frame, voxels).
  void order_bricks(const Eigen::Vector3d& eye, VisibilityWorkspace& workspace) const;
  // Uncovers where unknown or watched voxels may lie. How many of the turns they take: none behind these hides them.
  std::int32_t open_counted(Raster& raster, const Eigen::Vector3d& eye, const ViewOptions& options, VisibilityWorkspace& workspace) const;

  GridGeometry geometry_;
  Eigen::Vector3i bricks_{0, 0, 0};
  std::shared_ptr<const ExposedFaces> faces_;
  std::shared_ptr<const Lists> lists_;
  std::size_t watched_ = 0;
  // Parts of the solids beyond each side of the grid's box, in the grid frame [voxels]; by direction as in Face.
  std::array<std::vector<std::vector<Eigen::Vector3d>>, 6> beyond_;
};

}  // namespace periplus::voxel
