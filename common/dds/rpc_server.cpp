#include <algorithm>
#include <condition_variable>
#include <deque>
#include <latch>
#include <list>
#include <mutex>
#include <thread>
#include <vector>

#include "common/core/log.h"
#include "common/dds/call_window.h"
#include "common/dds/codec_impl.h"
#include "common/dds/rpc.h"
#include "common/dds/rpc_names.h"
#include "idl/common.h"

namespace periplus::dds::detail {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kLatencies = 1024;      // calls behind the quantiles
constexpr std::size_t kLongestQueue = 1024;   // requests over it are dropped; the client sends them again
constexpr milliseconds kReplyPatience{5000};  // how long a reply waits for the client's reader to be matched
constexpr milliseconds kSignOfLife{1000};

}  // namespace

struct RpcServerEngine::Impl {
  Impl(Node& node, const std::string& rpc, const RpcAccess& rpc_access, std::function<void(const void*, void*, RpcContext&)> rpc_handler,
       const RpcServerOptions& options)
      : name(rpc),
        access(rpc_access),
        handler(std::move(rpc_handler)),
        window(options),
        progress(node, progress_topic(rpc), qos_rpc_side()),
        replies(node.writer(reply_topic(rpc), *rpc_access.reply, qos_rpc())) {
    cancels = std::make_unique<Subscriber<msg::Cancel>>(node, cancel_topic(rpc), qos_rpc_side(), [this](const msg::Cancel& c) { on_cancel(c); });
    requests = std::make_unique<ReaderThread>(node, request_topic(rpc), *access.request, qos_rpc(), [this](const void* q) { on_request(q); });
    request_reader = &requests->reader();
    started.count_down();
    for (int i = 0; i < std::max(1, options.threads); ++i) workers.emplace_back([this] { work(); });
    housekeeper = std::thread([this] { keep_house(); });
  }

  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stopping = true;
      window.cancel_all();
    }
    work_there.notify_all();
    house_call.notify_all();
    for (std::thread& worker : workers) worker.join();
    housekeeper.join();
    requests.reset();
    cancels.reset();
  }

  void on_request(const void* request) {
    started.wait();
    auto call = std::make_shared<Call>();
    access.get_request_header(request, call->name);
    if (call->name.server != Guid{} && call->name.server != instance_of(request_reader->guid())) return;
    call->received = Clock::now();
    const std::unique_lock lock(mutex);
    if (const auto known = window.find(call->name, call->received)) {
      ++duplicates;
      if (known->done) send(known);
      return;  // what still runs is answered when it is done
    }
    if (stopping || queue.size() >= kLongestQueue) return;
    call->request = {access.copy_request(request), access.request->destroy};
    window.add(call, call->received);
    queue.push_back(call);
    work_there.notify_one();
  }

  void on_cancel(const msg::Cancel& cancel) {
    const std::lock_guard lock(mutex);
    if (const auto call = window.find({cancel.client().value(), cancel.number(), {}}, Clock::now())) {
      call->cancelled = true;
      if (call->done) send(call);
    }
  }

  struct Context : RpcContext {
    Context(Impl& server, const Call& call_) : impl(server), call(call_) {}
    void progress(double fraction, const std::string& text) override {
      msg::Progress p;
      p.client().value(call.name.client);
      p.number(call.name.number);
      p.fraction(fraction);
      p.text(text);
      impl.progress.publish(p);
    }
    bool cancelled() const override { return call.cancelled; }
    Impl& impl;
    const Call& call;
  };

  void work() {
    std::unique_lock lock(mutex);
    for (;;) {
      work_there.wait(lock, [&] { return stopping || !queue.empty(); });
      if (stopping) return;
      const auto call = queue.front();
      queue.pop_front();
      lock.unlock();
      const std::int32_t code = run(*call);
      const double took_ms = std::chrono::duration<double, std::milli>(Clock::now() - call->received).count();
      lock.lock();
      ++calls;
      if (code != 0) ++errors;
      if (latencies_ms.size() < kLatencies) {
        latencies_ms.push_back(took_ms);
      } else {
        latencies_ms[calls % kLatencies] = took_ms;
      }
      window.finish(call);
      if (!stopping) send(call);  // one that our own end cut short is another instance's to answer
    }
  }

  std::int32_t run(Call& call) {
    call.reply = {access.reply->create(), access.reply->destroy};
    ErrorCode code = ErrorCode::ok;
    std::string message;
    try {
      Context context(*this, call);
      context.throw_if_cancelled();
      handler(call.request.get(), call.reply.get(), context);
    } catch (const Error& error) {
      code = error.code();
      message = error.what();
    } catch (const std::exception& error) {
      code = ErrorCode::internal;
      message = error.what();
    } catch (...) {
      code = ErrorCode::internal;
      message = "unknown exception";
    }
    if (code != ErrorCode::ok) call.reply = {access.reply->create(), access.reply->destroy};  // nothing half-made goes out
    if (code == ErrorCode::internal) log::error("a request failed: " + message, {{"rpc", name}});
    access.set_reply_header(call.reply.get(), call.name, static_cast<std::int32_t>(code), message);
    call.reply_bytes = access.reply->size(call.reply.get());
    return static_cast<std::int32_t>(code);
  }

  // A volatile sample written before the client's reader is matched would be lost, so an early reply waits. Needs `mutex`.
  void send(const std::shared_ptr<Call>& call) {
    unsent.push_back({call, Clock::now() + kReplyPatience});
    house_call.notify_one();
  }

  void keep_house() {
    // Once Cyclone DDS took a writer for silent (a server starved for longer than its lease, or one that it knew before it had
    // a reader), heartbeats do not bring it back, a sample does. This one is nobody's reply: calls are counted from one.
    const std::unique_ptr<void, void (*)(void*)> sign_of_life(access.reply->create(), access.reply->destroy);
    auto next_sign = Clock::now();
    std::unique_lock lock(mutex);
    while (!stopping) {
      if (Clock::now() >= next_sign) {
        lock.unlock();
        replies->write(sign_of_life.get());
        lock.lock();
        next_sign = Clock::now() + kSignOfLife;
      }
      const bool idle = unsent.empty();
      house_call.wait_for(lock, idle ? milliseconds(1000) : milliseconds(0), [&] { return stopping || !unsent.empty(); });
      window.expire(Clock::now());
      bool waiting = false;
      for (auto reply = unsent.begin(); reply != unsent.end();) {
        const auto call = reply->call;
        if (replies->matched(call->name.client)) {
          reply = unsent.erase(reply);
          lock.unlock();
          if (!replies->write(call->reply.get())) log::warn("a reply could not be written", {{"rpc", name}});
          lock.lock();
          break;  // the list may have changed meanwhile
        }
        if (Clock::now() > reply->until) {
          reply = unsent.erase(reply);
        } else {
          waiting = true;
          ++reply;
        }
      }
      if (waiting && !stopping) {
        lock.unlock();
        std::this_thread::sleep_for(milliseconds(2));
        lock.lock();
      }
    }
  }

  struct Unsent {
    std::shared_ptr<Call> call;
    Clock::time_point until;
  };

  const std::string name;
  const RpcAccess& access;
  const std::function<void(const void*, void*, RpcContext&)> handler;
  mutable std::mutex mutex;
  std::condition_variable work_there, house_call;
  bool stopping = false;
  CallWindow window;
  std::deque<std::shared_ptr<Call>> queue;
  std::list<Unsent> unsent;
  std::uint64_t calls = 0, errors = 0, duplicates = 0;
  std::vector<double> latencies_ms;
  std::latch started{1};
  Publisher<msg::Progress> progress;
  std::unique_ptr<Writer> replies;
  std::vector<std::thread> workers;
  std::thread housekeeper;
  std::unique_ptr<Subscriber<msg::Cancel>> cancels;
  std::unique_ptr<ReaderThread> requests;
  Reader* request_reader = nullptr;  // of `requests`; valid for its callbacks while `requests` is being taken down
};

RpcServerEngine::RpcServerEngine(Node& node, const std::string& name, const RpcAccess& access,
                                 std::function<void(const void*, void*, RpcContext&)> handler, const RpcServerOptions& options)
    : impl_(std::make_unique<Impl>(node, name, access, std::move(handler), options)) {}

RpcServerEngine::~RpcServerEngine() = default;

RpcStatistics RpcServerEngine::statistics() const {
  RpcStatistics s;
  const std::lock_guard lock(impl_->mutex);
  s.name = impl_->name;
  s.calls = impl_->calls;
  s.errors = impl_->errors;
  s.duplicates = impl_->duplicates;
  std::vector<double> sorted = impl_->latencies_ms;
  if (sorted.empty()) return s;
  std::sort(sorted.begin(), sorted.end());
  const auto quantile = [&](double q) { return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1) + 0.5)]; };
  s.p50_ms = quantile(0.50);
  s.p95_ms = quantile(0.95);
  s.p99_ms = quantile(0.99);
  return s;
}

}  // namespace periplus::dds::detail
