#include "integration-tests/harness/analytic_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/core/error.h"
#include "common/core/random.h"

namespace periplus::harness {

namespace {

using Eigen::Vector3d;
constexpr double kNever = std::numeric_limits<double>::infinity();

double lattice(std::int64_t x, std::int64_t y, std::int64_t z, int seed) {
  const std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL ^
                          static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fULL ^
                          static_cast<std::uint64_t>(z) * 0x165667b19e3779f9ULL ^ static_cast<std::uint64_t>(seed) << 32;
  return Random(h).uniform();
}

// Trilinear value noise, 0..1.
double value_noise(const Vector3d& p, int seed) {
  const Vector3d f = p.array().floor();
  const Vector3d w = p - f;
  double sum = 0;
  for (int i = 0; i < 8; ++i) {
    const int a = i & 1, b = (i >> 1) & 1, c = i >> 2;
    sum += (a ? w.x() : 1 - w.x()) * (b ? w.y() : 1 - w.y()) * (c ? w.z() : 1 - w.z()) *
           lattice(static_cast<std::int64_t>(f.x()) + a, static_cast<std::int64_t>(f.y()) + b,
                   static_cast<std::int64_t>(f.z()) + c, seed);
  }
  return sum;
}

// Octaves from 128 mm down to what a pixel of `footprint` [m] resolves.
double texture(const Vector3d& p, double footprint, int seed) {
  double sum = 0, weight = 1, total = 0;
  for (double wave = 0.128; wave > 0.0035; wave /= 2, weight *= 0.8) {
    if (wave < 2.5 * footprint) break;
    sum += weight * value_noise(p / wave, seed);
    total += weight;
  }
  return total > 0 ? std::clamp(0.5 + 2.2 * (sum / total - 0.5), 0.0, 1.0) : 0.5;
}

// First and last t of the ray within |p_k| <= half_k for the axes of `axes`; false if none.
bool slabs(const Vector3d& o, const Vector3d& d, const Vector3d& half, int first_axis, int axes, double& t0, double& t1,
           int& axis0, int& axis1) {
  t0 = -kNever;
  t1 = kNever;
  for (int k = first_axis; k < first_axis + axes; ++k) {
    if (d[k] == 0) {
      if (std::abs(o[k]) > half[k]) return false;
      continue;
    }
    double a = (-half[k] - o[k]) / d[k], b = (half[k] - o[k]) / d[k];
    if (a > b) std::swap(a, b);
    if (a > t0) t0 = a, axis0 = k;
    if (b < t1) t1 = b, axis1 = k;
  }
  return t0 <= t1;
}

// Nearest t > 0 of the ray in the solid's own frame, from outside; normal in that frame.
double hit_solid(const scene::Solid& solid, const Vector3d& o, const Vector3d& d, Vector3d& normal) {
  if (solid.shape == scene::Shape::sphere) {
    const double r = solid.size.x() / 2, a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - r * r;
    const double disc = b * b - a * c;
    if (disc < 0) return kNever;
    const double t = (-b - std::sqrt(disc)) / a;
    normal = (o + t * d) / r;
    return t > 0 ? t : kNever;
  }
  double t0, t1;
  int axis0 = -1, axis1 = -1;
  if (solid.shape == scene::Shape::box) {
    if (!slabs(o, d, solid.size / 2, 0, 3, t0, t1, axis0, axis1) || t0 <= 0) return kNever;
    normal = Vector3d::Zero();
    normal[axis0] = d[axis0] > 0 ? -1 : 1;
    return t0;
  }
  const double r = solid.size.x() / 2;
  const double a = d.head<2>().squaredNorm(), b = o.head<2>().dot(d.head<2>()), c = o.head<2>().squaredNorm() - r * r;
  if (!slabs(o, d, solid.size / 2, 2, 1, t0, t1, axis0, axis1)) return kNever;
  bool side = false;
  if (a > 0) {
    const double disc = b * b - a * c;
    if (disc < 0) return kNever;
    const double s0 = (-b - std::sqrt(disc)) / a, s1 = (-b + std::sqrt(disc)) / a;
    if (s0 > t0) t0 = s0, side = true;
    t1 = std::min(t1, s1);
  } else if (c > 0) {
    return kNever;
  }
  if (t0 > t1 || t0 <= 0) return kNever;
  const Vector3d p = o + t0 * d;
  normal = side ? Vector3d(p.x() / r, p.y() / r, 0) : Vector3d(0, 0, d.z() > 0 ? -1 : 1);
  return t0;
}

double solid_distance(const scene::Solid& solid, const Vector3d& p) {
  if (solid.shape == scene::Shape::sphere) return p.norm() - solid.size.x() / 2;
  Vector3d q = p.cwiseAbs() - solid.size / 2;
  if (solid.shape == scene::Shape::cylinder) q = {p.head<2>().norm() - solid.size.x() / 2, q.z(), -1e9};
  return q.cwiseMax(0.0).norm() + std::min(0.0, q.maxCoeff());
}

}  // namespace

AnalyticScene::AnalyticScene(scene::Scene scene, std::vector<scene::Solid> object)
    : scene_(std::move(scene)), solids_(scene_.solids) {
  solids_.insert(solids_.end(), object.begin(), object.end());
  for (const scene::Solid& solid : solids_) require(solid.shape != scene::Shape::mesh, ErrorCode::bad_input, "an analytic scene has no meshes");
}

AnalyticScene::Hit AnalyticScene::cast(const Vector3d& origin, const Vector3d& direction) const {
  Hit hit;
  // The room from inside.
  const Vector3d half = scene_.room.size / 2, middle(0, 0, half.z());
  double t0, t1;
  int axis0 = -1, axis1 = 2;
  slabs(origin - middle, direction, half, 0, 3, t0, t1, axis0, axis1);
  hit.t = std::max(t1, 1e-6);
  hit.normal_W = Vector3d::Zero();
  hit.normal_W[axis1] = direction[axis1] > 0 ? -1 : 1;
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    const Pose X_SW = solids_[i].X_WS.inverse();
    Vector3d normal;
    const double t = hit_solid(solids_[i], X_SW * origin, X_SW.linear() * direction, normal);
    if (t < hit.t) {
      hit.t = t;
      hit.normal_W = solids_[i].X_WS.linear() * normal;
      hit.solid = static_cast<int>(i);
    }
  }
  hit.p_W = origin + hit.t * direction;
  return hit;
}

