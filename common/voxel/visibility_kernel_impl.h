// The algorithm of visibility_kernel.h over 16 lanes (`Lanes`), included by the unit of each instruction set alone.
//
// Voxels go by sixteen, in an order in which no later one hides an earlier one: their silhouettes are projected together,
// then each fills its rows, sixteen at a time, into the coverage. No operation is fused, reordered or approximated
// (-ffp-contract=off, divisions), so that every Lanes gives the same bits.
//
// Lanes: F sixteen floats, I sixteen 32-bit integers, Sum a count of pixels in parts; masks are sixteen bits.
#pragma once

#include "common/voxel/visibility_kernel.h"

namespace periplus::voxel {
namespace {

constexpr float kFlat = 1e-4f;      // an edge that rises less bounds no row
constexpr float kNoBound = 1e6f;

template <class Lanes>
class Kernel {
  using F = typename Lanes::F;
  using I = typename Lanes::I;
  using Sum = typename Lanes::Sum;

 public:
  Kernel(const VisibilityKernelInput& input, VisibilityKernelOutput& output) : in(input), out(output) {}

  void run() {
    out.unknown_count = out.watched_count = 0;
    out.unknown_pixels = out.known_pixels = out.environment_pixels = 0;
    for (int i = 0; i < in.count[0]; ++i) {
      const int bx = in.brick_order[0][i];
      for (int j = 0; j < in.count[1]; ++j) {
        const int by = in.brick_order[1][j];
        const std::uint64_t row = in.occupied_row[static_cast<long>(bx) * in.count[1] + by];
        if (row == 0) continue;
        for (int k = 0; k < in.count[2]; ++k) {
          const int bz = in.brick_order[2][k];
          if ((row >> bz & 1) == 0) continue;
          const VisibilityBrick& brick = in.bricks[in.index[(static_cast<long>(bx) * in.count[1] + by) * in.count[2] + bz]];
          if (brick_visible(bx, by, bz)) visit(brick, bx, by, bz);
        }
      }
    }
  }

 private:
  bool covered(int x0, int y0, int x1, int y1) const {  // inclusive
    const int s0 = x0 >> 5, s1 = x1 >> 5;
    for (int s = s0; s <= s1; ++s) {
      std::uint32_t mask = ~0u;
      if (s == s0) mask &= ~0u << (x0 & 31);
      if (s == s1) mask &= ~0u >> (31 - (x1 & 31));
      const std::uint32_t* column = in.coverage + static_cast<long>(s) * in.rows;
      for (int y = y0; y <= y1; y += 16) {
        if (!Lanes::all_set(column + y, mask, y1 - y + 1)) return false;
      }
    }
    return true;
  }

  bool brick_visible(int bx, int by, int bz) const {
    float base[3];
    for (int a = 0; a < 3; ++a) base[a] = ((in.m[a][0] * static_cast<float>(8 * bx) + in.m[a][1] * static_cast<float>(8 * by)) + in.m[a][2] * static_cast<float>(8 * bz)) + in.m[a][3];
    // Corners 8 to 15 repeat 0 to 7.
    const F eight = Lanes::set(8.0f);
    const F w = Lanes::add(Lanes::mul(Lanes::load_twice(in.step[2]), eight), Lanes::set(base[2]));
    const unsigned behind = Lanes::less(w, Lanes::set(in.near)) & 255u;
    if (behind == 255u) return false;
    // Wholly beyond the depth range it hides only what lies there too.
    if (Lanes::less(Lanes::set(in.depth_max), w) == 0xffffu) return false;
    if (behind != 0) return true;
    const F u = Lanes::div(Lanes::add(Lanes::mul(Lanes::load_twice(in.step[0]), eight), Lanes::set(base[0])), w);
    const F v = Lanes::div(Lanes::add(Lanes::mul(Lanes::load_twice(in.step[1]), eight), Lanes::set(base[1])), w);
    const float x0 = Lanes::least(u), x1 = Lanes::greatest(u), y0 = Lanes::least(v), y1 = Lanes::greatest(v);
    if (!(x1 > 0) || !(y1 > 0) || !(x0 < static_cast<float>(in.width)) || !(y0 < static_cast<float>(in.height))) return false;
    return !covered(x0 > 0 ? static_cast<int>(x0) : 0, y0 > 0 ? static_cast<int>(y0) : 0,
                    x1 < static_cast<float>(in.width - 2) ? static_cast<int>(x1) + 1 : in.width - 1,
                    y1 < static_cast<float>(in.height - 2) ? static_cast<int>(y1) + 1 : in.height - 1);
  }

