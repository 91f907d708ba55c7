#include "services/supervisor/interruption.h"

#include <gtest/gtest.h>

namespace periplus::supervisor {
namespace {

TEST(Interruption, TheFirstReasonCountsAndHasteStays) {
  Interruption interruption;
  EXPECT_FALSE(interruption.outcome());
  interruption.abort();
  ASSERT_TRUE(interruption.outcome());
  EXPECT_EQ(interruption.outcome()->trigger, Trigger::abort);
  EXPECT_FALSE(interruption.hasty());   // the robot is brought to a stand, the model kept
  interruption.lose("simulator was ended by signal 9");
  EXPECT_EQ(interruption.outcome()->cause, "aborted by the user");
  EXPECT_TRUE(interruption.hasty());
  interruption.clear();
  EXPECT_FALSE(interruption.outcome());
  EXPECT_FALSE(interruption.hasty());
  interruption.lose("simulator was ended by signal 9");
  interruption.stop();
  EXPECT_EQ(interruption.outcome()->trigger, Trigger::lost);
  EXPECT_EQ(interruption.outcome()->cause, "simulator was ended by signal 9");
}

}  // namespace
}  // namespace periplus::supervisor
