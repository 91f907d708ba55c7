#include "common/dds/node.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <cstdlib>
#include <thread>

#include "common/core/error.h"
#include "common/dds/codec_impl.h"
#include "common/dds/testing/eventually.h"
#include "common/dds/testing/vendor_test.h"
#include "idl/common.h"

namespace periplus::dds {
namespace {

using namespace std::chrono_literals;

using testing::eventually;

class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
  ~Environment() { unsetenv(name_); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
};

TEST(NodeOptions, ComeFromTheEnvironment) {
  const Environment vendor("PERIPLUS_DDS", "cyclonedds"), domain("PERIPLUS_DOMAIN", "7"), interface("PERIPLUS_INTERFACE", "eth7"),
      peers("PERIPLUS_PEERS", "10.0.0.2, 10.0.0.3"), shm("PERIPLUS_SHM", "0");
  const auto options = NodeOptions::from_environment("me");
  EXPECT_EQ(options.name, "me");
  EXPECT_EQ(options.vendor, "cyclonedds");
  EXPECT_EQ(options.domain, 7);
  EXPECT_EQ(options.interface, "eth7");
  EXPECT_EQ(options.peers, (std::vector<std::string>{"10.0.0.2", "10.0.0.3"}));
  EXPECT_FALSE(options.shared_memory);
}

TEST(NodeOptions, DefaultsStayOnLoopback) {
  const auto options = NodeOptions::from_environment("me");
  EXPECT_EQ(options.vendor, "fastdds");
  EXPECT_EQ(options.interface, "lo");
  EXPECT_TRUE(options.peers.empty());
}

TEST(NodeOptions, BadValuesAreRefusedWithTheVariablesName) {
  for (const auto& [name, value] : {std::pair{"PERIPLUS_DDS", "opendds"}, {"PERIPLUS_DOMAIN", "102"}, {"PERIPLUS_DOMAIN", "-1"},
                                    {"PERIPLUS_DOMAIN", "x"}, {"PERIPLUS_PEERS", "10.0.0.2,robot"}, {"PERIPLUS_SHM", "yes"}}) {
    const Environment variable(name, value);
    try {
      NodeOptions::from_environment("me");
      ADD_FAILURE() << name << "=" << value << " was taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_input);
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos);
    }
  }
}

std::string thread_name() {
  char name[16] = {};
  pthread_getname_np(pthread_self(), name, sizeof name);
  return name;
}

using NodeTest = testing::VendorTest;

TEST_P(NodeTest, SamplesArriveInOrderOnAThreadOfTheSubscribersOwn) {
  const auto self = node();
  std::vector<std::int64_t> numbers;
  std::atomic<int> count{0};
  std::string thread;  // of the vendors' threads none has this name
  Subscriber<msg::Cancel> in(*self, "t", qos_stream(200), [&](const msg::Cancel& c) {
    numbers.push_back(c.number());
    thread = thread_name();
    ++count;
  });
  Publisher<msg::Cancel> out(*self, "t", qos_stream(200));
  ASSERT_TRUE(eventually([&] { return in.matched() == 1 && out.matched() == 1; }));
  for (int i = 0; i < 100; ++i) {
    msg::Cancel c;
    c.number(i);
    EXPECT_TRUE(out.publish(c));
  }
  ASSERT_TRUE(eventually([&] { return count == 100; })) << count;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(numbers[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(thread, "periplus-reader");
}

TEST_P(NodeTest, PartitionsDoNotHearEachOther) {
  const auto self = node();
  std::atomic<int> plain{0}, truth{0};
  Subscriber<msg::Cancel> in_plain(*self, "t", qos_latest(), [&](const auto&) { ++plain; });
  Qos qos = qos_latest();
  qos.partition = "truth";
  Subscriber<msg::Cancel> in_truth(*self, "t", qos, [&](const auto&) { ++truth; });
  Publisher<msg::Cancel> out(*self, "t", qos);
  out.publish(msg::Cancel{});
  EXPECT_TRUE(eventually([&] { return truth == 1; }));
  std::this_thread::sleep_for(100ms);
  EXPECT_EQ(plain, 0);
}

TEST_P(NodeTest, CallbackThatThrowsDoesNotEndTheSubscriber) {
  const auto self = node();
  std::atomic<int> count{0};
  Subscriber<msg::Cancel> in(*self, "t", qos_stream(), [&](const auto&) {
    ++count;
    throw std::runtime_error("in a callback");
  });
  Publisher<msg::Cancel> out(*self, "t", qos_stream());
  ASSERT_TRUE(eventually([&] { return in.matched() == 1 && out.matched() == 1; }));
  out.publish(msg::Cancel{});
  out.publish(msg::Cancel{});
  EXPECT_TRUE(eventually([&] { return count == 2; }));
}

TEST_P(NodeTest, TopicOfAnotherTypeIsRefused) {
  const auto self = node();
  Publisher<msg::Cancel> out(*self, "t", qos_stream());
  EXPECT_THROW(Publisher<msg::Progress>(*self, "t", qos_stream()), Error);
}

TEST_P(NodeTest, SubscriberEndsAtOnce) {
  const auto self = node();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 10; ++i) Subscriber<msg::Cancel> in(*self, "t", qos_stream(), [](const auto&) {});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 3s);
}

INSTANTIATE_TEST_SUITE_P(, NodeTest, testing::each_vendor());

}  // namespace
}  // namespace periplus::dds
