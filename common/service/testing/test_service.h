// A service in a test's own process and DDS domain, without heartbeats, configuration file or signals: what *_service.cpp needs
// to be asked over the bus. It lives as long as the object.
#pragma once

#include <memory>
#include <string>

#include "common/dds/testing/test_domain.h"
#include "common/service/service.h"

namespace periplus::service::testing {

class TestService : public Service {
 public:
  explicit TestService(const std::string& name) {
    dds::NodeOptions options = dds::NodeOptions::from_environment(name);
    options.domain = domain_.id();
    node_ = dds::Node::create(options);
  }
  dds::Node& node() override { return *node_; }
  const config::Node& configuration() const override { return configuration_; }
  bool check_only() const override { return false; }
  void waiting_for(const std::string&) override {}
  void ready() override {}
  void degraded(const std::string&) override {}
  bool stopping() const override { return false; }
  void stop() override {}
  void wait_until_stopped() override {}
  bool wait_until_stopped(std::chrono::milliseconds) override { return true; }
  void add_statistics(std::function<dds::RpcStatistics()>) override {}

 private:
  const dds::testing::TestDomain domain_;
  std::shared_ptr<dds::Node> node_;
  config::Node configuration_;
};

}  // namespace periplus::service::testing
