#include "integration-tests/fuzz/mutation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace periplus::fuzz {
namespace {

TEST(Mutation, IsTheSameForTheSameSeedAndSeldomForAnother) {
  const std::string input = "voxel_m: 0.01\nseed: 7\n", other = "name: bunny\n";
  std::set<std::string> made;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random a(seed), b(seed);
    const std::string first = mutated(input, other, a);
    EXPECT_EQ(first, mutated(input, other, b));
    made.insert(first);
  }
  EXPECT_GE(made.size(), 150u);
}

TEST(Mutation, TakesNumbersToTheirExtremes) {
  int extreme = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Random random(seed);
    extreme += mutated("voxel_m: 0.01\n", "", random).find("voxel_m: 1e308\n") == 0;
  }
  EXPECT_GE(extreme, 1);
}

TEST(Mutation, AnEmptyInputBecomesWhatTheOtherIs) {
  Random random(1);
  EXPECT_EQ(mutated("", "", random), "");
  std::size_t longest = 0;
  for (int n = 0; n < 20; ++n) longest = std::max(longest, mutated("", "name: bunny\n", random).size());
  EXPECT_GT(longest, 0u);
}

}  // namespace
}  // namespace periplus::fuzz
