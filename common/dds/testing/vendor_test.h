// Fixtures of the tests that run on each vendor and on each pair of vendors.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/node.h"
#include "common/dds/testing/process.h"
#include "common/dds/testing/test_domain.h"

namespace periplus::dds::testing {

// One process with nodes of the vendor that is the test's parameter, in a domain of its own.
class VendorTest : public ::testing::TestWithParam<std::string> {
 protected:
  std::shared_ptr<Node> node(const std::string& partition = "") const {
    NodeOptions options;
    options.name = "test";
    options.vendor = GetParam();
    options.domain = domain_.id();
    options.partition = partition;
    return Node::create(options);
  }
  TestDomain domain_;
};
inline auto each_vendor() { return ::testing::Values("fastdds", "cyclonedds"); }

// Two processes: dds_peer on the first vendor of the pair, the test itself on the second.
class VendorPairTest : public ::testing::TestWithParam<std::pair<std::string, std::string>> {
 protected:
  std::unique_ptr<Process> peer(const std::string& mode, const std::string& argument = "") const {
    std::vector<std::string> arguments = {PERIPLUS_BIN_DIR "/dds_peer", GetParam().first, std::to_string(domain_.id()), std::to_string(lease_.count()), mode};
    if (!argument.empty()) arguments.push_back(argument);
    return std::make_unique<Process>(arguments, environment_);
  }
  std::shared_ptr<Node> node() const {
    NodeOptions options = options_;
    options.name = "test";
    options.vendor = GetParam().second;
    options.domain = domain_.id();
    options.participant_lease = lease_;
    return Node::create(options);
  }

  TestDomain domain_;
  std::chrono::milliseconds lease_{20000};
  NodeOptions options_;                   // of node()
  std::vector<std::string> environment_;  // of the peer: "NAME=value"
};
inline auto each_vendor_pair() {
  using Pair = std::pair<std::string, std::string>;
  return ::testing::Values(Pair("fastdds", "fastdds"), Pair("cyclonedds", "cyclonedds"), Pair("fastdds", "cyclonedds"), Pair("cyclonedds", "fastdds"));
}
inline std::string pair_name(const ::testing::TestParamInfo<std::pair<std::string, std::string>>& parameter) {
  return parameter.param.first + "_" + parameter.param.second;
}

}  // namespace periplus::dds::testing
