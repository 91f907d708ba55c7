#include "common/robot/names.h"

#include <gtest/gtest.h>

namespace periplus::robot {

TEST(Names, SentenceNamesBoth) {
  EXPECT_EQ(unknown_name("joint", "KNEEE", {"KNEE", "HIP"}), "there is no joint 'KNEEE'; did you mean 'KNEE'?");
  EXPECT_EQ(unknown_name("joint", "KNEE", {}), "there is no joint 'KNEE'");
}

}  // namespace periplus::robot
