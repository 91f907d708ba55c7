#include "services/supervisor/cli/service_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "services/supervisor/cli/launcher.h"

namespace periplus::supervisor::cli {

std::string state_name(const ServiceRow& row) {
  if (row.age_s > kSilent_s) return "silent";
  switch (row.state) {
    case 0: return "starting";
    case 1: return "ready";
    case 2: return "degraded";
    case 3: return "stopping";
    case 4: return "stopped";
    default: return "unknown";
  }
}

std::string service_table(const std::vector<ServiceRow>& rows) {
  std::string text = fmt::format("{:<18} {:<9} {:<10} {:<16} {:>7} {:>9}  {}\n", "service", "state", "vendor", "host", "pid", "up [s]", "detail");
  std::vector<ServiceRow> sorted = rows;
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.instance < b.instance; });
  for (const ServiceRow& row : sorted) {
    std::string detail = row.detail;
    if (row.age_s > kSilent_s) detail = fmt::format("last heard {:.0f} s ago", row.age_s);
    if (row.bad_samples > 0) detail += fmt::format("{}{} bad samples", detail.empty() ? "" : "; ", row.bad_samples);
    text += fmt::format("{:<18} {:<9} {:<10} {:<16.16} {:>7} {:>9.0f}  {}\n", row.service, state_name(row), row.vendor, row.host, row.pid, row.uptime_s, detail);
  }
  bool first = true;
  for (const ServiceRow& row : sorted)
    for (const RpcRow& rpc : row.rpcs) {
      if (rpc.calls == 0) continue;  // latencies of nothing
      if (first) text += fmt::format("\n{:<26} {:>8} {:>7} {:>11} {:>10} {:>10} {:>10}\n", "call", "calls", "errors", "duplicates", "p50 [ms]", "p95 [ms]", "p99 [ms]");
      first = false;
      text += fmt::format("{:<26} {:>8} {:>7} {:>11} {:>10.1f} {:>10.1f} {:>10.1f}\n", rpc.rpc, rpc.calls, rpc.errors, rpc.duplicates, rpc.p50_ms, rpc.p95_ms,
                          rpc.p99_ms);
    }
  return text;
}

std::vector<std::string> awaited(const std::vector<ServiceRow>& rows) {
  std::vector<std::string> missing;
  for (const std::string& service : service_names()) {
    std::string why = "not there";
    bool is_ready = false;
    for (const ServiceRow& row : rows) {
      if (row.service != service || row.age_s > kSilent_s || row.state > 2) continue;
      is_ready = is_ready || row.state == 1 || row.state == 2;
      why = row.detail.empty() ? "starting" : row.detail;
    }
    if (!is_ready) missing.push_back(service + " (" + why + ")");
  }
  return missing;
}

}  // namespace periplus::supervisor::cli
