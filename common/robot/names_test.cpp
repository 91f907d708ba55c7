#include "common/robot/names.h"

#include <gtest/gtest.h>

namespace periplus::robot {

TEST(Names, NearestByEditDistance) {
  const std::vector<std::string> known{"RLEG_JOINT0", "RLEG_JOINT3", "HEAD_JOINT1"};
  EXPECT_EQ(nearest_name("RLEGJOINT3", known), "RLEG_JOINT3");
  EXPECT_EQ(nearest_name("head_JOINT1", known), "HEAD_JOINT1");
  EXPECT_EQ(nearest_name("x", {}), "");
}

TEST(Names, SentenceNamesBoth) {
  EXPECT_EQ(unknown_name("joint", "KNEEE", {"KNEE", "HIP"}), "there is no joint 'KNEEE'; did you mean 'KNEE'?");
  EXPECT_EQ(unknown_name("joint", "KNEE", {}), "there is no joint 'KNEE'");
}

}  // namespace periplus::robot
