#include "common/object_model/feature_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/core/error.h"
#include "common/object_model/descriptor_rows.h"

namespace periplus::object_model {

namespace {

// Descriptors of one kind and its length.
struct Rows {
  std::vector<int> index;  // of the feature
  DescriptorRows descriptors;
};

Rows rows_of(std::span<const Feature> features, DescriptorKind kind) {
  Rows rows{{}, DescriptorRows(kind)};
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Feature& f = features[i];
    if (f.kind != kind || f.descriptor.size() != descriptor_octets(kind)) continue;
    rows.index.push_back(static_cast<int>(i));
    rows.descriptors.add(f.descriptor);
  }
  return rows;
}

struct Nearest {
  std::uint32_t best = std::numeric_limits<std::uint32_t>::max(), second = std::numeric_limits<std::uint32_t>::max();
  std::size_t at = 0;
  void see(std::uint32_t distance, std::size_t i) {
    if (distance < best) {
      second = best;
      best = distance;
      at = i;
    } else {
      second = std::min(second, distance);
    }
  }
};

void match_kind(std::span<const Feature> a, std::span<const Feature> b, DescriptorKind kind, const MatchingSettings& s, std::vector<FeatureMatch>& out) {
  const Rows rows = rows_of(a, kind), columns = rows_of(b, kind);
  std::vector<Nearest> of_row(rows.index.size()), of_column(columns.index.size());
  std::vector<std::uint32_t> apart;
  for (std::size_t i = 0; i < of_row.size(); ++i) {
    rows.descriptors.compare(i, columns.descriptors, apart);
    for (std::size_t j = 0; j < of_column.size(); ++j) {
      of_row[i].see(apart[j], j);
      of_column[j].see(apart[j], i);
    }
  }
  const double most = is_binary(kind) ? s.most_bits : s.most_distance;
  const auto clear = [&](const Nearest& x) {
    const double best = descriptor_distance(kind, x.best);
    return best <= most && (x.second == std::numeric_limits<std::uint32_t>::max() || best < s.ratio * descriptor_distance(kind, x.second));
  };
  for (std::size_t i = 0; i < of_row.size(); ++i) {
    if (of_column.empty() || !clear(of_row[i])) continue;
    const std::size_t j = of_row[i].at;
    if (of_column[j].at == i && clear(of_column[j])) out.push_back({rows.index[i], columns.index[j], descriptor_distance(kind, of_row[i].best)});
  }
}

// Drops matches whose distances in space to the others differ between the views.
void keep_coherent(std::span<const Feature> a, std::span<const Feature> b, const MatchingSettings& s, std::vector<FeatureMatch>& matches) {
  const std::size_t n = matches.size();
  const auto agree = [&](std::size_t i, std::size_t k) {
    const double in_a = (a[static_cast<std::size_t>(matches[i].a)].p_W - a[static_cast<std::size_t>(matches[k].a)].p_W).norm();
    const double in_b = (b[static_cast<std::size_t>(matches[i].b)].p_W - b[static_cast<std::size_t>(matches[k].b)].p_W).norm();
    return std::abs(in_a - in_b) <= s.distance_m + s.distance_share * std::max(in_a, in_b);
  };
  std::vector<std::uint8_t> agreeing(n * n);
  std::vector<int> count(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (agree(i, k)) {
        agreeing[i * n + k] = agreeing[k * n + i] = 1;
        ++count[i];
        ++count[k];
      }
  std::vector<bool> kept(n, true);
  for (std::size_t left = n; left > 0;) {
    // Equals go together, so that neither the order of features nor of views decides.
    int fewest = std::numeric_limits<int>::max();
    double furthest = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (kept[i] && (count[i] < fewest || (count[i] == fewest && matches[i].distance > furthest))) {
        fewest = count[i];
        furthest = matches[i].distance;
      }
    if (fewest >= s.least_coherent && fewest >= s.coherent_share * static_cast<double>(left - 1)) break;
    std::vector<std::size_t> dropped;
    for (std::size_t i = 0; i < n; ++i)
      if (kept[i] && count[i] == fewest && matches[i].distance == furthest) dropped.push_back(i);
    for (const std::size_t i : dropped) {
      kept[i] = false;
      --left;
      for (std::size_t k = 0; k < n; ++k) count[k] -= agreeing[i * n + k];
    }
  }
  std::vector<FeatureMatch> out;
  for (std::size_t i = 0; i < n; ++i)
    if (kept[i]) out.push_back(matches[i]);
  matches = std::move(out);
}

}  // namespace

void MatchingSettings::check() const {
  require(most_distance > 0 && most_distance <= 2 && most_bits > 0 && most_bits <= 1, ErrorCode::bad_input,
          "feature matching: most_distance must lie in (0, 2], most_bits in (0, 1]");
  require(ratio > 0 && ratio <= 1, ErrorCode::bad_input, "feature matching: ratio must lie in (0, 1]");
  require(distance_m >= 0 && distance_share >= 0 && std::isfinite(distance_m) && std::isfinite(distance_share), ErrorCode::bad_input,
          "feature matching: distance_m and distance_share must not be negative");
  require(coherent_share >= 0 && coherent_share <= 1 && least_coherent >= 0, ErrorCode::bad_input,
          "feature matching: coherent_share must lie in 0..1, least_coherent must not be negative");
  require(most >= 0, ErrorCode::bad_input, "feature matching: most must not be negative");
}

std::vector<FeatureMatch> match_views(std::span<const Feature> a, std::span<const Feature> b, const MatchingSettings& settings) {
  settings.check();
  std::vector<FeatureMatch> matches;
  for (const DescriptorKind kind : {DescriptorKind::root_sift, DescriptorKind::surf, DescriptorKind::akaze, DescriptorKind::orb})
    match_kind(a, b, kind, settings, matches);
  keep_coherent(a, b, settings, matches);
  std::sort(matches.begin(), matches.end(), [](const FeatureMatch& x, const FeatureMatch& y) {
    if (x.distance != y.distance) return x.distance < y.distance;
    return std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  if (settings.most > 0 && matches.size() > static_cast<std::size_t>(settings.most)) matches.resize(static_cast<std::size_t>(settings.most));
  return matches;
}

}  // namespace periplus::object_model
