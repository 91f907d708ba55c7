#include "common/dds/cyclonedds/sertype.h"

#include <gtest/gtest.h>

#include "common/dds/codec_impl.h"
#include "common/dds/testing/test_domain.h"
#include "idl/common.h"

namespace periplus::dds::cyclonedds {
namespace {

class SertypeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    participant_ = dds_create_participant(static_cast<dds_domainid_t>(domain_.id()), nullptr, nullptr);
    ASSERT_GT(participant_, 0);
    topic_ = create_topic(participant_, "t", codec<msg::ServiceStatus>());
    ASSERT_GT(topic_, 0);
    reader_ = dds_create_reader(participant_, topic_, nullptr, nullptr);
    writer_ = dds_create_writer(participant_, topic_, nullptr, nullptr);
  }
  void TearDown() override { dds_delete(participant_); }

  static msg::ServiceStatus status(const std::string& instance, double uptime) {
    msg::ServiceStatus s;
    s.instance(instance);
    s.uptime_s(uptime);
    return s;
  }
  std::vector<msg::ServiceStatus> take_all() {
    std::vector<msg::ServiceStatus> out;
    ddsi_serdata* data = nullptr;
    dds_sample_info_t info;
    while (dds_takecdr(reader_, &data, 1, &info, DDS_ANY_STATE) == 1) {
      msg::ServiceStatus s;
      if (info.valid_data && decode(data, codec<msg::ServiceStatus>(), &s)) out.push_back(s);
      release(data);
    }
    return out;
  }

  testing::TestDomain domain_;
  dds_entity_t participant_ = 0, topic_ = 0, reader_ = 0, writer_ = 0;
};

// History is kept for each key (depth 1 by default), so keys must be told apart beyond their first 16 bytes.
TEST_F(SertypeTest, LongKeysMakeInstances) {
  const std::string prefix(40, 'k');
  for (int i = 0; i < 3; ++i) {
    for (const char* end : {"a", "b"}) {
      const auto s = status(prefix + end, i);
      ASSERT_EQ(dds_write(writer_, &s), DDS_RETCODE_OK);
    }
  }
  const auto got = take_all();
  ASSERT_EQ(got.size(), 2U);
  for (const auto& s : got) EXPECT_EQ(s.uptime_s(), 2);
  EXPECT_NE(got[0].instance().to_string(), got[1].instance().to_string());
}

TEST_F(SertypeTest, DisposedInstanceIsMarked) {
  const auto s = status("one", 1);
  ASSERT_EQ(dds_write(writer_, &s), DDS_RETCODE_OK);
  take_all();
  ASSERT_EQ(dds_dispose(writer_, &s), DDS_RETCODE_OK);
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info;
  ASSERT_EQ(dds_takecdr(reader_, &data, 1, &info, DDS_ANY_STATE), 1);
  EXPECT_FALSE(info.valid_data);
  EXPECT_EQ(info.instance_state, DDS_IST_NOT_ALIVE_DISPOSED);
  release(data);
}

TEST_F(SertypeTest, TopicOfTheSameNameAndTypeIsShared) { EXPECT_GT(create_topic(participant_, "t", codec<msg::ServiceStatus>()), 0); }

}  // namespace
}  // namespace periplus::dds::cyclonedds
