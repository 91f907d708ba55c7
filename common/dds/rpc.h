// Idempotent remote calls over two topics, rq/<name> and rr/<name>. A call is named by the GUID of the client's reply
// reader and a number; the client resends the same number after 250 ms, the server answers duplicates from a bounded
// window per client. Request and reply types carry `header` (common.idl).
//
//   dds::RpcServer<CaptureRequest, CaptureReply> server(*node, "vision/capture",
//       [&](const CaptureRequest& q, CaptureReply& r, dds::RpcContext& context) { ... });   // throw periplus::Error to refuse
//   dds::RpcClient<CaptureRequest, CaptureReply> client(*node, "vision/capture");
//   CaptureReply reply;
//   dds::RpcResult result = client.call(request, reply, {.deadline = 5s});
//   result.throw_if_failed("vision/capture");   // as periplus::Error: no_server, server_lost, timeout or the server's own
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/dds/node.h"

namespace periplus::dds {

enum class RpcStatus {
  ok,           // a reply came; its header may still carry the server's error code
  no_server,    // nobody offers it
  server_lost,  // the server that had the request died and no other took over
  timeout,      // the deadline passed
  cancelled,
};
const char* to_string(RpcStatus status);

struct RpcResult {
  RpcStatus status = RpcStatus::ok;
  std::int32_t error_code = 0;     // of the reply header
  std::string error_message;
  int resends = 0;
  bool ok() const { return status == RpcStatus::ok && error_code == 0; }
  // Error with the server's code and sentence, or supervisor_service_lost for no_server, server_lost and timeout, naming `rpc`.
  void throw_if_failed(const std::string& rpc) const;
};

struct CallOptions {
  std::chrono::milliseconds deadline{5000};
  // Called on another thread as the server reports progress.
  std::function<void(double fraction, const std::string& text)> progress = {};
  // Polled every 50 ms; true sends a cancel and ends the call with RpcStatus::cancelled once the server confirms or after 1 s.
  std::function<bool()> cancelled = {};
  // How long to wait for a server to appear (or appear again after one was lost: the request is then sent to the next).
  std::chrono::milliseconds wait_for_server{0};
  // Runs on this instance of others() and on no other: once it is lost, so is the call.
  std::optional<Guid> only_on = {};
};

// Given to a handler.
class RpcContext {
 public:
  virtual ~RpcContext() = default;
  virtual void progress(double fraction, const std::string& text) = 0;
  virtual bool cancelled() const = 0;
  void throw_if_cancelled() const {
    if (cancelled()) throw Error(ErrorCode::cancelled, "cancelled by the caller");
  }
};

struct RpcServerOptions {
  int threads = 1;                              // handlers that may run at once
  int window = 32;                              // replies remembered per client
  std::chrono::seconds expiry{120};             // a silent client's window is forgotten after this
};

// Calls, errors and latency quantiles of one server, over the last 1024 calls.
struct RpcStatistics {
  std::string name;
  std::uint64_t calls = 0, errors = 0, duplicates = 0;
  double p50_ms = 0, p95_ms = 0, p99_ms = 0;
};

namespace detail {
// Type-erased engines, in rpc.cpp.
struct CallName {
  Guid client{};             // of the client's reply reader
  std::int64_t number = 0;
  Guid server{};             // the instance that is to run it; of requests only
  bool operator==(const CallName&) const = default;
};
struct RpcAccess {  // how to reach the header of a type
  const Codec* request;
  const Codec* reply;
  void (*get_request_header)(const void* request, CallName& name);
  void (*set_request_header)(void* request, const CallName& name);
  void (*get_reply_header)(const void* reply, CallName& name, std::int32_t& code, std::string& message);
  void (*set_reply_header)(void* reply, const CallName& name, std::int32_t code, const std::string& message);
  void (*assign_reply)(void* to, const void* from);
  void* (*copy_request)(const void* request);
};
template <class Req, class Rep>
const RpcAccess& rpc_access();  // codec_impl.h

class RpcServerEngine {
 public:
  RpcServerEngine(Node&, const std::string& name, const RpcAccess&, std::function<void(const void*, void*, RpcContext&)>, const RpcServerOptions&);
  ~RpcServerEngine();
  RpcStatistics statistics() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

class RpcClientEngine {
 public:
  RpcClientEngine(Node&, const std::string& name, const RpcAccess&);
  ~RpcClientEngine();
  RpcResult call(void* request, void* reply, const CallOptions&);
  bool wait_for_server(std::chrono::milliseconds);
  int servers();
  std::vector<Guid> others();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
}  // namespace detail

template <class Req, class Rep>
class RpcServer {
 public:
  using Handler = std::function<void(const Req&, Rep&, RpcContext&)>;
  RpcServer(Node& node, const std::string& name, Handler handler, const RpcServerOptions& options = {})
      : engine_(node, name, detail::rpc_access<Req, Rep>(),
                [handler = std::move(handler)](const void* q, void* r, RpcContext& c) {
                  handler(*static_cast<const Req*>(q), *static_cast<Rep*>(r), c);
                },
                options) {}
  RpcStatistics statistics() const { return engine_.statistics(); }

 private:
  detail::RpcServerEngine engine_;
};

template <class Req, class Rep>
class RpcClient {
 public:
  RpcClient(Node& node, const std::string& name) : engine_(node, name, detail::rpc_access<Req, Rep>()) {}
  // Fills the request's header. Several threads may call at once. What `cancelled` throws comes through; the server goes on
  // then, and its reply is dropped.
  RpcResult call(Req& request, Rep& reply, const CallOptions& options = {}) { return engine_.call(&request, &reply, options); }
  bool wait_for_server(std::chrono::milliseconds timeout) { return engine_.wait_for_server(timeout); }
  int servers() { return engine_.servers(); }
  // The live instances that are not of this client's own node, in an order that is the same for all who ask.
  std::vector<Guid> others() { return engine_.others(); }

 private:
  detail::RpcClientEngine engine_;
};

}  // namespace periplus::dds
