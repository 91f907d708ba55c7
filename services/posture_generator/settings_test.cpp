#include "services/posture_generator/settings.h"

#include <gtest/gtest.h>

#include "common/core/config.h"
#include "common/core/error.h"

namespace periplus::posture {

TEST(Settings, DefaultFileNamesEveryParameterWithItsDefault) {
  const config::Node node = config::load_file(std::string(PERIPLUS_SOURCE_DIR) + "/services/posture_generator/config/default.yaml");
  const Settings from_file = read_settings(node), built_in;
  node.finish();
  EXPECT_EQ(from_file.max_iterations, built_in.max_iterations);
  EXPECT_EQ(from_file.patience, built_in.patience);
  EXPECT_EQ(from_file.starts, built_in.starts);
  EXPECT_DOUBLE_EQ(from_file.scene_distance, built_in.scene_distance);
  EXPECT_DOUBLE_EQ(from_file.stance_x, built_in.stance_x);
  EXPECT_NEAR(from_file.stance_yaw_out, built_in.stance_yaw_out, 0.01);
  EXPECT_NEAR(from_file.base_pitch_max, built_in.base_pitch_max, 0.01);
  EXPECT_NEAR(from_file.base_roll, built_in.base_roll, 0.01);
}

TEST(Settings, RefusesWhatMakesNoSense) {
  EXPECT_THROW(read_settings(config::parse("max_iterations: 0", "x")), Error);
  EXPECT_THROW(read_settings(config::parse("equilibrium_share: 0.7", "x")), Error);
  EXPECT_THROW(read_settings(config::parse("object_cell_m: .nan", "x")), Error);
  const config::Node unknown = config::parse("stance_x: 0.1", "x");
  read_settings(unknown);
  EXPECT_THROW(unknown.finish(), Error);
}

}  // namespace periplus::posture
