// The network interface that a node binds to.
#pragma once

#include <string>

namespace periplus::dds {

struct NetworkInterface {
  std::string address;    // IPv4, dotted; empty for "any"
  bool loopback = false;
};

// `interface` is an interface's name ("lo", "eth0"), its IPv4 address, or "any". Throws Error(bad_input) naming those
// that exist if it is none of them, or is down.
NetworkInterface find_interface(const std::string& interface);

// As find_interface, without the exception: false if it is not there or down.
bool interface_is_up(const std::string& interface);

}  // namespace periplus::dds
