#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/dds/endpoint_matching.h"
#include "common/dds/rpc.h"
#include "common/dds/rpc_names.h"
#include "idl/common.h"

namespace periplus::dds::detail {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kFirstResend{250};
constexpr milliseconds kResend{500};
constexpr milliseconds kPoll{50};
// On top of the 500 ms liveliness lease: a server starved of its processor for a moment is not lost.
constexpr milliseconds kSilence{700};
// A server that is discovered by half (one direction matched) is waited for, whatever the caller says.
constexpr milliseconds kHalfDiscovered{1000};
constexpr milliseconds kCancelConfirmation{1000};

}  // namespace

struct RpcClientEngine::Impl {
  struct Pending {
    std::optional<Guid> client;  // of the request as it was sent
    void* reply = nullptr;
    bool done = false;
    std::int32_t code = 0;
    std::string message;
  };
  struct Listener {
    std::mutex mutex;  // held while the caller's function runs, so that it never runs after the call returned
    std::function<void(double, const std::string&)> report;
  };

  // Where a call's reply and progress go, from its first request until it returns or throws.
  class Registration {
   public:
    Registration(Impl& owner, std::int64_t call_number, void* reply, const std::function<void(double, const std::string&)>& report)
        : impl(owner), number(call_number) {
      const std::lock_guard lock(impl.mutex);
      impl.pending[number].reply = reply;
      if (!report) return;
      listener->report = report;
      impl.listeners[number] = listener;
    }
    ~Registration() {
      {
        const std::lock_guard lock(impl.mutex);
        impl.pending.erase(number);
        impl.listeners.erase(number);
      }
      leave();
      const std::lock_guard lock(listener->mutex);
      listener->report = nullptr;
    }
    Registration(const Registration&) = delete;
    Registration& operator=(const Registration&) = delete;

    const std::optional<Guid>& target() const { return target_; }
    // Takes the instance with the fewest calls as the target; none if there are no candidates.
    void choose(const std::set<Guid>& candidates) { target_ = impl.choose(candidates); }
    void leave() {
      if (target_) impl.release(*target_);
      target_.reset();
    }

   private:
    Impl& impl;
    const std::int64_t number;
    const std::shared_ptr<Listener> listener = std::make_shared<Listener>();
    std::optional<Guid> target_;
  };

  Impl(Node& owner, const std::string& rpc, const RpcAccess& rpc_access)
      : node(owner),
        name(rpc),
        access(rpc_access),
        requests(owner.writer(request_topic(rpc), *rpc_access.request, qos_rpc())),
        replies(owner, reply_topic(rpc), *rpc_access.reply, qos_rpc(), [this](const void* reply) { on_reply(reply); }) {}

  void on_reply(const void* reply) {
    CallName call;
    std::int32_t code = 0;
    std::string message;
    access.get_reply_header(reply, call, code, message);
    const std::lock_guard lock(mutex);
    const auto found = pending.find(call.number);
    if (found == pending.end() || found->second.done || found->second.client != call.client) return;
    Pending& p = found->second;
    access.assign_reply(p.reply, reply);
    p.code = code;
    p.message = message;
    p.done = true;
    changed.notify_all();
  }

  void on_progress(const msg::Progress& report) {
    std::shared_ptr<Listener> listener;
    {
      const std::lock_guard lock(mutex);
      const auto found = listeners.find(report.number());
      const auto call = pending.find(report.number());
      if (found == listeners.end() || call == pending.end() || call->second.client != report.client().value()) return;
      listener = found->second;
    }
    const std::lock_guard lock(listener->mutex);
    if (listener->report) listener->report(report.fraction(), report.text().to_string());
  }

  // Instances that can take a request (matched both ways and alive); `half` if something of one is there.
  std::set<Guid> instances(bool* half = nullptr) {
    std::set<Guid> reading, out;
    for (const Guid& reader : requests->matched_readers()) reading.insert(instance_of(reader));
    bool alive_only = false;
    for (const Guid& writer : replies.reader().alive_writer_guids()) {
      const Guid instance = instance_of(writer);
      if (reading.contains(instance)) {
        out.insert(instance);
      } else {
        alive_only = true;
      }
    }
    if (half) *half = alive_only || !reading.empty();
    return out;
  }

  // The instance with the fewest calls of ours, in turn among equals.
  std::optional<Guid> choose(const std::set<Guid>& candidates) {
    const std::lock_guard lock(mutex);
    std::optional<Guid> best;
    int least = 0;
    const std::size_t first = candidates.empty() ? 0 : turn++ % candidates.size();
    std::vector<Guid> in_turn(candidates.begin(), candidates.end());
    std::rotate(in_turn.begin(), in_turn.begin() + static_cast<std::ptrdiff_t>(first), in_turn.end());
    for (const Guid& candidate : in_turn) {
      const auto busy = outstanding.find(candidate);
      const int calls = busy == outstanding.end() ? 0 : busy->second;
      if (!best || calls < least) {
        best = candidate;
        least = calls;
      }
    }
    if (best) ++outstanding[*best];
    return best;
  }
  void release(const Guid& instance) {
    const std::lock_guard lock(mutex);
    const auto busy = outstanding.find(instance);
    if (busy != outstanding.end() && --busy->second <= 0) outstanding.erase(busy);
  }

