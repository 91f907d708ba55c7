#include "common/dds/endpoint_matching.h"

#include <gtest/gtest.h>

namespace periplus::dds {
namespace {

EndpointDescription endpoint(bool writer, std::uint8_t id) {
  EndpointDescription d;
  d.guid.fill(id);
  d.writer = writer;
  d.topic = "topic";
  d.type = "type";
  return d;
}

TEST(FindMismatch, NamesThePolicyThatKeepsThemApart) {
  const auto writer = endpoint(true, 1), reader = endpoint(false, 2);
  EXPECT_FALSE(find_mismatch(writer, reader));
  const auto policy = [&](auto change) {
    auto w = writer, r = reader;
    change(w, r);
    const auto mismatch = find_mismatch(w, r);
    return mismatch ? mismatch->policy : "";
  };
  EXPECT_EQ(policy([](auto& w, auto&) { w.reliable = false; }), "reliability");
  EXPECT_EQ(policy([](auto&, auto& r) { r.reliable = false; }), "");
  EXPECT_EQ(policy([](auto&, auto& r) { r.durability = 1; }), "durability");
  EXPECT_EQ(policy([](auto& w, auto&) { w.durability = 1; }), "");
  EXPECT_EQ(policy([](auto&, auto& r) { r.liveliness = 2; }), "liveliness");
  EXPECT_EQ(policy([](auto&, auto& r) { r.lease_ns = 1; }), "liveliness");
  EXPECT_EQ(policy([](auto& w, auto&) { w.lease_ns = 1; }), "");
  EXPECT_EQ(policy([](auto&, auto& r) { r.deadline_ns = 1; }), "deadline");
  EXPECT_EQ(policy([](auto& w, auto&) { w.exclusive_ownership = true; }), "ownership");
  EXPECT_EQ(policy([](auto& w, auto&) { w.type = "other"; }), "type");
}

TEST(EndpointMatching, CountsEachPairOnceInWhicheverOrderTheyAppear) {
  EndpointMatching matching;
  auto remote = endpoint(true, 1);
  remote.reliable = false;
  matching.add_remote(remote);
  EXPECT_EQ(matching.mismatches(), 0U);
  matching.add_local(endpoint(false, 2));
  EXPECT_EQ(matching.mismatches(), 1U);
  matching.add_remote(remote);  // announced again
  EXPECT_EQ(matching.mismatches(), 1U);
  matching.add_local(endpoint(false, 3));
  EXPECT_EQ(matching.mismatches(), 2U);
}

TEST(EndpointMatching, OtherTopicsSameDirectionAndWhatWentAreNoMismatch) {
  EndpointMatching matching;
  matching.add_local(endpoint(false, 2));
  auto remote = endpoint(true, 1);
  remote.reliable = false;
  remote.topic = "another";
  matching.add_remote(remote);
  auto same_direction = endpoint(false, 3);
  same_direction.type = "another";
  matching.add_remote(same_direction);
  matching.remove(endpoint(false, 2).guid);
  remote.topic = "topic";
  matching.add_remote(remote);
  EXPECT_EQ(matching.mismatches(), 0U);
}

TEST(Describe, TakesTheQosOver) {
  Codec codec;
  codec.type_name = "module::Type";
  const auto d = describe(Guid{}, true, "t", codec, {.reliable = false, .transient_local = true, .liveliness = std::chrono::milliseconds(500)});
  EXPECT_EQ(d.type, "module::Type");
  EXPECT_FALSE(d.reliable);
  EXPECT_EQ(d.durability, 1);
  EXPECT_EQ(d.lease_ns, 500000000);
}

TEST(GuidText, IsReadable) {
  Guid guid{};
  guid[0] = 1;
  guid[15] = 0xab;
  EXPECT_EQ(to_string(guid), "01.00.00.00.00.00.00.00.00.00.00.00|00.00.00.ab");
}

}  // namespace
}  // namespace periplus::dds
