// The algorithm of visibility_kernel.h over 16 lanes (`Lanes`), included by the unit of each instruction set alone.
//
// Bricks and voxels go by sixteen, in an order in which no later one hides an earlier one. A voxel's silhouette is bounded by
// six lines; with its centre's pixel as origin, the lines along voxel axis d are
//   (0, 0, w) x H_d  +-  (G_e + G_f),     G_d = H_e x H_f,  (d, e, f) cyclic,
// H_d half a voxel along d as it is projected: no corner is projected and nothing large cancels. Lanes are voxels while the
// rows of sixteen silhouettes are made (eight rows at a time, as words whose bit 0 is the silhouette's first column); then each
// goes into the coverage in turn. Silhouettes too large for that are filled one by one, lanes being rows.
// No operation is fused, reordered or approximated (-ffp-contract=off, divisions), so that every Lanes gives the same bits.
//
// Lanes: F sixteen floats, I sixteen 32-bit integers; masks are sixteen bits.
#pragma once

#include "common/voxel/visibility_kernel.h"

namespace periplus::voxel {
namespace {

constexpr float kFlat = 1e-10f;         // what makes a line that is level not quite so
constexpr float kBoundSlack = 1.0e-3f;  // [px] what rounding may take from a silhouette's bounds
constexpr int kMostStreams = 4;
constexpr int kBatch = 64;
constexpr int kMostSmallRows = 16, kMostSmallColumns = 32;

template <class Lanes>
class Kernel {
  using F = typename Lanes::F;
  using I = typename Lanes::I;

 public:
  Kernel(const VisibilityKernelInput& input, VisibilityKernelOutput& output) : in(input), out(output) {
    for (int a = 0; a < 3; ++a) {
      for (int d = 0; d < 3; ++d) half_[a][d] = 0.5f * in.m[a][d];
      middle_[a] = ((half_[a][0] + half_[a][1]) + half_[a][2]) + in.m[a][3];
    }
    depth_spread_ = (__builtin_fabsf(half_[2][0]) + __builtin_fabsf(half_[2][1])) + __builtin_fabsf(half_[2][2]);
  }

