#include "services/supervisor/cli/service_table.h"

#include <gtest/gtest.h>

#include "services/supervisor/cli/launcher.h"

namespace periplus::supervisor::cli {
namespace {

std::vector<ServiceRow> all_ready() {
  std::vector<ServiceRow> rows;
  for (const std::string& service : service_names()) {
    ServiceRow row;
    row.service = service;
    row.instance = service + "-host-1";
    row.state = 1;
    rows.push_back(row);
  }
  return rows;
}

TEST(ServiceTable, NothingIsAwaitedWhenAllAreReady) { EXPECT_TRUE(awaited(all_ready()).empty()); }

TEST(ServiceTable, SaysWhatIsAwaitedAndWhy) {
  auto rows = all_ready();
  rows[1].state = 0;
  rows[1].detail = "waiting for the environment";
  rows[2].age_s = 10;
  EXPECT_EQ(awaited(rows), (std::vector<std::string>{"vision_server (waiting for the environment)", "model_server (not there)"}));
  rows.push_back(rows[2]);  // a second instance, alive
  rows.back().age_s = 0;
  EXPECT_EQ(awaited(rows).size(), 1u);
  EXPECT_EQ(awaited({}).size(), 8u);
}

TEST(ServiceTable, ShowsStatesAndCalls) {
  auto rows = all_ready();
  rows[0].age_s = 10;
  rows[0].bad_samples = 3;
  rows[4].rpcs = {{.rpc = "posture/generate", .calls = 12, .errors = 1, .duplicates = 0, .p50_ms = 81.26, .p95_ms = 90, .p99_ms = 95}};
  const std::string text = service_table(rows);
  EXPECT_NE(text.find("silent"), std::string::npos) << text;
  EXPECT_NE(text.find("last heard 10 s ago; 3 bad samples"), std::string::npos) << text;
  EXPECT_NE(text.find("posture/generate                 12       1           0       81.3"), std::string::npos) << text;
}

}  // namespace
}  // namespace periplus::supervisor::cli
