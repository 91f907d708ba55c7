#include "common/core/version.h"

#include <gtest/gtest.h>

#include <regex>
#include <string>

TEST(Version, IsThreeNumbers) {
  EXPECT_TRUE(std::regex_match(std::string(periplus::version()), std::regex("[0-9]+\\.[0-9]+\\.[0-9]+"))) << periplus::version();
}