  void run() {
    out.unknown_count = out.watched_count = 0;
    out.unknown_pixels = out.known_pixels = out.environment_pixels = 0;
    for (int at = 0; at < in.turn_count; at += 16) {
      // The bricks lie scattered in memory: those after next and the voxels of the next are fetched meanwhile.
      for (int i = at + 32; i < at + 48 && i < in.turn_count; ++i) {
        const char* brick = reinterpret_cast<const char*>(in.bricks + in.turns[i].brick);
        __builtin_prefetch(brick);
        __builtin_prefetch(brick + 64);
      }
      for (int i = at + 16; i < at + 32 && i < in.turn_count; ++i) {
        const VisibilityBrick& brick = in.bricks[in.turns[i].brick];
        const int octant = octant_of(*part_of(brick, 0), *part_of(brick, 1), *part_of(brick, 2));
        const char* codes = reinterpret_cast<const char*>(in.codes + brick.first[octant]);
        __builtin_prefetch(codes);
        __builtin_prefetch(codes + 64);
        __builtin_prefetch(codes + 128);
      }
      visit_bricks(in.turns + at, in.turn_count - at < 16 ? in.turn_count - at : 16);
    }
    mix();
    flush();
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

  // First column or row whose pixel centre is not before x, from the image's side, within 0 .. size.
  static I first_pixel(F x, std::int32_t center, std::int32_t size) {
    const F low = Lanes::set(static_cast<float>(-center)), high = Lanes::set(static_cast<float>(size - center));
    return Lanes::add(Lanes::truncate(Lanes::ceil(Lanes::min(Lanes::max(x, low), high))), Lanes::set(center));
  }

  // Where sixteen boxes may be seen: pixels [x0, x1) x [y0, y1).
  struct Bounds {
    alignas(64) std::int32_t x0[16], x1[16], y0[16], y1[16];
    unsigned whole = 0;   // before the near plane: only of these the pixels are known
    unsigned hidden = 0;  // wholly nearer than the near plane, or beyond the depth range: it hides only what lies there too
  };

  // Of boxes with these middles and side lengths [voxels].
  void find_bounds(F X, F Y, F Z, const F* extent, Bounds& b) const {
    F c[3];
    for (int a = 0; a < 3; ++a) {
      c[a] = Lanes::add(Lanes::add(Lanes::add(Lanes::mul(Lanes::set(in.m[a][0]), X), Lanes::mul(Lanes::set(in.m[a][1]), Y)), Lanes::mul(Lanes::set(in.m[a][2]), Z)),
                        Lanes::set(in.m[a][3]));
    }
    const F zero = Lanes::set(0.0f), one = Lanes::set(1.0f), slack = Lanes::set(kBoundSlack);
    F spread[3] = {zero, zero, zero};
    const F inverse = Lanes::div(one, c[2]), u = Lanes::mul(c[0], inverse), v = Lanes::mul(c[1], inverse);
    for (int d = 0; d < 3; ++d) {
      const F w = Lanes::set(half_[2][d]);
      spread[0] = Lanes::add(spread[0], Lanes::mul(extent[d], Lanes::abs(Lanes::sub(Lanes::set(half_[0][d]), Lanes::mul(u, w)))));
      spread[1] = Lanes::add(spread[1], Lanes::mul(extent[d], Lanes::abs(Lanes::sub(Lanes::set(half_[1][d]), Lanes::mul(v, w)))));
      spread[2] = Lanes::add(spread[2], Lanes::mul(extent[d], Lanes::abs(w)));
    }
    const F nearest = Lanes::sub(c[2], spread[2]), near = Lanes::set(in.near);
    b.whole = Lanes::less(near, nearest);
    b.hidden = Lanes::less(Lanes::add(c[2], spread[2]), near) | Lanes::less(Lanes::set(in.depth_max), nearest);
    const F scale = Lanes::div(one, nearest);
    const F ru = Lanes::add(Lanes::mul(spread[0], scale), slack), rv = Lanes::add(Lanes::mul(spread[1], scale), slack);
    Lanes::store(b.x0, first_pixel(Lanes::sub(u, ru), in.center[0], in.width));
    Lanes::store(b.x1, first_pixel(Lanes::add(u, ru), in.center[0], in.width));
    Lanes::store(b.y0, first_pixel(Lanes::sub(v, rv), in.center[1], in.height));
    Lanes::store(b.y1, first_pixel(Lanes::add(v, rv), in.center[1], in.height));
  }

  // In sight and not yet covered.
  bool may_be_seen(const Bounds& b, int i) const {
    if (b.hidden >> i & 1) return false;
    if ((b.whole >> i & 1) == 0) return true;
    return b.x0[i] < b.x1[i] && b.y0[i] < b.y1[i] && !covered(b.x0[i], b.y0[i], b.x1[i] - 1, b.y1[i] - 1);
  }

  void visit_bricks(const BrickTurn* turns, int n) {
    alignas(64) float middle[3][16], extent[3][16];
    for (int i = 0; i < 16; ++i) {
      const VisibilityBrick& brick = in.bricks[turns[i < n ? i : 0].brick];
      for (int a = 0; a < 3; ++a) {
        middle[a][i] = brick.middle[a];
        extent[a][i] = brick.extent[a];
      }
    }
    Bounds b;
    const F e[3] = {Lanes::load(extent[0]), Lanes::load(extent[1]), Lanes::load(extent[2])};
    find_bounds(Lanes::load(middle[0]), Lanes::load(middle[1]), Lanes::load(middle[2]), e, b);
    for (int i = 0; i < n; ++i) {
      if (turns[i].level != level_ || streams_ == kMostStreams) {
        mix();
        level_ = turns[i].level;
      }
      if (may_be_seen(b, i)) visit(in.bricks[turns[i].brick]);
    }
  }

  void visit(const VisibilityBrick& brick) {
    const BrickPart* parts[3];
    int count[3];
    for (int a = 0; a < 3; ++a) {
      parts[a] = part_of(brick, a);
      count[a] = in.part_count[a][brick.at[a]];
    }
    const std::uint32_t base = static_cast<std::uint32_t>(brick.at[0]) << (kVoxelX + 3) | static_cast<std::uint32_t>(brick.at[1]) << (kVoxelY + 3) |
                               static_cast<std::uint32_t>(brick.at[2]) << (kVoxelZ + 3);
    if (count[0] * count[1] * count[2] == 1) {
      enter(parts[0]->side * 9 + parts[1]->side * 3 + parts[2]->side);
      const int octant = octant_of(*parts[0], *parts[1], *parts[2]);
      const std::uint32_t* codes = in.codes + brick.first[octant];
      const int n = static_cast<int>(brick.count[octant]);
      if (n == 0) return;
      std::uint32_t* stream = stream_[streams_];
      for (int k = 0; k < n; k += 16) Lanes::store_anywhere(stream + k, Lanes::add(Lanes::set(static_cast<std::int32_t>(base)), Lanes::load_anywhere(codes + k)));
      stream_count_[streams_++] = n;
      return;
    }
    // The camera is beside the brick along some axis: piece by piece.
    for (int i = 0; i < count[0]; ++i) {
      for (int j = 0; j < count[1]; ++j) {
        for (int k = 0; k < count[2]; ++k) {
          const BrickPart &px = parts[0][i], &py = parts[1][j], &pz = parts[2][k];
          const int octant = octant_of(px, py, pz);
          std::uint32_t* stream = stream_[0];
          int n = 0;
          const std::uint32_t* code = in.codes + brick.first[octant];
          for (const std::uint32_t* end = code + brick.count[octant]; code != end; ++code) {
            const int x = *code >> kVoxelX & 7, y = *code >> kVoxelY & 7, z = *code >> kVoxelZ & 7;
            stream[n] = base + *code;
            n += (x >= px.low) & (x <= px.high) & (y >= py.low) & (y <= py.high) & (z >= pz.low) & (z <= pz.high);
          }
          if (n == 0) continue;
          enter(px.side * 9 + py.side * 3 + pz.side);
          stream_count_[0] = n;
          streams_ = 1;
          mix();
        }
      }
    }
  }

  const BrickPart* part_of(const VisibilityBrick& brick, int axis) const { return in.parts[axis] + brick.at[axis] * 3; }
  static int octant_of(const BrickPart& x, const BrickPart& y, const BrickPart& z) { return (x.side >> 1) | (y.side >> 1) << 1 | (z.side >> 1) << 2; }

  // What follows is seen from another side.
  void enter(int code) {
    if (code == case_) return;
    mix();
    flush();
    case_ = code;
  }

  // Voxels of the bricks in hand, which do not hide each other, in turn: what is filled just after each other should lie apart, since a
  // word of the coverage that was written just before is slow to read.
  void mix() {
    int at[kMostStreams] = {};
    while (streams_ > 1) {
      int rounds = stream_count_[0] - at[0];
      for (int s = 1; s < streams_; ++s) rounds = stream_count_[s] - at[s] < rounds ? stream_count_[s] - at[s] : rounds;
      for (int s = 0; s < streams_; ++s) {
        std::uint32_t* to = queue_ + queued_ + s;
        const std::uint32_t* from = stream_[s] + at[s];
        for (int r = 0; r < rounds; ++r) to[r * streams_] = from[r];
        at[s] += rounds;
      }
      queued_ += rounds * streams_;
      int left = 0;
      for (int s = 0; s < streams_; ++s) {
        if (at[s] == stream_count_[s]) continue;
        if (left != s) {
          for (int k = at[s]; k < stream_count_[s]; ++k) stream_[left][k] = stream_[s][k];
          at[left] = at[s];
          stream_count_[left] = stream_count_[s];
        }
        ++left;
      }
      streams_ = left;
    }
    if (streams_ == 1) {
      for (int k = at[0]; k < stream_count_[0]; k += 16) Lanes::store_anywhere(queue_ + queued_ + k - at[0], Lanes::load_anywhere(stream_[0] + k));
      queued_ += stream_count_[0] - at[0];
    }
    streams_ = 0;
    if (queued_ >= kBatch) drain();
  }

  // All full batches of the queue.
  void drain() {
    int at = 0;
    for (; queued_ - at >= kBatch; at += kBatch) fill(queue_ + at, kBatch);
    for (int k = at; k < queued_; k += 16) Lanes::store_anywhere(queue_ + k - at, Lanes::load_anywhere(queue_ + k));
    queued_ -= at;
  }

  void flush() {
    if (queued_ != 0) fill(queue_, queued_);
    queued_ = 0;
  }

  // Voxels of one case, up to kBatch: step by step for all, so that the processor works on several groups of sixteen at a time.
  void fill(const std::uint32_t* codes, int n) {
    if (in.corner_count[case_] == 0) return;
    // Mirrored so that the camera is below along every axis.
    const int sides[3] = {case_ / 9, case_ / 3 % 3, case_ % 3};
    for (int d = 0; d < 3; ++d) {
      for (int a = 0; a < 3; ++a) mirrored_[a][d] = sides[d] == 2 ? -half_[a][d] : half_[a][d];
    }
    const bool octant = sides[0] != 1 && sides[1] != 1 && sides[2] != 1;
    const int groups = (n + 15) / 16;
    for (int g = 0; g < groups; ++g) project(group_[g], codes + 16 * g, n - 16 * g, octant);
    for (int g = 0; g < groups; ++g) {
      Group& group = group_[g];
      if (group.small == 0) continue;
      F left[3], left_slope[3], right[3], right_slope[3];
      for (int d = 0; d < 3; ++d) {
        left[d] = Lanes::load(group.left[d]);
        left_slope[d] = Lanes::load(group.left_slope[d]);
        right[d] = Lanes::load(group.right[d]);
        right_slope[d] = Lanes::load(group.right_slope[d]);
      }
      Lanes::make_rows(left, left_slope, right, right_slope, group.masks[0]);
      if (group.tall != 0) Lanes::make_rows(left, left_slope, right, right_slope, group.masks[1]);
    }
    for (int g = 0; g < groups; ++g) {
      Group& group = group_[g];
      if (group.small == 0xffffu) {
        if (group.tall == 0) {
          for (int i = 0; i < 16; ++i) group.pixels[i] = cover(group, i, 0);
        } else {
          for (int i = 0; i < 16; ++i) group.pixels[i] = cover(group, i, 0) + cover(group, i, 1);
        }
        continue;
      }
      Lanes::store(group.pixels, Lanes::set(0));
      for (unsigned rest = group.small | group.single; rest != 0; rest &= rest - 1) {
        const int i = __builtin_ctz(rest);
        if (group.single >> i & 1) {
          group.pixels[i] = fill_one(group, i);
        } else {
          group.pixels[i] = cover(group, i, 0);
          if (group.tall != 0) group.pixels[i] += cover(group, i, 1);
        }
      }
    }
    for (int g = 0; g < groups; ++g) account(group_[g]);
  }

  // Sixteen voxels' centres and half steps, relative to the centre's pixel.
  struct Projected {
    F w;                  // depth of the centre
    F hu[3], hv[3];       // half a voxel along each axis, times w
    F gu[3], gv[3], gw[3];
    F x0, y0;             // first column and row, from the centre's pixel
  };

  // Sixteen voxels on their way.
  struct Group {
    alignas(64) float left[3][16], left_slope[3][16], right[3][16], right_slope[3][16];  // where row k of the silhouette begins and ends
    alignas(64) std::uint32_t masks[2][16 * 8];
    alignas(64) std::int32_t word[16], column[16];      // of the coverage: the silhouette's first
    alignas(64) std::int32_t code[16], pixels[16];
    alignas(64) std::int32_t x0[16], x1[16], y0[16], y1[16];  // where there are single ones
    alignas(64) float start[6][16], slope[6][16];
    unsigned lefts[6];
    unsigned small, tall;    // filled eight rows at a time; more than eight rows are needed
    unsigned single, cut;    // one by one; by the near plane
    unsigned counts;         // in the depth range
  };

  void project(Group& g, const std::uint32_t* codes, int n, bool octant) const {
    const I code = Lanes::load_anywhere(codes), x = Lanes::template shift_right<kVoxelX>(code);
    const I y = Lanes::both(Lanes::template shift_right<kVoxelY>(code), Lanes::set(1023)), z = Lanes::both(Lanes::template shift_right<kVoxelZ>(code), Lanes::set(511));
    const F X = Lanes::convert(x), Y = Lanes::convert(y), Z = Lanes::convert(z);
    Lanes::store(g.code, code);
    F c[3];
    for (int a = 0; a < 3; ++a) {
      c[a] = Lanes::add(Lanes::add(Lanes::add(Lanes::mul(Lanes::set(in.m[a][0]), X), Lanes::mul(Lanes::set(in.m[a][1]), Y)), Lanes::mul(Lanes::set(in.m[a][2]), Z)),
                        Lanes::set(middle_[a]));
    }
    const unsigned live = n >= 16 ? 0xffffu : (1u << n) - 1;
    const F one = Lanes::set(1.0f), near = Lanes::set(in.near), slack = Lanes::set(kBoundSlack);
    const F nearest = Lanes::sub(c[2], Lanes::set(depth_spread_));
    const unsigned whole = Lanes::less(near, nearest) & live;
    g.cut = Lanes::less(near, Lanes::add(c[2], Lanes::set(depth_spread_))) & live & ~whole;
    g.counts = live & ~(Lanes::less(c[2], Lanes::set(in.depth_min)) | Lanes::less(Lanes::set(in.depth_max), c[2]));
    Projected p;
    p.w = c[2];
    const F inverse = Lanes::div(one, c[2]), u = Lanes::mul(c[0], inverse), v = Lanes::mul(c[1], inverse);
    for (int d = 0; d < 3; ++d) {
      p.hu[d] = Lanes::sub(Lanes::set(mirrored_[0][d]), Lanes::mul(u, Lanes::set(mirrored_[2][d])));
      p.hv[d] = Lanes::sub(Lanes::set(mirrored_[1][d]), Lanes::mul(v, Lanes::set(mirrored_[2][d])));
    }
    const F scale = Lanes::div(one, nearest);
    const F ru = Lanes::add(Lanes::mul(Lanes::add(Lanes::add(Lanes::abs(p.hu[0]), Lanes::abs(p.hu[1])), Lanes::abs(p.hu[2])), scale), slack);
    const F rv = Lanes::add(Lanes::mul(Lanes::add(Lanes::add(Lanes::abs(p.hv[0]), Lanes::abs(p.hv[1])), Lanes::abs(p.hv[2])), scale), slack);
    // What lies outside of the image has no rows, or finds them covered.
    const I x0 = first_pixel(Lanes::sub(u, ru), in.center[0], in.width), y0 = first_pixel(Lanes::sub(v, rv), in.center[1], in.height);
    p.x0 = Lanes::sub(Lanes::convert(Lanes::sub(x0, Lanes::set(in.center[0]))), u);
    p.y0 = Lanes::sub(Lanes::convert(Lanes::sub(y0, Lanes::set(in.center[1]))), v);
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      const F we = Lanes::set(mirrored_[2][e]), wf = Lanes::set(mirrored_[2][f]);
      p.gu[d] = Lanes::sub(Lanes::mul(p.hv[e], wf), Lanes::mul(we, p.hv[f]));
      p.gv[d] = Lanes::sub(Lanes::mul(we, p.hu[f]), Lanes::mul(p.hu[e], wf));
      p.gw[d] = Lanes::sub(Lanes::mul(p.hu[e], p.hv[f]), Lanes::mul(p.hv[e], p.hu[f]));
    }
    Lanes::store(g.word, Lanes::add(Lanes::mul(Lanes::template shift_right<5>(x0), Lanes::set(in.rows)), y0));
    Lanes::store(g.column, Lanes::both(x0, Lanes::set(31)));
    // A span of 2 r holds floor(2 r) + 1 pixels at most.
    const F two = Lanes::set(2.0f);
    unsigned small = Lanes::less(Lanes::mul(ru, two), Lanes::set(static_cast<float>(kMostSmallColumns))) & Lanes::less(Lanes::mul(rv, two), Lanes::set(static_cast<float>(kMostSmallRows))) & whole;
    small &= ~(octant ? lines_of_octant(p, g) : lines_of_case(p, g));
    g.small = small;
    g.tall = small & ~Lanes::less(Lanes::mul(rv, two), Lanes::set(8.0f));
    g.single = (whole & ~small) | g.cut;
    if (g.single != 0) {
      Lanes::store(g.x0, x0);
      Lanes::store(g.y0, y0);
      Lanes::store(g.x1, first_pixel(Lanes::add(u, ru), in.center[0], in.width));
      Lanes::store(g.y1, first_pixel(Lanes::add(v, rv), in.center[1], in.height));
      if (octant) lines_of_case(p, g);
    }
  }

