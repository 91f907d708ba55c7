#include "services/nbv_planner/lookahead.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/core/error.h"

namespace periplus::nbv {
namespace {

// Sets over the voxels that any candidate shows, as bits.
class Cover {
 public:
  Cover(const std::vector<const ViewPromise*>& views, const std::vector<float>& weights) {
    std::vector<std::uint32_t> all;
    for (const ViewPromise* v : views) all.insert(all.end(), v->voxels.begin(), v->voxels.end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    words_ = (all.size() + 63) / 64;
    if (!weights.empty()) {
      weights_.resize(words_ * 64, 0);
      for (std::size_t i = 0; i < all.size(); ++i) weights_[i] = weights[all[i]];
    }
    for (const ViewPromise* v : views) {
      std::vector<std::uint64_t> bits(words_, 0);
      for (const std::uint32_t voxel : v->voxels) {
        const auto i = static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), voxel) - all.begin());
        bits[i / 64] |= 1ull << (i % 64);
      }
      sets_.push_back(std::move(bits));
    }
  }

  const std::vector<std::uint64_t>& of(int view) const { return sets_[static_cast<std::size_t>(view)]; }
  std::vector<std::uint64_t> with(const std::vector<std::uint64_t>& seen, int view) const {
    std::vector<std::uint64_t> both = seen;
    for (std::size_t w = 0; w < words_; ++w) both[w] |= of(view)[w];
    return both;
  }
  // What `view` adds to `seen`.
  double beyond(const std::vector<std::uint64_t>& seen, int view) const {
    const auto& set = of(view);
    if (weights_.empty()) {
      std::int64_t n = 0;
      for (std::size_t w = 0; w < words_; ++w) n += std::popcount(set[w] & ~seen[w]);
      return static_cast<double>(n);
    }
    double sum = 0;
    for (std::size_t w = 0; w < words_; ++w) {
      for (std::uint64_t rest = set[w] & ~seen[w]; rest != 0; rest &= rest - 1) {
        sum += weights_[w * 64 + static_cast<std::size_t>(std::countr_zero(rest))];
      }
    }
    return sum;
  }

 private:
  std::size_t words_ = 0;
  std::vector<float> weights_;
  std::vector<std::vector<std::uint64_t>> sets_;
};

}  // namespace

void LookaheadSettings::check() const {
  require(depth >= 1 && depth <= 3, ErrorCode::bad_input, "looking ahead needs a depth of 1 to 3 views");
  require(discount >= 0 && discount <= 1, ErrorCode::bad_input, "the discount of later views must lie in 0..1");
  require(within >= 0 && within <= 1, ErrorCode::bad_input, "the share within which views may come next must lie in 0..1");
  require(candidates >= 2 && candidates <= 64, ErrorCode::bad_input, "looking ahead needs 2 to 64 candidates");
}

LookaheadChoice look_ahead(const std::vector<ViewPromise>& candidates, const std::vector<float>& weights,
                           const LookaheadSettings& settings) {
  settings.check();
  require(!candidates.empty(), ErrorCode::bad_input, "looking ahead needs at least one candidate");
  std::vector<int> order(candidates.size());
  std::iota(order.begin(), order.end(), 0);
  const auto value = [&](int i) { return candidates[static_cast<std::size_t>(i)].value; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return value(a) > value(b); });
  if (order.size() > static_cast<std::size_t>(settings.candidates)) order.resize(static_cast<std::size_t>(settings.candidates));

  LookaheadChoice best{order[0], {}, value(order[0])};
  if (settings.depth == 1) return best;
  std::vector<const ViewPromise*> views;
  for (const int i : order) views.push_back(&candidates[static_cast<std::size_t>(i)]);
  const Cover cover(views, weights);
  const int n = static_cast<int>(order.size());
  const std::vector<std::uint64_t> nothing(cover.of(0).size(), 0);
  std::vector<double> alone(order.size());
  for (int i = 0; i < n; ++i) alone[static_cast<std::size_t>(i)] = cover.beyond(nothing, i);
  const double greatest = *std::max_element(alone.begin(), alone.end());
  const double least = value(order[0]) - settings.within * std::abs(value(order[0]));
  const double once = settings.discount, twice = settings.depth == 3 ? once * once : 0;

  best.total = -std::numeric_limits<double>::infinity();
  const auto offer = [&](double total, int first, std::vector<int> then) {
    if (!(total > best.total)) return;
    best.total = total;
    best.first = order[static_cast<std::size_t>(first)];
    best.then.clear();
    for (const int k : then) best.then.push_back(order[static_cast<std::size_t>(k)]);
  };
  for (int a = 0; a < n; ++a) {
    const double own = value(order[static_cast<std::size_t>(a)]);
    if (a > 0 && own < least) break;
    if (a > 0 && own + (once + twice) * greatest <= best.total) continue;  // cannot be reached any more
    offer(own, a, {});
    for (int b = 0; b < n; ++b) {
      if (b == a || own + once * alone[static_cast<std::size_t>(b)] + twice * greatest <= best.total) continue;
      const double second = own + once * cover.beyond(cover.of(a), b);
      offer(second, a, {b});
      if (settings.depth < 3 || second + twice * greatest <= best.total) continue;
      const std::vector<std::uint64_t> seen = cover.with(cover.of(a), b);
      for (int c = 0; c < n; ++c) {
        if (c == a || c == b || second + twice * alone[static_cast<std::size_t>(c)] <= best.total) continue;
        offer(second + twice * cover.beyond(seen, c), a, {b, c});
      }
    }
  }
  return best;
}

}  // namespace periplus::nbv
