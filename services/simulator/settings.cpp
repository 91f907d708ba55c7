#include "services/simulator/settings.h"

namespace periplus::simulator {

SimulatorSettings read_settings(const config::Node& root) {
  SimulatorSettings s;
  root.read("seed", s.seed);

  const config::Node rendering = root.child("rendering");
  rendering.read_choice("backend", s.backend, {"auto", "egl", "osmesa"});
  rendering.read("threads", s.render_threads, {.minimum = 1, .maximum = 64});
  rendering.read("samples", s.samples, {.minimum = 0, .maximum = 16});

  const config::Node cameras = root.child("cameras");
  double noise = 2;
  cameras.read("noise_grey", noise, {.minimum = 0, .maximum = 100});
  s.left.noise = s.right.noise = s.wide.noise = noise;
  s.right.gain = 1.03;
  s.right.offset = 2;
  cameras.read("right_gain", s.right.gain, {.minimum = 0.1, .maximum = 10});
  cameras.read("right_offset_grey", s.right.offset, {.minimum = -255, .maximum = 255});
  cameras.read("views_kept", s.views_kept, {.minimum = 1, .maximum = 1000});

  root.child("robot").read("joint_limit_slack_rad", s.joint_limit_slack, {.minimum = 0, .maximum = 10});

  const config::Node faults = root.child("faults");
  faults.read("blank_right_eye", s.right.blank);
  faults.read("silent_cameras", s.silent_cameras);
  faults.read("fall_at_tick", s.fall_at_tick);
  root.finish();
  return s;
}

void apply(const scene::CameraImperfections& cameras, SimulatorSettings& s) {
  if (cameras.noise) s.left.noise = s.right.noise = s.wide.noise = *cameras.noise;
  if (cameras.right_gain) s.right.gain = *cameras.right_gain;
  if (cameras.right_offset) s.right.offset = *cameras.right_offset;
}

}  // namespace periplus::simulator