  void visit(const VisibilityBrick& brick, int bx, int by, int bz) {
    const std::int8_t *side_x = in.side[0] + bx * 8, *side_y = in.side[1] + by * 8, *side_z = in.side[2] + bz * 8;
    const std::int8_t *order_x = in.cell_order[0] + bx * 8, *order_y = in.cell_order[1] + by * 8, *order_z = in.cell_order[2] + bz * 8;
    // Voxels whose faces along y and z can face the camera.
    constexpr std::uint64_t kZLow = 0x0101010101010101ull;
    std::uint64_t facing[6] = {0, 0, 0, 0, 0, 0};
    for (int t = 0; t < 8; ++t) {
      if (side_y[t] == 0) facing[2] |= 0xffull << (8 * t);
      if (side_y[t] == 2) facing[3] |= 0xffull << (8 * t);
      if (side_z[t] == 0) facing[4] |= kZLow << t;
      if (side_z[t] == 2) facing[5] |= kZLow << t;
    }
    brick_ = &brick;
    queued_ = 0;
    case_ = -1;
    const int first_z = order_z[0];  // outward: up from there, then down
    for (int i = 0; i < 8; ++i) {
      const int x = order_x[i], sx = side_x[x];
      std::uint64_t seen = sx == 0 ? brick.free_face[0][x] : sx == 2 ? brick.free_face[1][x] : 0;
      for (int d = 2; d < 6; ++d) seen |= brick.free_face[d][x] & facing[d];
      if (seen == 0) continue;
      for (int j = 0; j < 8; ++j) {
        const int y = order_y[j];
        const unsigned line = static_cast<unsigned>(seen >> (8 * y)) & 255u;
        if (line == 0) continue;
        const int sxy = sx * 9 + side_y[y] * 3;
        unsigned up = line & (255u << first_z);
        unsigned down = line & ~up;
        for (; up != 0; up &= up - 1) {
          const int z = __builtin_ctz(up);
          push(sxy + side_z[z], bx * 8 + x, by * 8 + y, bz * 8 + z);
        }
        while (down != 0) {
          const int z = 31 - __builtin_clz(down);
          down &= ~(1u << z);
          push(sxy + side_z[z], bx * 8 + x, by * 8 + y, bz * 8 + z);
        }
      }
    }
    flush();
  }

  void push(int code, int x, int y, int z) {
    if (code != case_ || queued_ == 16) {
      flush();
      case_ = code;
    }
    x_[queued_] = x;
    y_[queued_] = y;
    z_[queued_] = z;
    ++queued_;
  }