  // Lines of a silhouette with three faces, two along each axis; says which do not bound once from the left and once from the right.
  static unsigned lines_of_octant(const Projected& p, Group& g) {
    const F zero = Lanes::set(0.0f), one = Lanes::set(1.0f), flat = Lanes::set(kFlat);
    unsigned uneven = 0;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      const F ga = Lanes::add(p.gu[e], p.gu[f]), gb = Lanes::add(p.gv[e], p.gv[f]), gc = Lanes::add(p.gw[e], p.gw[f]);
      const F na = Lanes::mul(p.w, p.hv[d]), nb = Lanes::mul(p.w, p.hu[d]);
      // a x + b y + c = 0
      const F a0 = Lanes::add(Lanes::sub(ga, na), flat), a1 = Lanes::sub(Lanes::sub(flat, ga), na);
      const F b0 = Lanes::add(nb, gb), b1 = Lanes::sub(nb, gb);
      const F ratio = Lanes::div(one, Lanes::mul(a0, a1));
      const F q0 = Lanes::mul(a1, ratio), q1 = Lanes::mul(a0, ratio);
      const F value0 = Lanes::add(Lanes::add(Lanes::mul(a0, p.x0), Lanes::mul(b0, p.y0)), gc);
      const F value1 = Lanes::sub(Lanes::add(Lanes::mul(a1, p.x0), Lanes::mul(b1, p.y0)), gc);
      const F start0 = Lanes::sub(zero, Lanes::mul(value0, q0)), start1 = Lanes::sub(zero, Lanes::mul(value1, q1));
      const F slope0 = Lanes::sub(zero, Lanes::mul(b0, q0)), slope1 = Lanes::sub(zero, Lanes::mul(b1, q1));
      // The centre, where the value is +-gc, is inside: a line bounds from the left if a has the value's sign.
      const unsigned positive = Lanes::less(zero, gc), left0 = ~(Lanes::less(zero, a0) ^ positive), left1 = Lanes::less(zero, a1) ^ positive;
      uneven |= ~(left0 ^ left1);
      Lanes::store(g.left[d], Lanes::select(left0, start0, start1));
      Lanes::store(g.left_slope[d], Lanes::select(left0, slope0, slope1));
      Lanes::store(g.right[d], Lanes::select(left0, start1, start0));
      Lanes::store(g.right_slope[d], Lanes::select(left0, slope1, slope0));
    }
    return uneven;
  }

