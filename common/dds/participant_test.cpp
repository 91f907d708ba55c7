// What every vendor's participant must do; each vendor's test takes part.
#include "common/dds/participant.h"

#include <gtest/gtest.h>

#include <thread>

#include "common/core/error.h"
#include "common/dds/codec_impl.h"
#include "common/dds/testing/participant_test.h"
#include "idl/common.h"

namespace periplus::dds {

using namespace std::chrono_literals;

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

}  // namespace periplus::dds
