#include "common/service/other_instances.h"

#include <algorithm>
#include <chrono>

#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/service/service.h"
#include "idl/common.h"

namespace periplus::service {

namespace {
constexpr std::uint8_t kStarting = 0, kStopping = 3;
constexpr std::size_t kMostInstances = 64;
}  // namespace

void OtherInstances::heard(const std::string& instance, std::uint8_t state) {
  if (instance == own_) return;
  const std::lock_guard lock(mutex_);
  if (state >= kStopping)
    states_.erase(instance);
  else if (states_.size() < kMostInstances || states_.contains(instance))
    states_[instance] = state;
}

std::optional<std::string> OtherInstances::stronger() const {
  const std::lock_guard lock(mutex_);
  for (const auto& [instance, state] : states_)
    if (state != kStarting || instance < own_) return instance;
  return std::nullopt;
}

void require_alone(Service& service, const std::string& name, ErrorCode code) {
  dds::Node& node = service.node();  // whoever has not joined has no name yet
  OtherInstances others(service.instance());
  const dds::Subscriber<msg::ServiceStatus> statuses(node, "periplus/service/status", dds::qos_latest(1), [&](const msg::ServiceStatus& s) {
    if (s.service().to_string() == name) others.heard(s.instance().to_string(), s.state());
  });
  std::string spoken = name;
  std::replace(spoken.begin(), spoken.end(), '_', ' ');
  service.waiting_for("signs of another " + spoken + " (1.5 s)");
  service.wait_until_stopped(std::chrono::milliseconds(1500));
  if (const auto other = others.stronger())
    throw_error(code, "another " + spoken + " (" + *other +
                          ") is already on this domain; stop it with `periplus down`, or choose another domain with PERIPLUS_DOMAIN");
}

}  // namespace periplus::service
