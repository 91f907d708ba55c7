// Who is on the domain and how they do, as tables for the terminal.
#pragma once

#include <string>
#include <vector>

namespace periplus::supervisor::cli {

struct RpcRow {
  std::string rpc;
  unsigned long long calls = 0, errors = 0, duplicates = 0;
  double p50_ms = 0, p95_ms = 0, p99_ms = 0;
};

struct ServiceRow {
  std::string instance, service, host, vendor, version, detail;
  int pid = 0;
  int state = 0;                // as ServiceStatus.state
  double uptime_s = 0;
  double age_s = 0;             // since it was last heard
  double clock_ahead_s = 0;     // of its clock against ours, as far as the delivery time lets one tell
  unsigned long long bad_samples = 0;
  std::vector<RpcRow> rpcs;
};

// A service that was not heard for longer is taken for dead [s]; heartbeats come every 0.5 s.
constexpr double kSilent_s = 3.0;

std::string state_name(const ServiceRow& row);
// One row a service, then one a remote call.
std::string service_table(const std::vector<ServiceRow>& rows);
// Services of service_names() that have no ready instance, with what they wait for: "vision_server (not there)".
std::vector<std::string> awaited(const std::vector<ServiceRow>& rows);

}  // namespace periplus::supervisor::cli
