#include "services/simulator/settings.h"

#include <gtest/gtest.h>

#include "common/core/error.h"

namespace periplus::simulator {
namespace {

TEST(SimulatorSettings, TheDefaultFileSaysTheDefaults) {
  const SimulatorSettings file = read_settings(config::load_file(PERIPLUS_SOURCE_DIR "/services/simulator/config/default.yaml"));
  const SimulatorSettings none = read_settings(config::parse("", "empty"));
  EXPECT_EQ(file.seed, none.seed);
  EXPECT_EQ(file.backend, none.backend);
  EXPECT_EQ(file.render_threads, none.render_threads);
  EXPECT_EQ(file.samples, none.samples);
  EXPECT_EQ(file.left.noise, none.left.noise);
  EXPECT_EQ(file.right.gain, none.right.gain);
  EXPECT_EQ(file.right.offset, none.right.offset);
  EXPECT_EQ(file.views_kept, none.views_kept);
  EXPECT_EQ(file.joint_limit_slack, none.joint_limit_slack);
  EXPECT_FALSE(file.right.blank || file.silent_cameras || file.fall_at_tick);
}

TEST(SimulatorSettings, TheSceneGoesBeforeTheConfiguration) {
  SimulatorSettings s;
  s.right.noise = 5;
  s.right.gain = 1.2;
  s.right.offset = 7;
  scene::CameraImperfections cameras;
  apply(cameras, s);
  EXPECT_EQ(s.right.noise, 5);
  EXPECT_EQ(s.right.gain, 1.2);
  EXPECT_EQ(s.right.offset, 7);
  cameras.noise = 0.5;
  cameras.right_gain = 0.8;
  cameras.right_offset = -3;
  apply(cameras, s);
  for (const CameraSensor& eye : {s.left, s.right, s.wide}) EXPECT_EQ(eye.noise, 0.5);
  EXPECT_EQ(s.left.gain, 1);
  EXPECT_EQ(s.right.gain, 0.8);
  EXPECT_EQ(s.right.offset, -3);
}

TEST(SimulatorSettings, WrongValuesAreRefused) {
  EXPECT_THROW(read_settings(config::parse("cameras: {noise: 2}", "a")), Error);
  EXPECT_THROW(read_settings(config::parse("cameras: {noise_grey: -1}", "a")), Error);
  EXPECT_THROW(read_settings(config::parse("rendering: {backend: glx}", "a")), Error);
  EXPECT_TRUE(read_settings(config::parse("faults: {blank_right_eye: true}", "a")).right.blank);
}

}  // namespace
}  // namespace periplus::simulator
