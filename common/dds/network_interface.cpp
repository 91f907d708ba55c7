#include "common/dds/network_interface.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <memory>
#include <optional>

#include "common/core/error.h"

namespace periplus::dds {
namespace {

std::optional<NetworkInterface> search(const std::string& interface, std::string* known) {
  if (interface == "any") return NetworkInterface{};
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return std::nullopt;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, freeifaddrs);
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET || !(entry->ifa_flags & IFF_UP)) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    inet_ntop(AF_INET, &address->sin_addr, text, sizeof text);
    if (interface == entry->ifa_name || interface == text) return NetworkInterface{text, (entry->ifa_flags & IFF_LOOPBACK) != 0};
    if (known) *known += (known->empty() ? "" : ", ") + std::string(entry->ifa_name) + " (" + text + ")";
  }
  return std::nullopt;
}

}  // namespace

NetworkInterface find_interface(const std::string& interface) {
  std::string known;
  if (auto found = search(interface, &known)) return *found;
  throw Error(ErrorCode::bad_input, "PERIPLUS_INTERFACE: no interface \"" + interface + "\" is up with an IPv4 address; there are " +
                                        (known.empty() ? "none" : known) + ", or \"any\"");
}

bool interface_is_up(const std::string& interface) { return search(interface, nullptr).has_value(); }

}  // namespace periplus::dds
