// What a server remembers of the calls of its clients, so that a duplicate of a request is answered and never run twice:
// for each client the calls that run and its last replies, bounded in number and bytes; a client that is silent for
// long is forgotten. Not thread-safe.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>

#include "common/dds/rpc.h"

namespace periplus::dds::detail {

struct Call {
  CallName name;
  std::shared_ptr<void> request, reply;
  std::size_t reply_bytes = 0;
  bool done = false;                      // `reply` is complete
  std::atomic<bool> cancelled{false};
  std::chrono::steady_clock::time_point received;
};

class CallWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;

  explicit CallWindow(const RpcServerOptions& options) : options_(options) {}

  // The call of that name if it runs or its reply is remembered, else nullptr.
  std::shared_ptr<Call> find(const CallName& name, Time now);
  void add(const std::shared_ptr<Call>& call, Time now);
  // Call once when the reply is complete; may forget older replies of the same client.
  void finish(const std::shared_ptr<Call>& call);
  // Forgets clients that were silent for the expiry and for whom nothing runs.
  void expire(Time now);
  // Every call that has no reply yet is told to stop.
  void cancel_all();

  std::size_t clients() const { return clients_.size(); }
  std::size_t replies() const;

 private:
  struct Client {
    Time heard;
    std::map<std::int64_t, std::shared_ptr<Call>> calls;
    std::deque<std::int64_t> finished;  // oldest first
    std::size_t bytes = 0;
  };
  RpcServerOptions options_;
  std::map<Guid, Client> clients_;
};

}  // namespace periplus::dds::detail
