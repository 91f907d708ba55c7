// Topics of an RPC and the identity of a server instance.
#pragma once

#include <algorithm>
#include <string>

#include "common/dds/node.h"

namespace periplus::dds::detail {

inline std::string request_topic(const std::string& rpc) { return "rq/" + rpc; }
inline std::string reply_topic(const std::string& rpc) { return "rr/" + rpc; }
inline std::string progress_topic(const std::string& rpc) { return "rp/" + rpc; }
inline std::string cancel_topic(const std::string& rpc) { return "rc/" + rpc; }

// Progress and cancel: endpoints appear only when needed, so the last few samples wait for them.
inline Qos qos_rpc_side() { return {.transient_local = true, .depth = 8}; }

// The participant's GUID prefix: the same for the request reader and the reply writer of one server.
inline Guid instance_of(const Guid& endpoint) {
  Guid instance{};
  std::copy_n(endpoint.begin(), 12, instance.begin());
  return instance;
}

}  // namespace periplus::dds::detail
