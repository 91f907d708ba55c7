#include "common/object_model/stored_depth.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace periplus::object_model {

namespace {

constexpr double kUnit = 1e-4;  // [m]
constexpr double kMostSigmaPerZ2 = 1;  // [1/m]

template <class Round>
Image<std::uint16_t> to_units(const ImageF& metres, const Round& round) {
  Image<std::uint16_t> out(metres.width, metres.height);
  for (std::size_t i = 0; i < metres.data.size(); ++i) out.data[i] = static_cast<std::uint16_t>(std::min(65535.0, round(metres.data[i] / kUnit)));
  return out;
}

ImageF to_metres(const Image<std::uint16_t>& units, const Image<std::uint16_t>& size) {
  ImageF out(size.width, size.height);
  for (std::size_t i = 0; i < units.data.size(); ++i) out.data[i] = static_cast<float>(units.data[i] * kUnit);
  return out;
}

// Of what a map of nothing but stereo's depths has everywhere; a few pixels that say otherwise do not speak for all.
double median_sigma_per_z2(const DepthMap& map) {
  std::vector<double> each;
  each.reserve(map.depth.data.size());
  for (std::size_t i = 0; i < map.depth.data.size(); ++i) {
    const double z = map.depth.data[i], sigma = map.depth_sigma.data[i];
    if (z > 0) each.push_back(sigma > 0 ? std::min(sigma / (z * z), kMostSigmaPerZ2) : 0.0);
  }
  if (each.empty()) return 0;
  const auto middle = each.begin() + std::ssize(each) / 2;
  std::nth_element(each.begin(), middle, each.end());
  return *middle;
}

}  // namespace

StoredDepth store_depth(const DepthMap& map, const Pose& X_WC) {
  StoredDepth out{map.camera, X_WC.inverse() * map.X_WC, to_units(map.depth, [](double v) { return std::round(v); }),
                  to_units(map.depth_minimum, [](double v) { return std::floor(v); }), 0};
  for (std::size_t i = 0; i < out.depth.data.size(); ++i) out.minimum.data[i] = std::min(out.minimum.data[i], out.depth.data[i]);
  if (map.depth_sigma.data.size() == map.depth.data.size()) out.sigma_per_z2 = median_sigma_per_z2(map);
  return out;
}

DepthMap restore_depth(const StoredDepth& stored, const Pose& X_WC) {
  DepthMap map;
  map.camera = stored.camera;
  map.X_WC = X_WC * stored.X_CM;
  map.depth = to_metres(stored.depth, stored.depth);
  map.depth_minimum = to_metres(stored.minimum, stored.depth);
  if (stored.sigma_per_z2 > 0) {
    map.depth_sigma = ImageF(map.depth.width, map.depth.height);
    const auto sigma = static_cast<float>(stored.sigma_per_z2);
    for (std::size_t i = 0; i < map.depth.data.size(); ++i) map.depth_sigma.data[i] = sigma * map.depth.data[i] * map.depth.data[i];
  }
  return map;
}

}  // namespace periplus::object_model
