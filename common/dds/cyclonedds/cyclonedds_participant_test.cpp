#include "common/dds/testing/participant_test.h"

namespace periplus::dds {

INSTANTIATE_TEST_SUITE_P(CycloneDds, ParticipantTest, ::testing::Values("cyclonedds"));

}  // namespace periplus::dds
