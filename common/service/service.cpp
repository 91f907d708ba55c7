#include "common/service/service.h"

#include <signal.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <condition_variable>
#include <cstdio>
#include <iostream>
#include <mutex>
#include <random>
#include <thread>

#include "common/core/clock.h"
#include "common/core/error.h"
#include "common/core/log.h"
#include "common/core/version.h"
#include "common/dds/codec_impl.h"
#include "common/core/locate.h"
#include "idl/common.h"

namespace periplus::service {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kHeartbeat = 500ms;
constexpr int kBeatsPerMetrics = 2;
enum State : std::uint8_t { starting = 0, ready_state = 1, degraded_state = 2, stopping_state = 3, stopped = 4 };

std::string clipped(const std::string& text, std::size_t length) { return text.substr(0, length); }

std::string host_name() {
  char name[65] = {};
  if (::gethostname(name, sizeof name - 1) != 0 || !*name) return "host";
  return name;
}

// Tells apart what a host's name and a process' number do not: containers may share both.
std::string random_suffix() {
  char text[9];
  std::snprintf(text, sizeof text, "%08x", std::random_device{}());
  return text;
}

// Numerical libraries must neither fight for the cores nor change results with their number. OpenBLAS reads its variable
// while the program is loaded, so the program begins anew once they are set.
void pin_library_threads(char** argv) {
  bool changed = false;
  for (const char* name : {"OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "LP_NUM_THREADS"}) {
    if (::getenv(name)) continue;
    ::setenv(name, "1", 0);
    changed = true;
  }
  if (changed) ::execv("/proc/self/exe", argv);  // where that fails, the variables that are read later still count
}

class ServiceImpl final : public Service {
 public:
  ServiceImpl(std::string name, config::Node configuration, bool check_only)
      : name_(std::move(name)), configuration_(std::move(configuration)), check_only_(check_only) {}

  ~ServiceImpl() override { close(); }

  dds::Node& node() override {
    const std::lock_guard lock(node_mutex_);
    if (!node_) {
      std::string dashed = name_;
      for (char& c : dashed)
        if (c == '_') c = '-';
      node_ = dds::Node::create(dds::NodeOptions::from_environment(dashed));
      instance_ = clipped(dashed + "-" + clipped(host_name(), 40) + "-" + std::to_string(::getpid()) + "-" + random_suffix(), 96);
      status_ = std::make_unique<dds::Publisher<msg::ServiceStatus>>(*node_, "periplus/service/status", dds::qos_latest());
      metrics_ = std::make_unique<dds::Publisher<msg::ServiceMetrics>>(*node_, "periplus/service/metrics", dds::qos_latest());
      heart_ = std::thread([this] { beat(); });
      log::info("joined", {{"vendor", node_->options().vendor}, {"domain", std::to_string(node_->options().domain)}, {"instance", instance_}});
    }
    return *node_;
  }

  std::string instance() const override {
    const std::lock_guard lock(node_mutex_);
    return instance_;
  }
  const config::Node& configuration() const override { return configuration_; }
  bool check_only() const override { return check_only_; }

  void waiting_for(const std::string& what) override {
    const std::lock_guard lock(mutex_);
    if (state_ != starting) return;
    if (detail_ != "waiting for " + what) log::info("waiting", {{"for", what}});
    detail_ = "waiting for " + what;
    changed_ = true;
    condition_.notify_all();
  }
  void ready() override {
    node();  // a service that is ready is one that can be seen
    change(ready_state, "");
    log::info("ready");
  }
  void degraded(const std::string& why) override {
    change(degraded_state, why);
    log::warn("degraded", {{"why", why}});
  }

  bool stopping() const override {
    const std::lock_guard lock(mutex_);
    return stopping_;
  }
  void stop() override {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    stopping_ = true;
    state_ = stopping_state;
    detail_.clear();
    changed_ = true;
    condition_.notify_all();
  }
  void wait_until_stopped() override {
    {
      std::unique_lock lock(mutex_);
      condition_.wait(lock, [this] { return stopping_; });
    }
    drop_servers();
  }
  bool wait_until_stopped(std::chrono::milliseconds timeout) override {
    {
      std::unique_lock lock(mutex_);
      if (!condition_.wait_for(lock, timeout, [this] { return stopping_; })) return false;
    }
    drop_servers();
    return true;
  }

  void add_statistics(std::function<dds::RpcStatistics()> source) override {
    const std::lock_guard lock(statistics_mutex_);
    statistics_.push_back(std::move(source));
  }

  // Says good-bye and leaves the bus.
  void close() {
    stop();
    drop_servers();
    const std::lock_guard node_lock(node_mutex_);
    if (!node_) return;
    {
      const std::lock_guard lock(mutex_);
      state_ = stopped;
      closed_ = true;
      condition_.notify_all();
    }
    heart_.join();
    metrics_.reset();
    status_.reset();
    node_.reset();
  }

 private:
  void change(State state, const std::string& detail) {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    state_ = state;
    detail_ = detail;
    changed_ = true;
    condition_.notify_all();
  }

  // Handlers use what the body made: they end before the body's objects do.
  void drop_servers() {
    std::vector<std::function<dds::RpcStatistics()>> dropped;  // outlives the lock: a server joins its handlers
    const std::lock_guard lock(statistics_mutex_);
    dropped.swap(statistics_);
  }

  void beat() {
    for (int count = 0;; ++count) {
      bool last = false;
      {
        std::unique_lock lock(mutex_);
        if (count > 0) condition_.wait_for(lock, kHeartbeat, [this] { return changed_ || closed_; });
        changed_ = false;
        last = closed_;
      }
      publish_status();
      if (last) {
        // The tombstone is the only sign of a clean end that both vendors carry alike: give it a moment to leave.
        std::this_thread::sleep_for(50ms);
        return;
      }
      if (count % kBeatsPerMetrics == 0) publish_metrics();
    }
  }

  void publish_status() {
    msg::ServiceStatus status;
    status.instance(instance_);
    status.service(clipped(name_, 32));
    status.host(clipped(host_name(), 64));
    status.pid(static_cast<std::uint32_t>(::getpid()));
    status.vendor(clipped(node_->options().vendor, 16));
    status.version(clipped(version(), 32));
    {
      const std::lock_guard lock(mutex_);
      status.state(state_);
      status.detail(clipped(detail_, 256));
    }
    status.wall_time_ns(wall_time_ns());
    status.uptime_s(std::chrono::duration<double>(Clock::now() - begin_).count());
    status.bad_samples(node_->bad_samples.load());
    status_->publish(status);
  }

  void publish_metrics() {
    msg::ServiceMetrics metrics;
    metrics.instance(instance_);
    {
      const std::lock_guard lock(statistics_mutex_);
      for (const auto& source : statistics_) {
        if (metrics.rpcs().size() == 64) break;
        const dds::RpcStatistics s = source();
        msg::RpcMetrics m;
        m.rpc(clipped(s.name, 64));
        m.calls(s.calls);
        m.errors(s.errors);
        m.duplicates(s.duplicates);
        m.p50_ms(s.p50_ms);
        m.p95_ms(s.p95_ms);
        m.p99_ms(s.p99_ms);
        metrics.rpcs().push_back(m);
      }
    }
    metrics_->publish(metrics);
  }

  const std::string name_;
  const config::Node configuration_;
  const bool check_only_;
  const Clock::time_point begin_ = Clock::now();
  std::string instance_;

  mutable std::mutex mutex_;
  std::condition_variable condition_;
  State state_ = starting;
  std::string detail_;
  bool stopping_ = false, changed_ = false, closed_ = false;

  std::mutex statistics_mutex_;
  std::vector<std::function<dds::RpcStatistics()>> statistics_;

  mutable std::mutex node_mutex_;
  std::shared_ptr<dds::Node> node_;
  std::unique_ptr<dds::Publisher<msg::ServiceStatus>> status_;
  std::unique_ptr<dds::Publisher<msg::ServiceMetrics>> metrics_;
  std::thread heart_;
};

// SIGTERM and SIGINT become Service::stop(); the second one ends the process at once.
class Signals {
 public:
  explicit Signals(Service& service) {
    sigemptyset(&set_);
    sigaddset(&set_, SIGTERM);
    sigaddset(&set_, SIGINT);
    pthread_sigmask(SIG_BLOCK, &set_, &before_);  // before any other thread of the process begins
    thread_ = std::thread([this, &service] {
      const timespec patience{0, 100'000'000};
      int seen = 0;
      while (!done_) {
        const int signal = sigtimedwait(&set_, nullptr, &patience);
        if (signal <= 0) continue;
        if (++seen > 1) ::_exit(128 + signal);
        log::info("stopping", {{"signal", signal == SIGTERM ? "SIGTERM" : "SIGINT"}});
        service.stop();
      }
    });
  }
  ~Signals() {
    done_ = true;
    if (thread_.joinable()) thread_.join();
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }

 private:
  sigset_t set_{}, before_{};
  std::atomic<bool> done_{false};
  std::thread thread_;
};

bool is_bad_input(ErrorCode code) {
  switch (code) {
    case ErrorCode::bad_input:
    case ErrorCode::bad_size:
    case ErrorCode::not_finite:
    case ErrorCode::unknown_id:
    case ErrorCode::io:
    case ErrorCode::sim_scene_bad:
    case ErrorCode::supervisor_busy:
    case ErrorCode::supervisor_bad_task: return true;
    default: return false;
  }
}

struct Arguments {
  std::string config_file, log_file, log_level = "info";
  std::vector<std::string> overrides;
  bool print_config = false, check = false;
};

config::Node read_configuration(const std::string& name, const Arguments& arguments) {
  config::Node root;
  const std::filesystem::path standard = default_configuration(name);
  if (!standard.empty()) root = config::load_file(standard);
  if (!arguments.config_file.empty()) config::overlay(root, config::load_file(arguments.config_file));
  for (const std::string& text : arguments.overrides) {
    const std::size_t equals = text.find('=');
    require(equals != std::string::npos && equals > 0, ErrorCode::bad_input, "--set " + text + ": write --set section.key=value");
    config::set(root, text.substr(0, equals), text.substr(equals + 1));
  }
  return root;
}

log::Level level_of(const std::string& name) {
  if (name == "trace") return log::Level::trace;
  if (name == "debug") return log::Level::debug;
  if (name == "warn") return log::Level::warn;
  if (name == "error") return log::Level::error;
  return log::Level::info;
}

// Where the log does not reach the terminal, the person there gets the sentence all the same.
int fail(const std::string& name, const std::exception& e, bool log_on_terminal, int status) {
  log::error(e.what());
  log::flush();
  if (!log_on_terminal) std::cerr << name << ": " << e.what() << std::endl;
  return status;
}

}  // namespace

namespace {
class CommandLine : public Options {
 public:
  explicit CommandLine(CLI::App& app) : app_(app) {}
  void text(const std::string& name, std::string& value, const std::string& help) override { app_.add_option(name, value, help)->capture_default_str(); }
  void flag(const std::string& name, bool& value, const std::string& help) override { app_.add_flag(name, value, help); }

