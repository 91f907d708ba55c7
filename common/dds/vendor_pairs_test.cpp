// Both vendors, alone and mixed, in separate processes: the other side is the program dds_peer.
#include <unistd.h>

#include <atomic>
#include <future>
#include <map>
#include <mutex>
#include <set>

#include "common/core/file.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/dds/rpc.h"
#include "common/dds/testing/eventually.h"
#include "common/dds/testing/vendor_test.h"
#include "idl/common.h"
#include "idl/model.h"
#include "idl/ros2.h"

namespace periplus::dds {
namespace {

using namespace std::chrono_literals;
using testing::eventually;
using Clock = std::chrono::steady_clock;
using Client = RpcClient<msg::ExportRequest, msg::ExportReply>;

double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

class VendorPairs : public testing::VendorPairTest {
 protected:
  static msg::ExportRequest request(const std::string& what, const std::string& text = "") {
    msg::ExportRequest q;
    q.object_id(what);
    q.format(text);
    return q;
  }
};

TEST_P(VendorPairs, LateJoinerGetsTheNewestStateOfEachKey) {
  const auto other = peer("status", "15");  // more keys than Fast DDS' default of 10 instances
  const auto self = node();
  std::mutex mutex;
  std::map<std::string, double> newest;
  Subscriber<msg::ServiceStatus> in(*self, "state", qos_latest(), [&](const msg::ServiceStatus& s) {
    const std::lock_guard lock(mutex);
    newest[s.instance().to_string()] = s.uptime_s();
  });
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    if (newest.size() != 15) return false;
    for (const auto& [key, value] : newest) {
      if (value < 15) return false;
    }
    return true;
  })) << newest.size();
}

TEST_P(VendorPairs, LargeSamplesArriveWhole) {
  const auto self = node();
  std::atomic<int> whole{0}, broken{0};
  std::mutex mutex;
  std::string seen;
  Subscriber<sensor_msgs::msg::dds_::Image_> in(*self, "rt/image", qos_stream(32), [&](const auto& image) {
    if (image.header().stamp().sec() < 0) return;
    bool same = image.data().size() == 1843200 && image.encoding() == "rgb8";
    for (std::size_t i = 0; same && i < image.data().size(); ++i) same = image.data()[i] == static_cast<std::uint8_t>(i * 31);
    ++(same ? whole : broken);
    const std::lock_guard lock(mutex);
    seen += std::to_string(image.header().stamp().sec()) + " ";
  });
  const auto other = peer("images", "20");
  ASSERT_TRUE(eventually([&] { return in.matched() == 1; }));
  Publisher<msg::Cancel> go(*self, "go", qos_latest());
  go.publish(msg::Cancel{});
  EXPECT_TRUE(eventually([&] { return whole == 20; })) << whole << " of 20: " << seen;
  EXPECT_EQ(broken, 0);
  EXPECT_EQ(in.bad(), 0U);
}

TEST_P(VendorPairs, CallsAreAnswered) {
  const auto other = peer("serve", "test/echo");
  const auto self = node();
  Client client(*self, "test/echo");
  msg::ExportReply reply;
  for (int i = 0; i < 200; ++i) {
    auto q = request("echo", std::to_string(i));
    const auto result = client.call(q, reply, {.deadline = 10s, .wait_for_server = 10s});
    ASSERT_TRUE(result.ok()) << to_string(result.status) << " at call " << i;
    ASSERT_EQ(reply.sha256().to_string(), std::to_string(i));
    ASSERT_EQ(reply.revision(), static_cast<std::uint32_t>(i + 1)) << "run twice";
  }
  auto refused = request("refuse");
  auto result = client.call(refused, reply);
  EXPECT_EQ(result.error_code, static_cast<int>(ErrorCode::model_object_unknown));
  EXPECT_EQ(result.error_message, "no object of that name; begin it first");
  EXPECT_THROW(result.throw_if_failed("test/echo"), Error);
  auto defect = request("defect");
  result = client.call(defect, reply);
  EXPECT_EQ(result.error_code, static_cast<int>(ErrorCode::internal));
}

// By then a writer without matched readers has long been counted as silent.
TEST_P(VendorPairs, ClientMadeLongAfterItsNodeFindsTheServer) {
  const auto self = node();
  const auto other = peer("serve", "test/echo");
  std::this_thread::sleep_for(3s);
  for (int i = 0; i < 2; ++i) {
    Client client(*self, "test/echo");
    msg::ExportReply reply;
    auto q = request("echo", "late");
    const auto result = client.call(q, reply, {.deadline = 10s, .wait_for_server = 5s});
    ASSERT_TRUE(result.ok()) << to_string(result.status);
    std::this_thread::sleep_for(1s);
  }
}

