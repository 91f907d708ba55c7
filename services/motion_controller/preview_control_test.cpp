#include "services/motion_controller/preview_control.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/core/error.h"

namespace periplus::motion {
namespace {

TEST(PreviewControl, FollowsAStepThatItSeesComing) {
  const PreviewControl control(0.8);
  std::vector<double> reference(800, 0.0);
  for (std::size_t k = 400; k < reference.size(); ++k) reference[k] = 0.1;
  PreviewState state;
  double moved_before = 0;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    if (k == 399) moved_before = state.com(0);
    // Near the step the model cannot jump; away from it, it follows to a millimetre or two.
    if (k < 380 || k > 420) {
      EXPECT_NEAR(control.zmp(state), reference[k], 0.004) << k;
    }
    control.advance(state, std::span(reference).subspan(k));
  }
  EXPECT_GT(moved_before, 0.03);  // the centre of mass leaves before the zero-moment point does
  EXPECT_NEAR(state.com(0), 0.1, 1e-3);
  EXPECT_NEAR(state.com(1), 0, 1e-3);
}

TEST(PreviewControl, StaysAtRest) {
  const PreviewControl control(0.8);
  PreviewState state = PreviewState::at_rest(0.3);
  const std::vector<double> reference{0.3};
  for (int k = 0; k < 1000; ++k) control.advance(state, reference);
  EXPECT_NEAR(state.com(0), 0.3, 1e-9);
}

TEST(PreviewControl, RefusesSettingsWithoutMeaning) {
  EXPECT_THROW(PreviewControl(0), Error);
  EXPECT_THROW(PreviewControl(0.8, {.period = 0}), Error);
}

}  // namespace
}  // namespace periplus::motion
