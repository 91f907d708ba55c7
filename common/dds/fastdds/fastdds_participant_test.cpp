#include "common/dds/testing/participant_test.h"

namespace periplus::dds {

INSTANTIATE_TEST_SUITE_P(FastDds, ParticipantTest, ::testing::Values("fastdds"));

}  // namespace periplus::dds
