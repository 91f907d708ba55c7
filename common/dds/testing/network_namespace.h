// Two networks of a test's own, as of two computers, and the cable between them, which the test may pull.
#pragma once

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

namespace periplus::dds::testing {

class NetworkPair {
 public:
  static constexpr char near_interface[] = "cable0", near_address[] = "10.99.0.1";
  static constexpr char far_interface[] = "cable1", far_address[] = "10.99.0.2";

  // Runs body(pair) on a thread in the near network. Threads and processes that it starts are there too. False, without
  // running it, where this process may not make network namespaces (it must be root) or this kernel has no veth.
  template <class Body>
  static bool run(Body body) {
    bool permitted = false;
    std::string failure;
    std::thread([&] {
      permitted = geteuid() == 0 && unshare(CLONE_NEWNET) == 0;
      if (!permitted) return;
      std::unique_ptr<NetworkPair> pair;
      try {
        pair.reset(new NetworkPair);
      } catch (const std::exception& error) {  // namespaces, but no cables
        std::fprintf(stderr, "%s\n", error.what());
        permitted = false;
        return;
      }
      try {
        body(*pair);
      } catch (const std::exception& error) {
        failure = error.what();
      }
    }).join();
    if (!failure.empty()) throw std::runtime_error(failure);
    return permitted;
  }

  ~NetworkPair() {
    close(near_);
    close(far_);
  }
  NetworkPair(const NetworkPair&) = delete;
  NetworkPair& operator=(const NetworkPair&) = delete;

  // Runs `make` on the same thread in the far network.
  template <class Make>
  auto on_far_side(Make make) const {
    struct Stay {
      Stay(int there, int back_to) : back(back_to) { enter(there); }
      ~Stay() { setns(back, CLONE_NEWNET); }
      int back;
    } const stay(far_, near_);
    return make();
  }

  // The near interface goes down or up; the far one loses or finds its carrier.
  static void set_link(bool up) { ip(std::string("link set ") + near_interface + (up ? " up" : " down")); }
  // Both interfaces stay up, and nothing arrives any more: frames go to a computer that is not there.
  void set_silent(bool silent) const {
    const auto neighbour = [&](const std::string& address, const std::string& device) {
      ip("neigh " + (silent ? "replace " + address + " lladdr 02:00:00:00:00:99 nud permanent" : "del " + address) + " dev " + device);
    };
    neighbour(far_address, near_interface);
    on_far_side([&] { neighbour(near_address, far_interface); });
  }

 private:
  NetworkPair() : near_(here()) {
    if (unshare(CLONE_NEWNET) != 0) throw std::runtime_error("no second network namespace");
    far_ = here();
    ip("link set lo up");
    enter(near_);
    ip("link set lo up");
    ip(std::string("link add ") + near_interface + " type veth peer name " + far_interface);
    ip(std::string("link set ") + far_interface + " netns /proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(far_));
    ip(std::string("addr add ") + near_address + "/24 dev " + near_interface);
    on_far_side([] {
      ip(std::string("addr add ") + far_address + "/24 dev " + far_interface);
      ip(std::string("link set ") + far_interface + " up");
    });
    set_link(true);
  }
  static void ip(const std::string& arguments) {
    if (std::system(("ip " + arguments).c_str()) != 0) throw std::runtime_error("ip " + arguments + " failed");
  }
  static int here() {
    const int fd = open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    if (fd < 0) throw std::runtime_error("no network namespace in /proc");
    return fd;
  }
  static void enter(int network) {
    if (setns(network, CLONE_NEWNET) != 0) throw std::runtime_error("cannot enter a network namespace");
  }

  int near_ = -1, far_ = -1;
};

}  // namespace periplus::dds::testing
