#include "common/dds/network_interface.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "common/core/error.h"
#include "common/core/log.h"

namespace periplus::dds {
namespace {

struct Listed {
  std::string name;
  NetworkInterface interface;
  bool running = false;
};

std::vector<Listed> list_interfaces() {
  std::vector<Listed> found;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return found;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, freeifaddrs);
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    inet_ntop(AF_INET, &address->sin_addr, text, sizeof text);
    // Running as well: the vendors bind to no interface without carrier, and would stay without network for good.
    found.push_back({entry->ifa_name, {text, (entry->ifa_flags & IFF_LOOPBACK) != 0}, (entry->ifa_flags & IFF_UP) && (entry->ifa_flags & IFF_RUNNING)});
  }
  return found;
}

std::optional<NetworkInterface> search(const std::string& interface, const std::vector<Listed>& all) {
  for (const Listed& one : all)
    if (one.running && (interface == one.name || interface == one.interface.address)) return one.interface;
  return std::nullopt;
}

}  // namespace

NetworkInterface find_interface(const std::string& interface) {
  if (interface == "any") return {};
  const std::vector<Listed> all = list_interfaces();
  if (const auto found = search(interface, all)) return *found;
  std::string known;
  for (const Listed& one : all)
    if (one.running) known += (known.empty() ? "" : ", ") + one.name + " (" + one.interface.address + ")";
  throw Error(ErrorCode::bad_input, "PERIPLUS_INTERFACE: no interface \"" + interface + "\" is up with an IPv4 address; there are " +
                                        (known.empty() ? "none" : known) + ", or \"any\"");
}

NetworkInterface wait_for_interface(const std::string& interface, std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  bool told = false;
  while (interface != "any" && if_nametoindex(interface.c_str()) != 0 && !interface_is_up(interface) && std::chrono::steady_clock::now() < end) {
    if (!told) log::info("waiting for the network interface to come up", {{"interface", interface}});
    told = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return find_interface(interface);
}

bool interface_is_up(const std::string& interface) {
  const std::vector<Listed> all = list_interfaces();
  if (interface != "any") return search(interface, all).has_value();
  bool has_other = false;
  for (const Listed& one : all) {
    if (one.interface.loopback) continue;
    if (one.running) return true;
    has_other = true;
  }
  return !has_other;
}

}  // namespace periplus::dds