// A loaded computer may starve a server for longer than its liveliness lease while nobody calls it.
TEST_P(VendorPairs, ServerStarvedWithoutCallsIsFoundAgain) {
  const auto other = peer("serve", "test/echo");
  const auto self = node();
  Client client(*self, "test/echo");
  ASSERT_TRUE(eventually([&] { return client.servers() == 1; }));
  std::this_thread::sleep_for(1s);
  other->signal(SIGSTOP);
  ASSERT_TRUE(eventually([&] { return client.servers() == 0; }));
  other->signal(SIGCONT);
  EXPECT_TRUE(eventually([&] { return client.servers() == 1; }, 4s));
  msg::ExportReply reply;
  auto q = request("echo", "again");
  const auto result = client.call(q, reply, {.deadline = 10s});
  EXPECT_TRUE(result.ok()) << to_string(result.status);
}

TEST_P(VendorPairs, ConcurrentCallsEachGetTheirOwnReply) {
  const auto other = peer("serve", "test/echo");
  const auto self = node();
  Client client(*self, "test/echo");
  ASSERT_TRUE(client.wait_for_server(10s));
  std::atomic<int> right{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 25; ++i) {
        const std::string text = std::to_string(t) + "." + std::to_string(i);
        auto q = request("echo", text);
        msg::ExportReply reply;
        if (client.call(q, reply, {.deadline = 10s}).ok() && reply.sha256().to_string() == text) ++right;
      }
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(right, 200);
}

TEST_P(VendorPairs, DuplicateIsAnsweredAndNotRunTwice) {
  const auto other = peer("serve", "test/echo");
  const auto self = node();
  std::mutex mutex;
  std::vector<std::uint32_t> runs;
  ReaderThread replies(*self, "rr/test/echo", codec<msg::ExportReply>(), qos_rpc(), [&](const void* sample) {
    const auto& reply = *static_cast<const msg::ExportReply*>(sample);
    if (reply.header().number() != 7) return;  // a sign of life
    const std::lock_guard lock(mutex);
    runs.push_back(reply.revision());
  });
  const auto count = [&] {
    const std::lock_guard lock(mutex);
    return runs.size();
  };
  const auto requests = self->writer("rq/test/echo", codec<msg::ExportRequest>(), qos_rpc());
  ASSERT_TRUE(eventually([&] { return requests->matched_count() > 0 && replies.reader().alive_writers() > 0; }));
  auto q = request("slow");
  q.header().client().value(replies.reader().guid());
  q.header().number(7);
  for (int i = 0; i < 100 && count() == 0; ++i) {  // again and again while it runs
    requests->write(&q);
    std::this_thread::sleep_for(100ms);
  }
  std::this_thread::sleep_for(200ms);
  const std::size_t before = count();
  EXPECT_LE(before, 2U) << "duplicates of a running call are not answered one by one";  // one may just meet its end
  requests->write(&q);  // when it is done: from the window
  EXPECT_TRUE(eventually([&] { return count() == before + 1; }));
  EXPECT_EQ(std::set<std::uint32_t>(runs.begin(), runs.end()), std::set<std::uint32_t>{1}) << "the handler ran more than once";
}

TEST_P(VendorPairs, RequestThatIsNotAnsweredSoonIsSentAgainAndRunOnce) {
  const auto other = peer("serve", "test/echo");
  const auto self = node();
  Client client(*self, "test/echo");
  msg::ExportReply reply;
  auto slow = request("slow");
  const auto result = client.call(slow, reply, {.deadline = 10s, .wait_for_server = 10s});
  ASSERT_TRUE(result.ok()) << to_string(result.status);
  EXPECT_GE(result.resends, 1);
  auto echo = request("echo");
  ASSERT_TRUE(client.call(echo, reply, {.deadline = 10s}).ok());
  EXPECT_EQ(reply.revision(), 2U) << "the slow request ran more than once";
}

