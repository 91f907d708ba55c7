// The codec against good, foreign and hostile bytes.
#include "common/dds/codec_impl.h"

#include <gtest/gtest.h>

#include "common/core/random.h"
#include "common/dds/testing/allocations.h"
#include "common/dds/bounded_read.h"
#include "idl/common.h"
#include "idl/model.h"
#include "idl/motion.h"
#include "idl/nbv.h"
#include "idl/posture.h"
#include "idl/ros2.h"
#include "idl/supervisor.h"
#include "idl/vision.h"

namespace periplus::dds {
namespace {

using testing::largest_allocation;

template <class T>
std::vector<std::uint8_t> encode(const T& sample) {
  std::vector<std::uint8_t> bytes(codec<T>().size(&sample));
  const std::size_t n = codec<T>().encode(&sample, bytes.data(), bytes.size());
  EXPECT_GT(n, 0U);
  EXPECT_LE(n, bytes.size());
  bytes.resize(n);
  return bytes;
}

msg::Perception perception() {
  msg::Perception p;
  p.view_id("view-1");
  p.depth().resize(2);
  for (auto& d : p.depth()) d.depth().assign(100, 1.5F);
  p.color().assign(300, 7);
  p.features().resize(5);
  for (auto& f : p.features()) f.descriptor().assign(128, 3);
  return p;
}

sensor_msgs::msg::dds_::JointState_ joints() {
  sensor_msgs::msg::dds_::JointState_ j;
  j.name() = {"CHEST_JOINT0", "CHEST_JOINT1"};
  j.position() = {0.1, 0.2};
  return j;
}

TEST(Codec, SamplesComeBackAsTheyWere) {
  const auto bytes = encode(perception());
  msg::Perception back;
  ASSERT_TRUE(codec<msg::Perception>().decode(bytes.data(), bytes.size(), &back));
  EXPECT_EQ(back.view_id().to_string(), "view-1");
  EXPECT_EQ(back.depth().at(1).depth(), std::vector<float>(100, 1.5F));
  EXPECT_EQ(back.features().size(), 5U);
  EXPECT_EQ(encode(back), bytes);
  const auto j = encode(joints());
  sensor_msgs::msg::dds_::JointState_ joints_back;
  ASSERT_TRUE(codec<sensor_msgs::msg::dds_::JointState_>().decode(j.data(), j.size(), &joints_back));
  EXPECT_EQ(joints_back.name(), joints().name());
}

TEST(Codec, KnowsTypeNamesAndKeys) {
  EXPECT_EQ(codec<msg::Perception>().type_name, "periplus::msg::Perception");
  EXPECT_EQ(codec<sensor_msgs::msg::dds_::Image_>().type_name, "sensor_msgs::msg::dds_::Image_");
  EXPECT_TRUE(codec<msg::ServiceStatus>().keyed);
  EXPECT_TRUE(codec<msg::ServiceStatus>().key_md5);
  EXPECT_FALSE(codec<msg::CaptureRequest>().keyed);
  std::vector<std::uint8_t> key;
  msg::ServiceStatus status;
  status.instance("view-1");
  ASSERT_TRUE(codec<msg::ServiceStatus>().key_be(&status, key));
  EXPECT_EQ(key, (std::vector<std::uint8_t>{0, 0, 0, 7, 'v', 'i', 'e', 'w', '-', '1', 0}));
}

TEST(Codec, TooSmallABufferFailsToEncode) {
  const auto p = perception();
  std::vector<std::uint8_t> bytes(20);
  EXPECT_EQ(codec<msg::Perception>().encode(&p, bytes.data(), bytes.size()), 0U);
}

TEST(Codec, EveryTruncationIsABadSample) {
  const auto bytes = encode(perception());
  for (std::size_t n = 0; n + 8 < bytes.size(); n += 3) {
    msg::Perception back;
    EXPECT_FALSE(codec<msg::Perception>().decode(bytes.data(), n, &back)) << n;
  }
}

TEST(Codec, StringLongerThanItsBoundIsABadSample) {
  // A header of 40 octets and number, then the identifier: its bound is 64.
  msg::PublishRequest request;
  request.object_id("v");
  auto bytes = encode(request);
  const std::size_t at = bytes.size() - 2 - 4;
  for (const std::uint32_t length : {64U, 65U}) {
    auto longer = bytes;
    longer.resize(at);
    longer.insert(longer.end(), {static_cast<std::uint8_t>(length + 1), 0, 0, 0});
    longer.insert(longer.end(), length, 'x');
    longer.push_back(0);
    msg::PublishRequest back;
    EXPECT_EQ(codec<msg::PublishRequest>().decode(longer.data(), longer.size(), &back), length == 64) << length;
  }
}

template <class T>
bool survives(const T& sample) {
  const auto bytes = encode(sample);
  T back;
  return codec<T>().decode(bytes.data(), bytes.size(), &back);
}

TEST(Codec, SequenceLongerThanItsBoundIsABadSample) {
  for (const std::size_t over : {0U, 1U}) {
    msg::PlanViewRequest plan;
    plan.forbidden().resize(256 + over);  // structures
    EXPECT_EQ(survives(plan), over == 0);
    msg::WalkRequest walk;
    walk.steps().resize(1024 + over);
    EXPECT_EQ(survives(walk), over == 0);
    msg::PostureRequest posture;
    posture.start().resize(256 + over);  // numbers
    EXPECT_EQ(survives(posture), over == 0);
    auto seen = perception();
    seen.features()[2].descriptor().resize(512 + over);  // within a sequence of structures
    EXPECT_EQ(survives(seen), over == 0);
    msg::ModelFile file;
    file.data().resize((64U << 20) + over);  // of a type with a name
    EXPECT_EQ(survives(file), over == 0);
  }
  sensor_msgs::msg::dds_::Image_ image;  // as in ROS 2: without bound
  image.data().resize(65U << 20);
  EXPECT_TRUE(survives(image));
}

// A length over the bound is refused before anything of the sequence is read.
TEST(Codec, HostileLengthOverItsBoundAllocatesNothing) {
  msg::PlanViewRequest plan;
  plan.plan_id("p");
  plan.forbidden().resize(200);
  auto bytes = encode(plan);
  std::size_t at = 0;
  while (at + 4 < bytes.size() && !(bytes[at] == 200 && bytes[at + 1] == 0 && bytes[at + 2] == 0 && bytes[at + 3] == 0)) ++at;
  bytes[at + 1] = 1;  // 456
  msg::PlanViewRequest back;
  largest_allocation() = 0;
  EXPECT_FALSE(codec<msg::PlanViewRequest>().decode(bytes.data(), bytes.size(), &back));
  EXPECT_LT(largest_allocation(), 1024U);
}

TEST(Codec, ArraysOfSequencesAreReadThroughTheChecks) {
  std::array<std::vector<std::string>, 2> array, back;
  array[0] = {"a", "b"};
  eprosima::fastcdr::FastBuffer buffer;
  eprosima::fastcdr::Cdr out(buffer);
  out << array[0] << array[1];
  eprosima::fastcdr::FastBuffer good(buffer.getBuffer(), out.getSerializedDataLength());
  eprosima::fastcdr::Cdr in(good);
  idl::read_checked(in, back);
  EXPECT_EQ(back, array);
  buffer.getBuffer()[3] = 0x7f;  // 2 becomes two thousand million
  eprosima::fastcdr::Cdr hostile(good);
  largest_allocation() = 0;
  EXPECT_ANY_THROW(idl::read_checked(hostile, back));
  EXPECT_LT(largest_allocation(), 4096U);
}

// A length of four thousand million elements in front of a few bytes must not be believed.
TEST(Codec, HostileLengthsAllocateNoMoreThanThePayloadJustifies) {
  const auto bytes = encode(perception());
  for (std::size_t at = 4; at + 4 <= bytes.size(); at += 4) {
    for (const std::uint32_t length : {0xffffffffU, 0x7fffffffU, 0x00ffffffU, 0x00010000U}) {
      auto hostile = bytes;
      for (std::size_t i = 0; i < 4; ++i) hostile[at + i] = static_cast<std::uint8_t>(length >> (8 * i));
      msg::Perception back;
      largest_allocation() = 0;
      codec<msg::Perception>().decode(hostile.data(), hostile.size(), &back);
      ASSERT_LT(largest_allocation(), 64 * bytes.size()) << "at " << at << " length " << length;
    }
  }
}

template <class T>
void fuzz(const T& sample, std::uint64_t seed) {
  const auto bytes = encode(sample);
  Random random(seed);
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    auto hostile = bytes;
    if (random.below(4) == 0) hostile.resize(random.below(bytes.size() + 1));
    for (std::uint64_t changes = 1 + random.below(8); changes > 0 && !hostile.empty(); --changes) {
      hostile[random.below(hostile.size())] = static_cast<std::uint8_t>(random.below(2) ? 0xff : random.next());
    }
    T back;
    largest_allocation() = 0;
    refused += !codec<T>().decode(hostile.data(), hostile.size(), &back);
    ASSERT_LT(largest_allocation(), 64 * bytes.size() + 4096);
  }
  EXPECT_GT(refused, 0);
}

TEST(Codec, FuzzedSamplesNeverThrowNorAllocateMuch) {
  fuzz(perception(), 1);
  fuzz(joints(), 2);
  msg::ObjectChunk chunk;
  chunk.object_id("bunny");
  chunk.voxels().assign(512, 1);
  chunk.landmarks().resize(4);
  fuzz(chunk, 3);
  msg::ServiceMetrics metrics;
  metrics.instance("a");
  metrics.rpcs().resize(3);
  fuzz(metrics, 4);
  msg::SetEnvironmentRequest environment;
  environment.environment().scene_id("room");
  environment.environment().robot_urdf().assign(1000, 'x');
  fuzz(environment, 5);
}

}  // namespace
}  // namespace periplus::dds
