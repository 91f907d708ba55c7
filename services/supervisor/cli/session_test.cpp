#include "services/supervisor/cli/session.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>

#include <thread>

#include "common/core/error.h"
#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/dds/testing/test_domain.h"
#include "idl/common.h"
#include "idl/supervisor.h"
#include "services/supervisor/cli/launcher.h"

namespace periplus::supervisor::cli {
namespace {

using namespace std::chrono_literals;

// Heartbeats of services in a process of their own making: what a session goes by.
class Heartbeats {
 public:
  explicit Heartbeats(std::vector<std::string> services)
      : node_(dds::Node::create(dds::NodeOptions::from_environment("heartbeats"))),
        status_(*node_, "periplus/service/status", dds::qos_latest()),
        events_(*node_, "periplus/supervisor/event", dds::qos_latest(256)) {
    for (const std::string& service : services) beat(service, 1, "");
  }
  void beat(const std::string& service, int state, const std::string& detail) {
    msg::ServiceStatus s;
    s.instance(service + "-test");
    s.service(service);
    s.state(static_cast<std::uint8_t>(state));
    s.detail(detail);
    status_.publish(s);
  }
  void event(const std::string& kind, const std::string& state) {
    msg::RunEvent e;
    e.run_id("r1");
    e.kind(kind);
    e.state(state + "\x1b[2J");
    events_.publish(e);
  }

 private:
  std::shared_ptr<dds::Node> node_;
  dds::Publisher<msg::ServiceStatus> status_;
  dds::Publisher<msg::RunEvent> events_;
};

class SessionTest : public testing::Test {
 protected:
  void SetUp() override { ::setenv("PERIPLUS_DOMAIN", std::to_string(domain_.id()).c_str(), 1); }
  void TearDown() override { ::unsetenv("PERIPLUS_DOMAIN"); }
  dds::testing::TestDomain domain_;
};

TEST_F(SessionTest, SeesWhoIsThereAndWhatHappened) {
  Heartbeats others(service_names());
  others.event("state", "walk");
  Session session;
  EXPECT_EQ(session.client().domain(), domain_.id());
  EXPECT_TRUE(session.occupied());
  EXPECT_NO_THROW(session.wait_until_ready());
  EXPECT_TRUE(session.look_after().lost.empty());
  const auto events = session.client().take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].state, "walk [2J");  // no control characters reach the terminal

  others.beat("simulator", 4, "");  // a clean good-bye of one that keeps state
  std::vector<std::string> lost;
  for (int i = 0; i < 40 && lost.empty(); ++i) {
    std::this_thread::sleep_for(50ms);
    lost = session.look_after().lost;
  }
  EXPECT_EQ(lost, std::vector<std::string>{"simulator"});
  EXPECT_THROW(session.wait_until_ready(), Error);
}

TEST_F(SessionTest, AnEmptyDomainIsFreeAndASignalEndsTheWait) {
  const Interrupts interrupts;
  Session session;
  EXPECT_FALSE(session.occupied());
  EXPECT_FALSE(session.owns_services());
  ::kill(::getpid(), SIGINT);
  EXPECT_EQ(Interrupts::count(), 1);
  try {
    session.wait_until_ready();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace periplus::supervisor::cli