  void flush() {
    const int n = queued_;
    queued_ = 0;
    if (n == 0) return;
    const int corners = in.corner_count[case_];
    if (corners == 0) return;
    const std::int32_t* corner = in.corners[case_];
    const F X = Lanes::convert(Lanes::load(x_)), Y = Lanes::convert(Lanes::load(y_)), Z = Lanes::convert(Lanes::load(z_));
    F h[3];
    for (int a = 0; a < 3; ++a) {
      h[a] = Lanes::add(Lanes::add(Lanes::add(Lanes::mul(Lanes::set(in.m[a][0]), X), Lanes::mul(Lanes::set(in.m[a][1]), Y)), Lanes::mul(Lanes::set(in.m[a][2]), Z)),
                        Lanes::set(in.m[a][3]));
    }
    const unsigned live = (n == 16 ? 0xffffu : (1u << n) - 1);
    unsigned behind = 0, ahead = 0;
    F u[6], v[6];
    F left = Lanes::set(1e30f), right = Lanes::set(-1e30f), top = left, bottom = right;
    const F near = Lanes::set(in.near), one = Lanes::set(1.0f);
    for (int i = 0; i < corners; ++i) {
      const int c = corner[i];
      const F w = Lanes::add(h[2], Lanes::set(in.step[2][c]));
      const unsigned cut = Lanes::less(w, near);
      behind |= cut;
      ahead |= ~cut;
      const F inverse = Lanes::div(one, w);
      u[i] = Lanes::mul(Lanes::add(h[0], Lanes::set(in.step[0][c])), inverse);
      v[i] = Lanes::mul(Lanes::add(h[1], Lanes::set(in.step[1][c])), inverse);
      left = Lanes::min(left, u[i]);
      right = Lanes::max(right, u[i]);
      top = Lanes::min(top, v[i]);
      bottom = Lanes::max(bottom, v[i]);
    }
    const unsigned near_ones = behind & ahead & live;
    const F depth = Lanes::add(h[2], Lanes::set(0.5f * in.step[2][7]));
    const unsigned out_of_range = Lanes::less(depth, Lanes::set(in.depth_min)) | Lanes::less(Lanes::set(in.depth_max), depth);
    const F zero = Lanes::set(0.0f), width = Lanes::set(static_cast<float>(in.width)), height = Lanes::set(static_cast<float>(in.height));
    // Clamped before they become integers, then [x0, x1) x [y0, y1) holds every pixel that the silhouette can cover.
    const F x0 = Lanes::ceil(Lanes::min(Lanes::max(left, zero), width)), x1 = Lanes::ceil(Lanes::min(Lanes::max(right, zero), width));
    const F y0 = Lanes::ceil(Lanes::min(Lanes::max(top, zero), height)), y1 = Lanes::ceil(Lanes::min(Lanes::max(bottom, zero), height));
    const unsigned inside = Lanes::less(x0, x1) & Lanes::less(y0, y1) & live & ~behind;
    unsigned left_to_fill = inside | near_ones;
    if (left_to_fill == 0) return;
    Lanes::store(x0_, Lanes::truncate(x0));
    Lanes::store(x1_, Lanes::truncate(x1));
    Lanes::store(y0_, Lanes::truncate(y0));
    Lanes::store(y1_, Lanes::truncate(y1));
    // Each edge bounds the rows from the left (it goes down the image) or from the right: x = start + slope * (row - y0).
    unsigned lefts[6];
    for (int i = 0; i < corners; ++i) {
      const int j = i + 1 == corners ? 0 : i + 1;
      const F rise = Lanes::sub(v[j], v[i]);
      const unsigned is_left = Lanes::less(zero, rise), flat = Lanes::less(Lanes::abs(rise), Lanes::set(kFlat));
      const F slope = Lanes::div(Lanes::sub(u[j], u[i]), rise);
      const F start = Lanes::add(u[i], Lanes::mul(Lanes::sub(y0, v[i]), slope));
      lefts[i] = is_left;
      Lanes::store(slope_[i], Lanes::select(flat, zero, slope));
      Lanes::store(start_[i], Lanes::select(flat, Lanes::select(is_left, Lanes::set(-kNoBound), Lanes::set(kNoBound)), start));
    }
    // Opposite edges are one left and one right, but for distortions of the nearest voxels.
    const int pairs = corners / 2;
    unsigned uneven = 0;
    for (int p = 0; p < pairs; ++p) {
      const unsigned a = lefts[p];
      uneven |= ~(a ^ lefts[p + pairs]);
      const F slope_a = Lanes::load(slope_[p]), slope_b = Lanes::load(slope_[p + pairs]), start_a = Lanes::load(start_[p]), start_b = Lanes::load(start_[p + pairs]);
      Lanes::store(left_slope_[p], Lanes::select(a, slope_a, slope_b));
      Lanes::store(right_slope_[p], Lanes::select(a, slope_b, slope_a));
      Lanes::store(left_start_[p], Lanes::select(a, start_a, start_b));
      Lanes::store(right_start_[p], Lanes::select(a, start_b, start_a));
    }
    for (; left_to_fill != 0; left_to_fill &= left_to_fill - 1) {
      const int i = __builtin_ctz(left_to_fill);
      std::uint32_t pixels;
      if (near_ones >> i & 1) {
        pixels = in.fill_near(in.context, x_[i], y_[i], z_[i]);
      } else if (uneven >> i & 1) {
        pixels = fill_uneven(i, corners, lefts);
      } else {
        pixels = pairs == 3 ? fill<3>(i) : fill<2>(i);
      }
      if (pixels != 0 && (out_of_range >> i & 1) == 0) account(i, pixels);
    }
  }

