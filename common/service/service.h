// A service's life: options from the command line, environment and YAML; logs; ready, health, heartbeats; metrics; SIGTERM.
//
//   int main(int argc, char** argv) {
//     return periplus::service::run(argc, argv, {.name = "vision_server", .summary = "cameras in; depth and features out"},
//       [](periplus::service::Service& service) {
//         VisionSettings settings = read_settings(service.configuration());      // typed; unknown keys are errors
//         if (service.check_only()) return;
//         auto vision = std::make_shared<VisionService>(service, settings);      // creates its RPC servers on service.node()
//         service.ready();
//         service.wait_until_stopped();
//       });
//   }
//
// Every program knows: --config FILE (laid over the default one, locate.h), --set key=value, --print-config, --check,
// --log-file FILE, --log-level L, --version, --help. Exit status 0; 2 for bad input (one sentence on standard error);
// 1 for anything else.
//
// While it lives, a service says how it is on periplus/service/status (every 500 ms and at each change, transient-local,
// keyed by instance; state 4 is its good-bye) and how its RPCs do on periplus/service/metrics (every second).
// OPENBLAS_NUM_THREADS, OMP_NUM_THREADS and LP_NUM_THREADS are set to 1 where the environment does not set them; the
// program begins anew for that, since OpenBLAS reads them while it is loaded.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/core/config.h"
#include "common/dds/node.h"
#include "common/dds/rpc.h"

namespace periplus::service {

// Options of a program's own, on its command line and in its --help. The variables hold the defaults.
class Options {
 public:
  virtual ~Options() = default;
  virtual void text(const std::string& name, std::string& value, const std::string& help) = 0;   // --name TEXT
  virtual void flag(const std::string& name, bool& value, const std::string& help) = 0;          // --name
};

struct Description {
  std::string name;     // "vision_server"
  std::string summary;
  // Adds options of the program's own; may be empty.
  std::function<void(Options&)> options;
};

class Service {
 public:
  virtual ~Service() = default;

  virtual dds::Node& node() = 0;                       // created on first use
  // This instance's name in its heartbeats, unlike that of any other; empty before it joined.
  virtual std::string instance() const { return {}; }
  virtual const config::Node& configuration() const = 0;
  virtual bool check_only() const = 0;                 // --check or --print-config: read the configuration, then return

  // Heartbeats say `starting` with what is awaited until ready() is called.
  virtual void waiting_for(const std::string& what) = 0;
  virtual void ready() = 0;
  virtual void degraded(const std::string& why) = 0;

  virtual bool stopping() const = 0;
  virtual void stop() = 0;                             // as SIGTERM
  // Returns once stopped, when the service has let go of the servers made by serve(). One that the caller kept goes on until
  // the caller lets go of it too: what its handler uses must outlive it.
  virtual void wait_until_stopped() = 0;
  // True once stopped, as above; false after the time.
  virtual bool wait_until_stopped(std::chrono::milliseconds) = 0;

  // RPC statistics to be published on periplus/service/metrics.
  virtual void add_statistics(std::function<dds::RpcStatistics()>) = 0;

  // An RPC server that is part of the metrics.
  template <class Req, class Rep>
  std::shared_ptr<dds::RpcServer<Req, Rep>> serve(const std::string& rpc, typename dds::RpcServer<Req, Rep>::Handler handler,
                                                  const dds::RpcServerOptions& options = {}) {
    auto server = std::make_shared<dds::RpcServer<Req, Rep>>(node(), rpc, std::move(handler), options);
    add_statistics([server] { return server->statistics(); });
    return server;
  }
};

int run(int argc, char** argv, const Description& description, const std::function<void(Service&)>& body);

}  // namespace periplus::service