double AnalyticScene::object_distance(const Vector3d& p_W) const {
  double least = kNever;
  for (std::size_t i = scene_.solids.size(); i < solids_.size(); ++i)
    least = std::min(least, solid_distance(solids_[i], solids_[i].X_WS.inverse() * p_W));
  return least;
}

AnalyticScene::Look AnalyticScene::look(const Pinhole& camera, const Pose& X_WC) const {
  Look out{ImageU8(camera.width, camera.height, 3), ImageF(camera.width, camera.height), ImageU8(camera.width, camera.height)};
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Hit hit = cast(X_WC.translation(), X_WC.linear() * camera.back_project(x, y, 1));
      out.depth.at(x, y) = static_cast<float>(hit.t);
      const bool object = is_object(hit);
      out.object.at(x, y) = object ? 255 : 0;
      const double grey = object && plain_object ? 0.5 : texture(hit.p_W, hit.t / camera.fx, hit.solid + 2);
      // A tint per solid keeps the picture readable; light depends on the normal alone, as on a Lambertian surface.
      const double light = 0.75 + 0.25 * hit.normal_W.z();
      const Vector3d tint = object ? Vector3d(1, 0.9, 0.7) : hit.solid >= 0 ? Vector3d(0.8, 0.9, 1) : Vector3d(0.9, 1, 0.9);
      for (int c = 0; c < 3; ++c)
        out.image.at(x, y, c) = static_cast<std::uint8_t>(std::lround(std::clamp(20 + 215 * grey * light * tint[c], 0.0, 255.0)));
    }
  return out;
}

ImageU8 with_sensor_noise(const ImageU8& image, double sigma, double gain, double offset, std::uint64_t seed) {
  ImageU8 out = image;
  Random random(seed);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double noise = sigma > 0 ? sigma * random.normal() : 0;
      for (int c = 0; c < image.channels; ++c)
        out.at(x, y, c) =
            static_cast<std::uint8_t>(std::lround(std::clamp(image.at(x, y, c) * gain + offset + noise, 0.0, 255.0)));
    }
  return out;
}

ImageU8 to_grey(const ImageU8& rgb) {
  ImageU8 out(rgb.width, rgb.height);
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x)
      out.at(x, y) = static_cast<std::uint8_t>(
          std::lround(0.299 * rgb.at(x, y, 0) + 0.587 * rgb.at(x, y, 1) + 0.114 * rgb.at(x, y, 2)));
  return out;
}

}  // namespace periplus::harness