  template <int pairs>
  std::uint32_t fill(int i) {
    const int y0 = y0_[i], y1 = y1_[i];
    Sum fresh = Lanes::no_sum();
    for (int y = y0; y < y1; y += 16) {
      const F k = Lanes::add(Lanes::ramp(), Lanes::set(static_cast<float>(y - y0)));
      F l = Lanes::add(Lanes::set(left_start_[0][i]), Lanes::mul(Lanes::set(left_slope_[0][i]), k));
      F r = Lanes::add(Lanes::set(right_start_[0][i]), Lanes::mul(Lanes::set(right_slope_[0][i]), k));
      for (int p = 1; p < pairs; ++p) {
        l = Lanes::max(l, Lanes::add(Lanes::set(left_start_[p][i]), Lanes::mul(Lanes::set(left_slope_[p][i]), k)));
        r = Lanes::min(r, Lanes::add(Lanes::set(right_start_[p][i]), Lanes::mul(Lanes::set(right_slope_[p][i]), k)));
      }
      fill_rows(i, y, y1 - y, l, r, fresh);
    }
    return Lanes::total(fresh);
  }

  std::uint32_t fill_uneven(int i, int corners, const unsigned* lefts) {
    const int y0 = y0_[i], y1 = y1_[i];
    Sum fresh = Lanes::no_sum();
    for (int y = y0; y < y1; y += 16) {
      const F k = Lanes::add(Lanes::ramp(), Lanes::set(static_cast<float>(y - y0)));
      F l = Lanes::set(-kNoBound), r = Lanes::set(kNoBound);
      for (int e = 0; e < corners; ++e) {
        const F x = Lanes::add(Lanes::set(start_[e][i]), Lanes::mul(Lanes::set(slope_[e][i]), k));
        if (lefts[e] >> i & 1) {
          l = Lanes::max(l, x);
        } else {
          r = Lanes::min(r, x);
        }
      }
      fill_rows(i, y, y1 - y, l, r, fresh);
    }
    return Lanes::total(fresh);
  }

  // Rows y .. y + min(16, rows): pixels ceil(l) .. ceil(r) - 1 within the voxel's columns.
  void fill_rows(int i, int y, int rows, F l, F r, Sum& fresh) {
    const F low = Lanes::set(static_cast<float>(x0_[i])), high = Lanes::set(static_cast<float>(x1_[i]));
    const I left = Lanes::truncate(Lanes::ceil(Lanes::min(Lanes::max(l, low), high)));
    const I right = Lanes::truncate(Lanes::ceil(Lanes::min(Lanes::max(r, low), high)));
    for (int s = x0_[i] >> 5; s <= (x1_[i] - 1) >> 5; ++s) {
      fresh = Lanes::cover(in.coverage + static_cast<long>(s) * in.rows + y, left, right, s * 32, rows, fresh);
    }
  }

  void account(int i, std::uint32_t pixels) {
    const int x = x_[i] & 7, bit = (y_[i] & 7) * 8 + (z_[i] & 7);
    const VoxelPixels seen{(static_cast<std::uint32_t>(x_[i]) * static_cast<std::uint32_t>(in.size[1]) + static_cast<std::uint32_t>(y_[i])) * static_cast<std::uint32_t>(in.size[2]) +
                               static_cast<std::uint32_t>(z_[i]),
                           pixels};
    if (brick_->unknown[x] >> bit & 1) {
      out.unknown_pixels += pixels;
      if (pixels > in.more_than_pixels) out.unknown[out.unknown_count++] = seen;
    } else if (brick_->environment[x] >> bit & 1) {
      out.environment_pixels += pixels;
    } else {
      out.known_pixels += pixels;
    }
    if ((brick_->watched[x] >> bit & 1) && pixels > in.more_than_pixels) out.watched[out.watched_count++] = seen;
  }

  const VisibilityKernelInput& in;
  VisibilityKernelOutput& out;
  const VisibilityBrick* brick_ = nullptr;
  int queued_ = 0, case_ = -1;
  alignas(64) std::int32_t x_[16] = {}, y_[16] = {}, z_[16] = {};
  alignas(64) std::int32_t x0_[16], x1_[16], y0_[16], y1_[16];
  alignas(64) float slope_[6][16], start_[6][16];
  alignas(64) float left_slope_[3][16], right_slope_[3][16], left_start_[3][16], right_start_[3][16];
};

}  // namespace
}  // namespace periplus::voxel
