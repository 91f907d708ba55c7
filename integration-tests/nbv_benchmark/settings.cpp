#include "integration-tests/nbv_benchmark/settings.h"

#include <algorithm>

#include "common/core/error.h"

namespace periplus::nbv_benchmark {
namespace {

void read_resolution(const config::Node& n, BenchmarkOptions::Resolution& r) {
  n.read("known_points", r.known_points, {1, 10000});
  n.read("seen_points", r.seen_points, {1, 10000});
  n.read("more_than_pixels", r.more_than_pixels, {0, 10000});
}

}  // namespace

PoseSet pose_set_of(const std::string& word) {
  for (const PoseSet s : {PoseSet::dome, PoseSet::free, PoseSet::reachable})
    if (word == to_string(s)) return s;
  throw_error(ErrorCode::bad_input, "there is no pose set '" + word + "'; there are dome, free and reachable");
}

SensorKind sensor_of(const std::string& word) {
  for (const SensorKind s : {SensorKind::ideal, SensorKind::stereo})
    if (word == to_string(s)) return s;
  throw_error(ErrorCode::bad_input, "there is no sensor '" + word + "'; there are ideal and stereo");
}

Camera camera_of(const std::string& word) {
  for (const Camera c : {Camera::single, Camera::pair})
    if (word == to_string(c)) return c;
  throw_error(ErrorCode::bad_input, "there is no camera '" + word + "'; there are single and pair");
}

BenchmarkOptions read_options(const config::Node& root) {
  BenchmarkOptions o;
  root.read("views", o.views, {1, 1000});
  root.read("candidates", o.candidates, {1, 100000});
  root.read("seed", o.seed);
  root.read("gain_pixel_step", o.gain.pixel_step, {1, 100});
  root.read("distance_m", o.distance, {1e-4, 1});
  const config::Node object = root.child("object");
  object.read("longest_side_m", o.subject.longest_side, {0.01, 2});
  object.read("box_margin", o.subject.margin, {1, 4});
  object.read("voxels", o.subject.voxels, {8, 250});
  object.read("samples", o.subject.samples, {1, 10'000'000});
  // For whoever lays them over the planner's own parameters.
  root.child("planner").keys();
  for (const std::string& variant : root.child("variants").keys()) root.child("variants").child(variant).keys();
  const config::Node resolution = root.child("resolution");
  read_resolution(resolution.child("single"), o.single);
  read_resolution(resolution.child("pair"), o.pair);
  for (const config::Node& n : root.children("settings")) {
    Setting s;
    std::string poses, sensor = "ideal", camera = "single";
    n.read_choice("poses", poses, {"dome", "free", "reachable"});
    n.read_choice("sensor", sensor, {"ideal", "stereo"});
    n.read_choice("camera", camera, {"single", "pair"});
    s.set = pose_set_of(poses);
    s.sensor = sensor_of(sensor);
    s.camera = camera_of(camera);
    require(s.sensor == SensorKind::ideal || s.camera == Camera::pair, ErrorCode::bad_input, n.where() + ": stereo needs camera: pair");
    n.read("planners", s.planners);
    if (s.planners == std::vector<std::string>{"all"}) {
      s.planners = planner_names();
      if (s.set == PoseSet::dome) std::erase_if(s.planners, [](const std::string& p) { return !takes_lists(p); });
    }
    require(!s.planners.empty(), ErrorCode::bad_input, n.where() + ".planners: name at least one, or [all]");
    for (const std::string& p : s.planners) make_planner(p, {});
    o.settings.push_back(std::move(s));
  }
  root.finish();
  return o;
}

}  // namespace periplus::nbv_benchmark
