#include "common/service/other_instances.h"

#include <gtest/gtest.h>

namespace periplus::service {
namespace {

constexpr std::uint8_t kStarting = 0, kReady = 1, kDegraded = 2, kStopped = 4;

TEST(OtherInstances, GivesWayToWhoeverIsThereAlready) {
  OtherInstances others("supervisor-b-7-22222222");
  EXPECT_FALSE(others.stronger());
  others.heard("supervisor-b-7-22222222", kReady);   // itself
  EXPECT_FALSE(others.stronger());
  others.heard("supervisor-b-7-33333333", kReady);   // of a container with the same host name and process number
  EXPECT_EQ(others.stronger(), "supervisor-b-7-33333333");
  others.heard("supervisor-b-7-33333333", kStopped);
  EXPECT_FALSE(others.stronger());
  others.heard("supervisor-c-1-00000000", kDegraded);
  EXPECT_TRUE(others.stronger());
}

TEST(OtherInstances, OfTwoThatStartTogetherOneStays) {
  OtherInstances first("supervisor-a-1-x"), second("supervisor-b-1-x");
  first.heard("supervisor-b-1-x", kStarting);
  second.heard("supervisor-a-1-x", kStarting);
  EXPECT_FALSE(first.stronger());
  EXPECT_EQ(second.stronger(), "supervisor-a-1-x");
}

}  // namespace
}  // namespace periplus::service
