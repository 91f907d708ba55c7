// The services that a command works with: those that run on the domain already, or its own, started and looked after.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "services/supervisor/cli/client_service.h"
#include "services/supervisor/task.h"

namespace periplus::supervisor::cli {

// Counts SIGINT, SIGTERM and SIGHUP while it lives.
class Interrupts {
 public:
  Interrupts();
  ~Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  static int count();
};

class Session {
 public:
  // Joins the domain and looks around until nobody new is heard: 2 to 6 s.
  Session();
  ~Session();  // stops what it started

  Client& client();
  // Whether anyone is on the domain, or a keeper of this user is about to be.
  bool occupied() const;
  // Starts the task's services, with logs in `logs`.
  void start(const Task& task, const std::filesystem::path& logs);
  bool owns_services() const;
  // Waits until all eight are ready. Throws Error(supervisor_service_lost) that says what is awaited after 30 s, or at once
  // when one of them is lost; Error(bad_input) with its sentence when one of them refuses its input; Error(cancelled) after a
  // signal.
  void wait_until_ready();

  struct Looked {
    std::vector<std::string> news;       // for a person
    std::vector<std::string> lost;       // services that nobody will bring back
  };
  // To be called often.
  Looked look_after();
  void stop(std::chrono::milliseconds grace = std::chrono::seconds(5));

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::supervisor::cli
