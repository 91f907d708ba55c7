// Planners of one domain, and a half known ball for them to plan on.
#pragma once

#include <string>
#include <vector>

#include "common/dds/node.h"
#include "common/dds/rpc.h"
#include "common/wire/object_publisher.h"
#include "idl/model.h"
#include "idl/nbv.h"
#include "integration-tests/harness/test_bench.h"

namespace periplus::harness {

class PlannerBench {
 public:
  explicit PlannerBench(const std::string& name);

  // One more, with one thread; `more` arguments. Waits until it answers. Throws Error(not_ready).
  Program& start(const char* vendor, std::vector<std::string> more = {});
  int planners() { return client_.servers(); }
  // The same each time; other instances may share it.
  msg::PlanViewRequest request(std::uint32_t evaluations = 1200) const;
  dds::RpcResult ask(msg::PlanViewRequest request, msg::PlanViewReply& reply, dds::CallOptions options = {});
  std::string logs() const { return bench_.logs(); }

 private:
  TestBench bench_;
  dds::RpcClient<msg::PlanViewRequest, msg::PlanViewReply> client_;
  dds::Publisher<msg::Environment> environments_;
  wire::ObjectPublisher objects_;
  msg::Environment environment_;
};

}  // namespace periplus::harness
