// A DDS domain of a test's own, so that tests on one machine never hear each other however they are run in parallel.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace periplus::dds::testing {

// Holds a domain in 1..101 (without 42, where people are) through a lock that ends with the process.
class TestDomain {
 public:
  TestDomain() {
    for (int i = 0; i < 101; ++i) {
      const int candidate = 1 + (static_cast<int>(getpid()) + i) % 101;
      if (candidate == 42) continue;
      const int fd = open(("/tmp/periplus-test-domain-" + std::to_string(candidate)).c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
      if (fd < 0) continue;
      if (flock(fd, LOCK_EX | LOCK_NB) == 0) {
        fd_ = fd;
        id_ = candidate;
        return;
      }
      close(fd);
    }
    throw std::runtime_error("no free DDS domain for a test; are 100 tests running?");
  }
  ~TestDomain() { close(fd_); }
  TestDomain(const TestDomain&) = delete;
  TestDomain& operator=(const TestDomain&) = delete;
  int id() const { return id_; }

 private:
  int fd_ = -1;
  int id_ = 0;
};

}  // namespace periplus::dds::testing
