// The network interface that a node binds to.
#pragma once

#include <chrono>
#include <string>

namespace periplus::dds {

struct NetworkInterface {
  std::string address;    // IPv4, dotted; empty for "any"
  bool loopback = false;
};

// `interface` is an interface's name ("lo", "eth0"), its IPv4 address, or "any". Throws Error(bad_input) naming those
// that exist if it is none of them, is down, or carries nothing (a cable that is out).
NetworkInterface find_interface(const std::string& interface);

// As above, but an interface that is there by name and not up yet, as while a computer boots, is waited for.
NetworkInterface wait_for_interface(const std::string& interface, std::chrono::milliseconds timeout);

// As find_interface, without the exception: false if it is not there or down. "any" is up while any interface but the
// loopback is, or where there is none but the loopback.
bool interface_is_up(const std::string& interface);

}  // namespace periplus::dds
