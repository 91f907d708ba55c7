#include "common/dds/participant.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/core/error.h"
#include "common/dds/codec_impl.h"
#include "common/dds/testing/vendor_test.h"
#include "idl/common.h"

namespace periplus::dds {
namespace {

using namespace std::chrono_literals;

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
      if (reader.wait(10ms)) {
        if (const Take taken = reader.take(sample); taken != Take::none) return taken;
      }
    }
    return Take::none;
  }
  testing::TestDomain domain_;
  EndpointMatching matching_;
  std::atomic<std::uint64_t> bad_samples_{0};
};

TEST_P(ParticipantTest, EndpointsKnowEachOthersGuids) {
  const auto participant = join();
  const auto writer = participant->writer("t", codec<msg::Cancel>(), qos_rpc());
  const auto reader = participant->reader("t", codec<msg::Cancel>(), qos_rpc());
  for (int i = 0; i < 500 && !writer->matched(reader->guid()); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_TRUE(writer->matched(reader->guid()));
  EXPECT_FALSE(writer->matched(Guid{}));
  EXPECT_EQ(writer->matched_readers(), std::vector<Guid>{reader->guid()});
}

// Discovery without multicast: two participants that only know this host's address.
TEST_P(ParticipantTest, PeersFindEachOtherWithoutMulticast) {
  const auto one = join({"127.0.0.1"}), two = join({"127.0.0.1"});
  const auto writer = one->writer("t", codec<msg::Cancel>(), qos_latest());
  const auto reader = two->reader("t", codec<msg::Cancel>(), qos_latest());
  msg::Cancel sample, back;
  sample.number(5);
  ASSERT_TRUE(writer->write(&sample));
  ASSERT_EQ(take(*reader, &back), Take::data);
  EXPECT_EQ(back.number(), 5);
}

TEST_P(ParticipantTest, WakeEndsAWait) {
  const auto participant = join();
  const auto reader = participant->reader("t", codec<msg::Cancel>(), qos_stream());
  reader->wait(0ms);
  std::thread waker([&] {
    std::this_thread::sleep_for(50ms);
    reader->wake();
  });
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_FALSE(reader->wait(5s));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 2s);
  waker.join();
}

INSTANTIATE_TEST_SUITE_P(, ParticipantTest, testing::each_vendor());

}  // namespace
}  // namespace periplus::dds
