#include "services/supervisor/write_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <vector>

namespace periplus::supervisor {
namespace {

TEST(WriteQueue, KeepsTheOrderAndDoesWhatIsLeft) {
  std::vector<int> done;
  {
    WriteQueue queue;
    for (int i = 0; i < 500; ++i) queue.add([&done, i] { done.push_back(i); });
    queue.flush();
    ASSERT_EQ(done.size(), 500u);
    queue.add([&done] { done.push_back(500); });
  }
  ASSERT_EQ(done.size(), 501u);
  for (int i = 0; i <= 500; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(WriteQueue, DoesNotHoldItsCallerUp) {
  std::atomic<bool> may_end{false};
  bool ended = false;
  WriteQueue queue;
  queue.add([&] {
    may_end.wait(false);
    ended = true;
  });
  EXPECT_FALSE(ended);  // add() came back while the job waits for us
  may_end = true;
  may_end.notify_all();
  queue.flush();
  EXPECT_TRUE(ended);
}

TEST(WriteQueue, TheFirstFailureReachesTheCallerOnce) {
  WriteQueue queue;
  int after = 0;
  queue.add([] { throw std::runtime_error("disk full"); });
  try {
    queue.flush();
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_STREQ(e.what(), "disk full");
  }
  queue.add([&] { ++after; });
  EXPECT_NO_THROW(queue.flush());
  EXPECT_EQ(after, 1);
}

}  // namespace
}  // namespace periplus::supervisor
