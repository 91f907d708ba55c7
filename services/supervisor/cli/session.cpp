#include "services/supervisor/cli/session.h"

#include <signal.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "common/core/error.h"
#include "common/core/locate.h"
#include "services/supervisor/cli/background.h"
#include "services/supervisor/cli/launcher.h"
#include "services/supervisor/cli/shared_memory.h"

namespace periplus::supervisor::cli {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

// Participants find each other by announcements that repeat less and less often, so the last of eight may be late.
constexpr auto kLookAround = 2s, kLongestLook = 6s, kQuiet = 1s;
constexpr auto kReady = 30s;
// After this silence a service that keeps state is taken for lost: well over a heartbeat, under the ten seconds in which a
// command must have ended.
constexpr double kLost_s = 5.0;

std::atomic<int> interrupts{0};
constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

}  // namespace

Interrupts::Interrupts() {
  interrupts = 0;
  struct sigaction action {};
  action.sa_handler = [](int) { ++interrupts; };
  for (const int signal : kSignals) ::sigaction(signal, &action, nullptr);
}

Interrupts::~Interrupts() {
  for (const int signal : kSignals) ::signal(signal, SIG_DFL);
}

int Interrupts::count() { return interrupts; }

struct Session::Impl {
  Client client;
  std::unique_ptr<Launcher> launcher;
  std::unique_ptr<BackgroundRecord> record;
  std::map<std::string, Clock::time_point> heard;   // when each service was last known to be up
  std::set<std::string> lost;
  bool started = false;
  std::string refusal;   // why a service of ours refused its input
};

Session::Session() : impl_(std::make_unique<Impl>()) {
  const auto began = Clock::now();
  const bool is_kept = find_background(impl_->client.domain()).has_value();
  std::size_t count = 0;
  auto changed = began;
  while (Interrupts::count() == 0) {
    const auto rows = impl_->client.services();
    const auto now = Clock::now();
    if (rows.size() != count) changed = now;
    count = rows.size();
    if (awaited(rows).empty() && now - changed > 200ms) break;
    if (now - began > kLookAround && now - changed > kQuiet && !(is_kept && count == 0)) break;
    if (now - began > kLongestLook) break;
    std::this_thread::sleep_for(20ms);
  }
}

Session::~Session() {
  const bool owned = impl_->started;
  stop();
  impl_.reset();
  // Once more: what the client itself had mapped of processes that were killed, and may have still.
  if (owned) clean_shared_memory("/dev/shm", OwnMappings::unused);
}

Client& Session::client() { return impl_->client; }

bool Session::occupied() const {
  if (find_background(impl_->client.domain())) return true;
  const auto rows = impl_->client.services();
  return std::any_of(rows.begin(), rows.end(), [](const ServiceRow& row) { return row.age_s <= kSilent_s && row.state <= 2; });
}

void Session::start(const Task& task, const std::filesystem::path& logs) {
  impl_->started = true;
  impl_->launcher = std::make_unique<Launcher>(programs_of(task, executable_folder(), logs), logs);
  impl_->record = std::make_unique<BackgroundRecord>(impl_->client.domain(), logs.string());
  impl_->launcher->start();
}

bool Session::owns_services() const { return impl_->launcher != nullptr; }

void Session::wait_until_ready() {
  const auto end = Clock::now() + kReady;
  while (true) {
    const Looked looked = look_after();
    require(impl_->refusal.empty(), ErrorCode::bad_input, impl_->refusal);
    if (!looked.lost.empty()) throw Error(ErrorCode::supervisor_service_lost, looked.news.empty() ? looked.lost.front() + " is gone" : looked.news.back());
    const std::vector<std::string> missing = awaited(impl_->client.services());
    if (missing.empty()) return;
    if (Interrupts::count() > 0) throw Error(ErrorCode::cancelled, "interrupted while the services were starting");
    if (Clock::now() > end) {
      std::string text;
      for (const std::string& name : missing) text += (text.empty() ? "" : ", ") + name;
      throw Error(ErrorCode::supervisor_service_lost, "after 30 s still waiting for " + text + "; see their logs, or `periplus doctor`");
    }
    std::this_thread::sleep_for(50ms);
  }
}

Session::Looked Session::look_after() {
  Looked looked;
  if (impl_->launcher)
    for (const Launcher::Event& event : impl_->launcher->supervise()) {
      looked.news.push_back(event.text);
      if (event.kind == Launcher::Event::Kind::lost) impl_->lost.insert(event.service);
      if (event.refused) impl_->refusal = event.text;
    }
  // Services of other hosts are only known by their heartbeats; their good-bye is the end. Of our own the launcher tells the
  // end with its reason, so a good-bye only starts the time in which it must come.
  const auto now = Clock::now();
  std::set<std::string> alive;
  for (const ServiceRow& row : impl_->client.services()) {
    if (row.age_s > kLost_s || row.state > 2) continue;
    alive.insert(row.service);
    const auto at = now - std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(row.age_s));
    impl_->heard[row.service] = std::max(impl_->heard[row.service], at);
  }
  for (const auto& [service, last] : impl_->heard) {
    const bool may_be_ending = impl_->launcher && now - last <= std::chrono::duration<double>(kLost_s);
    if (!restarts(service) && !alive.contains(service) && !may_be_ending && impl_->lost.insert(service).second)
      looked.news.push_back(service + " is no longer heard");
  }
  looked.lost.assign(impl_->lost.begin(), impl_->lost.end());
  return looked;
}

void Session::stop(std::chrono::milliseconds grace) {
  if (impl_->launcher) impl_->launcher->stop(grace);
  impl_->launcher.reset();
  impl_->record.reset();
}

}  // namespace periplus::supervisor::cli