  void watch_progress() {
    const std::lock_guard lock(side_mutex);
    if (!progress) {
      progress = std::make_unique<Subscriber<msg::Progress>>(node, progress_topic(name), qos_rpc_side(),
                                                             [this](const msg::Progress& p) { on_progress(p); });
    }
  }
  void send_cancel(const Guid& client, std::int64_t number) {
    const std::lock_guard lock(side_mutex);
    if (!cancels) cancels = std::make_unique<Publisher<msg::Cancel>>(node, cancel_topic(name), qos_rpc_side());
    msg::Cancel cancel;
    cancel.client().value(client);
    cancel.number(number);
    cancels->publish(cancel);
  }

  RpcResult call(void* request, void* reply, const CallOptions& options);

  Node& node;
  const std::string name;
  const RpcAccess& access;
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::int64_t, Pending> pending;
  std::map<std::int64_t, std::shared_ptr<Listener>> listeners;
  std::map<Guid, int> outstanding;
  std::size_t turn = 0;
  std::atomic<std::int64_t> last_number{0};
  std::mutex side_mutex;
  std::unique_ptr<Publisher<msg::Cancel>> cancels;
  std::unique_ptr<Writer> requests;
  ReaderThread replies;
  std::unique_ptr<Subscriber<msg::Progress>> progress;
};

RpcResult RpcClientEngine::Impl::call(void* request, void* reply, const CallOptions& options) {
  const auto begin = Clock::now();
  const auto end = begin + options.deadline;
  const std::int64_t number = ++last_number;
  RpcResult result;
  Registration registered(*this, number, reply, options.progress);
  const std::optional<Guid>& target = registered.target();
  if (options.progress) watch_progress();

  bool sent_before = false;
  auto server_by = begin + options.wait_for_server;
  Clock::time_point resend_at{}, silent_since{}, next_poll{};
  std::optional<Clock::time_point> cancelled_at;
  CallName call{replies.reader().guid(), number, {}};

  const auto send = [&](Clock::time_point now, milliseconds next) {
    call.client = replies.reader().guid();  // another one if the node joined anew
    call.server = *target;
    {
      const std::lock_guard lock(mutex);
      pending[number].client = call.client;
    }
    access.set_request_header(request, call);
    requests->write(request);
    resend_at = now + next;
  };

  for (;;) {
    {
      std::unique_lock lock(mutex);
      Pending& mine = pending[number];
      if (target) changed.wait_until(lock, std::min({end, resend_at, next_poll}), [&] { return mine.done; });
      if (mine.done) {
        result.error_code = mine.code;
        result.error_message = mine.message;
        if (cancelled_at && mine.code == static_cast<std::int32_t>(ErrorCode::cancelled)) result.status = RpcStatus::cancelled;
        break;
      }
    }
    const auto now = Clock::now();
    if (now >= end) {
      result.status = RpcStatus::timeout;
      break;
    }
    if (now >= next_poll) {
      next_poll = now + kPoll;
      if (options.cancelled && !cancelled_at && options.cancelled()) cancelled_at = now;
      if (cancelled_at) {
        if (!target || now - *cancelled_at > kCancelConfirmation) {
          result.status = RpcStatus::cancelled;
          break;
        }
        send_cancel(call.client, number);
      }
    }
    bool half = false;
    std::set<Guid> there = instances(&half);
    if (options.only_on) std::erase_if(there, [&](const Guid& instance) { return instance != *options.only_on; });
    if (target) {
      const auto reading = requests->matched_readers();
      const bool matched = std::any_of(reading.begin(), reading.end(), [&](const Guid& r) { return instance_of(r) == *target; });
      if (there.contains(*target)) {
        silent_since = now;
      } else if (!matched || now - silent_since > kSilence) {
        log::warn("the server of a call was lost", {{"rpc", name}, {"instance", to_string(*target)}});
        registered.leave();
        server_by = now + options.wait_for_server;
        continue;
      }
      if (now >= resend_at) {
        ++result.resends;
        send(now, kResend);
      }
      continue;
    }
    registered.choose(there);
    if (target) {
      sent_before = true;
      silent_since = now;
      send(now, kFirstResend);
    } else if (now >= server_by && (sent_before || !half || now - begin > kHalfDiscovered)) {
      result.status = sent_before ? RpcStatus::server_lost : RpcStatus::no_server;
      break;
    } else {
      std::this_thread::sleep_for(milliseconds(5));
    }
  }
  return result;
}

RpcClientEngine::RpcClientEngine(Node& node, const std::string& name, const RpcAccess& access)
    : impl_(std::make_unique<Impl>(node, name, access)) {}

RpcClientEngine::~RpcClientEngine() = default;

RpcResult RpcClientEngine::call(void* request, void* reply, const CallOptions& options) { return impl_->call(request, reply, options); }

bool RpcClientEngine::wait_for_server(milliseconds timeout) {
  const auto end = Clock::now() + timeout;
  while (impl_->instances().empty()) {
    if (Clock::now() >= end) return false;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return true;
}

std::vector<Guid> RpcClientEngine::others() {
  std::set<Guid> there = impl_->instances();
  there.erase(instance_of(impl_->replies.reader().guid()));
  return {there.begin(), there.end()};
}

int RpcClientEngine::servers() { return static_cast<int>(impl_->instances().size()); }

}  // namespace periplus::dds::detail