  std::int32_t cover(const Group& g, int i, int half) {
    return Lanes::cover8(in.coverage + g.word[i] + 8 * half, in.rows, g.masks[half] + Lanes::slot(i) * 8, g.column[i]);
  }

  // Lines of any silhouette, one by one too: edge i from corner i to the next. Says which are uneven as above.
  unsigned lines_of_case(const Projected& p, Group& g) const {
    const int corners = in.corner_count[case_];
    const F zero = Lanes::set(0.0f), one = Lanes::set(1.0f), flat = Lanes::set(kFlat);
    const int mirrored = (case_ / 9 == 2 ? 1 : 0) | (case_ / 3 % 3 == 2 ? 2 : 0) | (case_ % 3 == 2 ? 4 : 0);
    for (int i = 0; i < corners; ++i) {
      const int from = in.corners[case_][i] ^ mirrored, to = in.corners[case_][i + 1 == corners ? 0 : i + 1] ^ mirrored;
      const int d = __builtin_ctz(static_cast<unsigned>(from ^ to)), e = (d + 1) % 3, f = (d + 2) % 3;
      const F se = Lanes::set(from >> e & 1 ? 1.0f : -1.0f), sf = Lanes::set(from >> f & 1 ? 1.0f : -1.0f);
      const F na = Lanes::mul(p.w, p.hv[d]), nb = Lanes::mul(p.w, p.hu[d]);
      const F a = Lanes::add(Lanes::sub(Lanes::sub(Lanes::mul(sf, p.gu[e]), Lanes::mul(se, p.gu[f])), na), flat);
      const F b = Lanes::add(Lanes::sub(Lanes::mul(sf, p.gv[e]), Lanes::mul(se, p.gv[f])), nb);
      const F value = Lanes::sub(Lanes::mul(sf, p.gw[e]), Lanes::mul(se, p.gw[f]));
      const F q = Lanes::div(one, a);
      const F start = Lanes::add(Lanes::add(Lanes::mul(a, p.x0), Lanes::mul(b, p.y0)), value);
      Lanes::store(g.start[i], Lanes::sub(zero, Lanes::mul(start, q)));
      Lanes::store(g.slope[i], Lanes::sub(zero, Lanes::mul(b, q)));
      g.lefts[i] = ~(Lanes::less(zero, a) ^ Lanes::less(zero, value));
    }
    // Opposite ones in pairs; of four corners one pair twice.
    unsigned uneven = 0;
    for (int d = 0; d < 3; ++d) {
      const int i = 2 * d < corners ? d : 0, j = i + corners / 2;
      uneven |= ~(g.lefts[i] ^ g.lefts[j]);
      const F start0 = Lanes::load(g.start[i]), start1 = Lanes::load(g.start[j]), slope0 = Lanes::load(g.slope[i]), slope1 = Lanes::load(g.slope[j]);
      Lanes::store(g.left[d], Lanes::select(g.lefts[i], start0, start1));
      Lanes::store(g.left_slope[d], Lanes::select(g.lefts[i], slope0, slope1));
      Lanes::store(g.right[d], Lanes::select(g.lefts[i], start1, start0));
      Lanes::store(g.right_slope[d], Lanes::select(g.lefts[i], slope1, slope0));
    }
    return uneven;
  }