// Asked the same thing again: answered from the window, and run again once the window of a silent client is forgotten.
TEST_P(VendorPairs, WindowOfASilentClientExpires) {
  const auto other = peer("forgetful", "test/echo");
  const auto self = node();
  std::mutex mutex;
  std::vector<std::uint32_t> runs;
  ReaderThread replies(*self, "rr/test/echo", codec<msg::ExportReply>(), qos_rpc(), [&](const void* sample) {
    const auto& reply = *static_cast<const msg::ExportReply*>(sample);
    const std::lock_guard lock(mutex);
    if (reply.header().number() == 7) runs.push_back(reply.revision());
  });
  const auto requests = self->writer("rq/test/echo", codec<msg::ExportRequest>(), qos_rpc());
  ASSERT_TRUE(eventually([&] { return requests->matched_count() > 0 && replies.reader().alive_writers() > 0; }));
  auto q = request("echo");
  q.header().client().value(replies.reader().guid());
  q.header().number(7);
  const auto answers = [&] {
    const std::lock_guard lock(mutex);
    return runs;
  };
  requests->write(&q);
  ASSERT_TRUE(eventually([&] { return answers().size() == 1; }));
  requests->write(&q);
  ASSERT_TRUE(eventually([&] { return answers().size() == 2; }));
  EXPECT_EQ(answers(), (std::vector<std::uint32_t>{1, 1}));
  std::this_thread::sleep_for(2500ms);  // a second of silence, and the server looks once a second
  requests->write(&q);
  ASSERT_TRUE(eventually([&] { return answers().size() == 3; }));
  EXPECT_EQ(answers().back(), 2U);
}

TEST_P(VendorPairs, NoServerHungServerAndLostServerAreToldApart) {
  const auto self = node();
  Client client(*self, "test/echo");
  msg::ExportReply reply;
  auto echo = request("echo"), hang = request("hang");
  EXPECT_EQ(client.call(echo, reply).status, RpcStatus::no_server);

  const auto other = peer("serve", "test/echo");
  EXPECT_EQ(client.call(hang, reply, {.deadline = 1500ms, .wait_for_server = 10s}).status, RpcStatus::timeout);
  EXPECT_TRUE(client.call(echo, reply).ok()) << "the other threads of the server still answer";

  auto lost = std::async(std::launch::async, [&] {
    msg::ExportReply r;
    auto q = request("hang");
    return client.call(q, r, {.deadline = 20s});
  });
  std::this_thread::sleep_for(400ms);
  other->signal(SIGKILL);
  const auto killed = Clock::now();
  EXPECT_EQ(lost.get().status, RpcStatus::server_lost);
  EXPECT_LT(seconds_since(killed), 2.0);
}

TEST_P(VendorPairs, InstancesShareTheLoadAndOneTakesOverWhenTheOtherDies) {
  const auto first = peer("serve", "test/echo"), second = peer("serve", "test/echo");
  const auto self = node();
  Client client(*self, "test/echo");
  ASSERT_TRUE(eventually([&] { return client.servers() == 2; }));
  std::map<std::uint64_t, std::uint32_t> runs;
  msg::ExportReply reply;
  for (int i = 0; i < 10; ++i) {
    auto q = request("echo");
    ASSERT_TRUE(client.call(q, reply).ok());
    runs[reply.bytes()] = reply.revision();
  }
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs.begin()->second + runs.rbegin()->second, 10U) << "each request runs on one instance only";

  std::atomic<pid_t> victim{0};
  auto q = request("long");
  auto call = std::async(std::launch::async, [&] {
    return client.call(q, reply, {.deadline = 20s, .progress = [&](double, const std::string& text) {
                                    pid_t none = 0;
                                    victim.compare_exchange_strong(none, std::stoi(text));
                                  }});
  });
  ASSERT_TRUE(eventually([&] { return victim != 0; }));
  (victim == first->pid() ? *first : *second).signal(SIGKILL);
  EXPECT_TRUE(call.get().ok());
  EXPECT_NE(reply.bytes(), static_cast<std::uint64_t>(victim));
}

TEST_P(VendorPairs, LongCallReportsProgressAndCanBeCancelled) {
  const auto other = peer("serve", "test/echo");
  const auto self = node();
  Client client(*self, "test/echo");
  msg::ExportReply reply;
  std::atomic<int> reports{0};
  std::atomic<double> furthest{0};
  const auto progress = [&](double fraction, const std::string&) {
    ++reports;
    furthest = fraction;
  };
  auto q = request("long");
  EXPECT_TRUE(client.call(q, reply, {.deadline = 10s, .progress = progress, .wait_for_server = 10s}).ok());
  EXPECT_GT(reports, 10);
  EXPECT_GT(furthest, 0.8);

  const auto begin = Clock::now();
  const auto result = client.call(q, reply, {.deadline = 10s, .cancelled = [&] { return seconds_since(begin) > 0.3; }});
  EXPECT_EQ(result.status, RpcStatus::cancelled);
  EXPECT_EQ(result.error_code, static_cast<int>(ErrorCode::cancelled)) << "the server confirmed it";
  EXPECT_LT(seconds_since(begin), 1.3);
}

