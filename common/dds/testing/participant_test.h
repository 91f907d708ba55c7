// Tests of participants (common/dds/participant_test.cpp), one instance a vendor.
#pragma once

#include <gtest/gtest.h>

#include <chrono>

#include "common/dds/participant.h"
#include "common/dds/testing/vendor_test.h"

namespace periplus::dds {

class ParticipantTest : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Participant> join(const std::vector<std::string>& peers = {}) {
    ParticipantSettings settings;
    settings.options.name = "test";
    settings.options.domain = domain_.id();
    settings.options.peers = peers;
    settings.interface = find_interface("lo");
    return GetParam() == "fastdds" ? make_fastdds_participant(settings, matching_, bad_samples_)
                                   : make_cyclonedds_participant(settings, matching_, bad_samples_);
  }
  static Take take(Reader& reader, void* sample) {
    for (int i = 0; i < 500; ++i) {
      if (reader.wait(std::chrono::milliseconds(10))) {
        if (const Take taken = reader.take(sample); taken != Take::none) return taken;
      }
    }
    return Take::none;
  }
  testing::TestDomain domain_;
  EndpointMatching matching_;
  std::atomic<std::uint64_t> bad_samples_{0};
};

}  // namespace periplus::dds