  std::int32_t fill_one(const Group& g, int i) {
    if (g.cut >> i & 1) {
      const std::uint32_t code = static_cast<std::uint32_t>(g.code[i]);
      return static_cast<std::int32_t>(in.fill_near(in.context, static_cast<int>(code >> kVoxelX), code >> kVoxelY & 1023, code >> kVoxelZ & 511));
    }
    const int x0 = g.x0[i], x1 = g.x1[i], y0 = g.y0[i], y1 = g.y1[i], corners = in.corner_count[case_];
    const F none = Lanes::set(0.0f), all = Lanes::set(static_cast<float>(x1 - x0));
    std::int32_t pixels = 0;
    for (int y = y0; y < y1; y += 16) {
      const F k = Lanes::add(Lanes::ramp(), Lanes::set(static_cast<float>(y - y0)));
      F l = none, r = all;
      for (int e = 0; e < corners; ++e) {
        const F x = Lanes::add(Lanes::set(g.start[e][i]), Lanes::mul(Lanes::set(g.slope[e][i]), k));
        if (g.lefts[e] >> i & 1) {
          l = Lanes::max(l, x);
        } else {
          r = Lanes::min(r, x);
        }
      }
      const I left = Lanes::truncate(Lanes::ceil(Lanes::min(l, all))), right = Lanes::truncate(Lanes::ceil(Lanes::max(r, none)));
      for (int s = x0 >> 5; s <= (x1 - 1) >> 5; ++s) pixels += Lanes::cover16(in.coverage + static_cast<long>(s) * in.rows + y, left, right, s * 32 - x0, y1 - y);
    }
    return pixels;
  }

