// What a vendor's back end provides: one participant and its endpoints. Node owns it and makes it anew after a cut.
#pragma once

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "common/dds/endpoint_matching.h"
#include "common/dds/network_interface.h"
#include "common/dds/node.h"

namespace periplus::dds {

class Participant {
 public:
  virtual ~Participant() = default;
  // All endpoints must be gone before the participant. Throw Error(internal) if the vendor refuses.
  virtual std::unique_ptr<Writer> writer(const std::string& topic, const Codec& codec, const Qos& qos) = 0;
  virtual std::unique_ptr<Reader> reader(const std::string& topic, const Codec& codec, const Qos& qos) = 0;
  // Called about eight times a second by the node's own thread.
  virtual void poll() {}
};

struct ParticipantSettings {
  NodeOptions options;
  NetworkInterface interface;
  std::chrono::milliseconds announcement{1000};  // period of participant announcements
};

// How often a participant announces itself: four times a lease at least, so that a single loss never ends it, and every
// second, since a peer that missed the first announcements waits for the next to find it.
inline std::chrono::milliseconds announcement_period(std::chrono::milliseconds lease) { return std::min(lease / 4, std::chrono::milliseconds(1000)); }

// User data comes in through the port of discovery (DDSI-RTPS 9.6.1.1: 10; user data would be 11). Fast DDS 2.9 as Debian
// builds it aborts on an assertion of its statistics when a transient-local writer with samples meets a reader at an
// address that it never sent to (github.com/eProsima/Fast-DDS pull request 3169); to this one it sent discovery before.
inline constexpr int kUnicastPortOffset = 10;

// `matching` and `bad_samples` outlive the participant; the latter counts what the vendor's threads had to drop.
std::unique_ptr<Participant> make_fastdds_participant(const ParticipantSettings& settings, EndpointMatching& matching,
                                                      std::atomic<std::uint64_t>& bad_samples);
std::unique_ptr<Participant> make_cyclonedds_participant(const ParticipantSettings& settings, EndpointMatching& matching,
                                                         std::atomic<std::uint64_t>& bad_samples);

}  // namespace periplus::dds
