#include "common/dds/rpc.h"

namespace periplus::dds {

const char* to_string(RpcStatus status) {
  switch (status) {
    case RpcStatus::ok: return "ok";
    case RpcStatus::no_server: return "no_server";
    case RpcStatus::server_lost: return "server_lost";
    case RpcStatus::timeout: return "timeout";
    case RpcStatus::cancelled: return "cancelled";
  }
  return "unknown";
}

void RpcResult::throw_if_failed(const std::string& rpc) const {
  switch (status) {
    case RpcStatus::ok:
      if (error_code != 0) throw Error(static_cast<ErrorCode>(error_code), error_message);
      return;
    case RpcStatus::no_server:
      throw Error(ErrorCode::supervisor_service_lost, rpc + ": nobody offers it (no_server); start its service, and check domain, interface and peers");
    case RpcStatus::server_lost:
      throw Error(ErrorCode::supervisor_service_lost, rpc + ": its server died during the call (server_lost) and no other took over; restart the service");
    case RpcStatus::timeout:
      throw Error(ErrorCode::supervisor_service_lost, rpc + ": no reply within the deadline (timeout); the service hangs or needs a longer deadline");
    case RpcStatus::cancelled: throw Error(ErrorCode::cancelled, rpc + ": cancelled by the caller");
  }
}

}  // namespace periplus::dds