 private:
  CLI::App& app_;
};
}  // namespace

int run(int argc, char** argv, const Description& description, const std::function<void(Service&)>& body) {
  pin_library_threads(argv);

  Arguments arguments;
  CLI::App app(description.name + ": " + description.summary);
  app.add_option("--config", arguments.config_file, "YAML file laid over the default configuration");
  app.add_option("--set", arguments.overrides, "one parameter: section.key=value; may be repeated")->take_all()->allow_extra_args(false);
  app.add_flag("--print-config", arguments.print_config, "print the configuration that would be used, and end");
  app.add_flag("--check", arguments.check, "read and check the configuration, and end");
  app.add_option("--log-file", arguments.log_file, "append structured log lines (JSON) to this file");
  app.add_option("--log-level", arguments.log_level, "trace, debug, info, warn or error")
      ->check(CLI::IsMember({"trace", "debug", "info", "warn", "error"}));
  app.set_version_flag("--version", description.name + " " + version());
  if (description.options) {
    CommandLine options(app);
    description.options(options);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }

  const bool check_only = arguments.check || arguments.print_config;
  const bool log_on_terminal = arguments.log_file.empty() && !check_only;
  try {
    log::configure(
        {.service = description.name, .file = arguments.log_file, .level = level_of(arguments.log_level), .console = log_on_terminal});
    ServiceImpl service(description.name, read_configuration(description.name, arguments), check_only);
    Signals signals(service);  // ends before the service that it stops
    body(service);
    if (arguments.print_config) {
      std::cout << service.configuration().text();
    } else if (arguments.check) {
      std::cout << description.name << ": the configuration is good\n";
    }
    service.close();
    if (!check_only) log::info("stopped");
    log::flush();
    return 0;
  } catch (const Error& e) {
    return fail(description.name, e, log_on_terminal, is_bad_input(e.code()) ? 2 : 1);
  } catch (const std::exception& e) {
    return fail(description.name, e, log_on_terminal, 1);
  }
}

}  // namespace periplus::service