TEST_P(VendorPairs, QosMismatchIsLoggedWithPeerTopicAndPolicy) {
  const std::string file = ::testing::TempDir() + "/mismatch-" + std::to_string(getpid()) + ".jsonl";
  log::configure({.service = "test", .file = file, .level = log::Level::info, .console = false});
  const auto self = node();
  Subscriber<msg::Cancel> in(*self, "mismatch", qos_stream(), [](const msg::Cancel&) {});
  const auto other = peer("best-effort");
  EXPECT_TRUE(eventually([&] { return self->mismatches() == 1; }));
  log::flush();
  const std::string text = read_file(file);
  log::configure({.service = "test", .file = "", .level = log::Level::info, .console = true});
  EXPECT_NE(text.find("\"topic\":\"mismatch\""), std::string::npos) << text;
  EXPECT_NE(text.find("\"policy\":\"reliability\""), std::string::npos) << text;
  EXPECT_NE(text.find("\"peer\":\"peer-best-effort\""), std::string::npos) << text;
  unlink(file.c_str());
}

TEST_P(VendorPairs, BadSamplesAreCountedAndGoodOnesGoOn) {
  const auto self = node();
  std::atomic<int> good_keyed{0}, good_unkeyed{0};
  Subscriber<msg::ServiceStatus> keyed(*self, "keyed", qos_stream(), [&](const auto&) { ++good_keyed; });
  Subscriber<msg::DigestRequest> unkeyed(*self, "unkeyed", qos_stream(), [&](const auto&) { ++good_unkeyed; });
  const auto other = peer("bad");
  EXPECT_TRUE(eventually([&] { return good_keyed > 5 && good_unkeyed > 5 && keyed.bad() > 5 && unkeyed.bad() > 5; }))
      << good_keyed << " " << good_unkeyed << " " << keyed.bad() << " " << unkeyed.bad();
  EXPECT_GE(self->bad_samples, 10U);
}

TEST_P(VendorPairs, ProcessFrozenLongerThanItsLeaseIsHeardAgain) {
  lease_ = 2000ms;
  const auto other = peer("beat");
  const auto self = node();
  std::atomic<int> beats{0};
  std::atomic<std::uint64_t> rejoins{0};
  Subscriber<msg::ServiceStatus> in(*self, "beat", qos_stream(1), [&](const msg::ServiceStatus& s) {
    ++beats;
    rejoins = s.bad_samples();
  });
  Client client(*self, "test/beat");
  ASSERT_TRUE(eventually([&] { return beats > 0 && client.servers() == 1; }));
  other->signal(SIGSTOP);
  ASSERT_TRUE(eventually([&] { return in.matched() == 0; })) << "the lease did not end";
  std::this_thread::sleep_for(500ms);
  other->signal(SIGCONT);
  const int before = beats;
  EXPECT_TRUE(eventually([&] { return beats > before + 20 && rejoins >= 1; })) << beats - before << " beats, " << rejoins << " rejoins";
  auto q = request("echo", "again");
  msg::ExportReply reply;
  EXPECT_TRUE(client.call(q, reply, {.deadline = 5s, .wait_for_server = 5s}).ok());
  EXPECT_EQ(reply.sha256().to_string(), "again");
  std::mutex mutex;
  std::multiset<std::string> kept;
  Subscriber<msg::ServiceStatus> late(*self, "state", qos_latest(4), [&](const auto& s) {
    const std::lock_guard lock(mutex);
    kept.insert(s.instance().to_string() + " " + s.detail().to_string());
  });
  EXPECT_TRUE(eventually([&] {
    const std::lock_guard lock(mutex);
    return kept.size() >= 2;
  })) << "transient-local samples outlive the rejoin";
  const std::lock_guard lock(mutex);
  EXPECT_EQ(kept, (std::multiset<std::string>{"kept new", "kept-too new"})) << "the last of each key alone";
}

INSTANTIATE_TEST_SUITE_P(, VendorPairs, testing::each_vendor_pair(), testing::pair_name);

}  // namespace
}  // namespace periplus::dds