  void account(const Group& g) {
    const I pixels = Lanes::load(g.pixels), code = Lanes::load(g.code), none = Lanes::set(0);
    const unsigned counts = Lanes::less(none, pixels) & g.counts;
    if (counts == 0) return;
    const unsigned unknown = Lanes::less(none, Lanes::both(code, Lanes::set(std::int32_t{kVoxelUnknown}))) & counts;
    const unsigned environment = Lanes::less(none, Lanes::both(code, Lanes::set(std::int32_t{kVoxelEnvironment}))) & counts;
    const unsigned watched = Lanes::less(none, Lanes::both(code, Lanes::set(std::int32_t{kVoxelWatched}))) & counts;
    out.unknown_pixels += Lanes::sum(pixels, unknown);
    out.environment_pixels += Lanes::sum(pixels, environment);
    out.known_pixels += Lanes::sum(pixels, counts & ~(unknown | environment));
    const unsigned enough = Lanes::less(Lanes::set(static_cast<std::int32_t>(in.more_than_pixels)), pixels);
    if (((unknown | watched) & enough) == 0) return;
    const I x = Lanes::template shift_right<kVoxelX>(code), y = Lanes::both(Lanes::template shift_right<kVoxelY>(code), Lanes::set(1023)), z = Lanes::both(Lanes::template shift_right<kVoxelZ>(code), Lanes::set(511));
    const I index = Lanes::add(Lanes::mul(Lanes::add(Lanes::mul(x, Lanes::set(in.size[1])), y), Lanes::set(in.size[2])), z);
    out.unknown_count += Lanes::list(index, pixels, unknown & enough, out.unknown + out.unknown_count);
    if ((watched & enough) != 0) out.watched_count += Lanes::list(index, pixels, watched & enough, out.watched + out.watched_count);
  }

  const VisibilityKernelInput& in;
  VisibilityKernelOutput& out;
  float half_[3][3], middle_[3], depth_spread_ = 0;
  int queued_ = 0, case_ = -1, streams_ = 0, level_ = -1;
  int stream_count_[kMostStreams];
  std::uint32_t stream_[kMostStreams][512 + 16];
  float mirrored_[3][3];
  alignas(64) std::uint32_t queue_[kBatch + kMostStreams * 512 + 16] = {};
  Group group_[kBatch / 16];
};

}  // namespace
}  // namespace periplus::voxel
