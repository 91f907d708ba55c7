#include "services/supervisor/cli/client_service.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <set>

#include "common/core/clock.h"
#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/dds/rpc.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_wire.h"
#include "idl/model.h"
#include "idl/supervisor.h"

namespace periplus::supervisor::cli {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t kMostEvents = 4096;
constexpr std::size_t kMostInstances = 256;

// Texts of strangers must not drive the terminal.
std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return text;
}

dds::CallOptions patient(std::chrono::milliseconds deadline) {
  dds::CallOptions options;
  options.deadline = deadline;
  options.wait_for_server = 3s;
  return options;
}

}  // namespace

struct Client::Impl {
  struct Heard {
    ServiceRow row;
    Clock::time_point at;
  };

  Impl() : node(dds::Node::create(dds::NodeOptions::from_environment("periplus"))) {}

  void take(const msg::ServiceStatus& s) {
    const std::lock_guard lock(mutex);
    const std::string instance = printable(s.instance().to_string());
    if (s.state() >= 4) {
      heard.erase(instance);
      return;
    }
    if (!heard.contains(instance) && heard.size() >= kMostInstances) return;
    const double ahead = static_cast<double>(s.wall_time_ns() - wall_time_ns()) * 1e-9;
    const bool first = !heard.contains(instance);
    Heard& h = heard[instance];
    // Delivery makes a clock seem late, at times by much (the first sample is a kept one): the least late one tells.
    h.row.clock_ahead_s = first ? ahead : std::max(h.row.clock_ahead_s, ahead);
    h.at = Clock::now();
    h.row.instance = instance;
    h.row.service = printable(s.service().to_string());
    h.row.host = printable(s.host().to_string());
    h.row.vendor = printable(s.vendor().to_string());
    h.row.version = printable(s.version().to_string());
    h.row.detail = printable(s.detail().to_string());
    h.row.pid = static_cast<int>(s.pid());
    h.row.state = s.state();
    h.row.uptime_s = s.uptime_s();
    h.row.bad_samples = s.bad_samples();
  }

  void take(const msg::ServiceMetrics& m) {
    const std::lock_guard lock(mutex);
    const std::string instance = printable(m.instance().to_string());
    if (!metrics.contains(instance) && metrics.size() >= kMostInstances) return;
    std::vector<RpcRow>& rows = metrics[instance];
    rows.clear();
    for (const msg::RpcMetrics& r : m.rpcs())
      rows.push_back({printable(r.rpc().to_string()), r.calls(), r.errors(), r.duplicates(), r.p50_ms(), r.p95_ms(), r.p99_ms()});
  }

  void take(const msg::RunEvent& e) {
    RunEvent event;
    event.run_id = e.run_id().to_string();
    event.number = e.number();
    event.kind = e.kind().to_string();
    event.state = printable(e.state().to_string());
    event.cause = printable(e.cause().to_string());
    event.look = e.look();
    event.wall_time_ns = e.wall_time_ns();
    for (const msg::NamedNumber& n : e.numbers()) event.numbers[n.name().to_string()] = n.value();
    event.exit_status = e.exit_status();
    event.run_folder = printable(e.run_folder().to_string());
    event.text = printable(e.text().to_string());
    const std::lock_guard lock(mutex);
    if (events.size() >= kMostEvents) events.pop_front();
    events.push_back(std::move(event));
  }

  mutable std::mutex mutex;
  std::condition_variable condition;
  std::map<std::string, Heard> heard;
  std::map<std::string, std::vector<RpcRow>> metrics;
  std::deque<RunEvent> events;
  std::set<std::string> objects;

  std::shared_ptr<dds::Node> node;
  // Declared last: their threads end before what they write to.
  std::unique_ptr<dds::Subscriber<msg::ServiceStatus>> statuses;
  std::unique_ptr<dds::Subscriber<msg::ServiceMetrics>> measures;
  std::unique_ptr<dds::Subscriber<msg::RunEvent>> happenings;
};

Client::Client() : impl_(std::make_unique<Impl>()) {
  Impl& i = *impl_;
  i.statuses = std::make_unique<dds::Subscriber<msg::ServiceStatus>>(*i.node, "periplus/service/status", dds::qos_latest(),
                                                                      [&i](const msg::ServiceStatus& s) { i.take(s); });
  i.measures = std::make_unique<dds::Subscriber<msg::ServiceMetrics>>(*i.node, "periplus/service/metrics", dds::qos_latest(),
                                                                       [&i](const msg::ServiceMetrics& m) { i.take(m); });
  i.happenings = std::make_unique<dds::Subscriber<msg::RunEvent>>(*i.node, "periplus/supervisor/event", dds::qos_latest(256),
                                                                   [&i](const msg::RunEvent& e) { i.take(e); });
}

Client::~Client() = default;

int Client::domain() const { return impl_->node->options().domain; }

std::vector<ServiceRow> Client::services() const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<ServiceRow> rows;
  for (const auto& [instance, heard] : impl_->heard) {
    rows.push_back(heard.row);
    rows.back().age_s = seconds_since(heard.at);
    if (const auto at = impl_->metrics.find(instance); at != impl_->metrics.end()) rows.back().rpcs = at->second;
  }
  return rows;
}

std::vector<RunEvent> Client::take_events() {
  const std::lock_guard lock(impl_->mutex);
  std::vector<RunEvent> taken(std::make_move_iterator(impl_->events.begin()), std::make_move_iterator(impl_->events.end()));
  impl_->events.clear();
  return taken;
}

std::string Client::start(const std::string& run_id, const std::string& task_yaml, const EnvironmentTexts& environment) {
  dds::RpcClient<msg::StartRequest, msg::StartReply> client(*impl_->node, "supervisor/start");
  msg::StartRequest request;
  request.run_id(run_id);
  request.task_yaml(wire::text_to_wire(task_yaml));
  request.environment(wire::environment_to_wire(environment));
  msg::StartReply reply;
  client.call(request, reply, patient(10s)).throw_if_failed("supervisor/start");
  return reply.run_folder().to_string();
}

bool Client::abort(const std::string& run_id) {
  dds::RpcClient<msg::AbortRequest, msg::AbortReply> client(*impl_->node, "supervisor/abort");
  msg::AbortRequest request;
  request.run_id(run_id);
  msg::AbortReply reply;
  client.call(request, reply, patient(5s)).throw_if_failed("supervisor/abort");
  return reply.was_running();
}

bool Client::report_loss(const std::string& run_id, const std::string& what) {
  dds::RpcClient<msg::AbortRequest, msg::AbortReply> client(*impl_->node, "supervisor/abort");
  msg::AbortRequest request;
  request.run_id(run_id);
  request.lost(what.substr(0, 255));
  msg::AbortReply reply;
  return client.call(request, reply, {.deadline = 2s, .wait_for_server = 1s}).ok();
}

std::vector<std::string> Client::objects() {
  Impl& i = *impl_;
  dds::Subscriber<msg::ObjectRevision> revisions(*i.node, "periplus/object", dds::qos_latest(), [&i](const msg::ObjectRevision& r) {
    const std::lock_guard lock(i.mutex);
    if (i.objects.size() < kMostInstances) i.objects.insert(printable(r.object_id().to_string()));
    i.condition.notify_all();
  });
  std::unique_lock lock(i.mutex);
  if (i.condition.wait_for(lock, 2s, [&i] { return !i.objects.empty(); })) i.condition.wait_for(lock, 300ms, [] { return false; });
  return {i.objects.begin(), i.objects.end()};
}

ModelDigest Client::digest(const std::string& object_id) {
  dds::RpcClient<msg::DigestRequest, msg::DigestReply> client(*impl_->node, "model/digest");
  msg::DigestRequest request;
  request.object_id(object_id);
  msg::DigestReply reply;
  client.call(request, reply, patient(30s)).throw_if_failed("model/digest");
  const msg::GridCounts& c = reply.counts();
  return {reply.digest().to_string(), reply.revision(), reply.views(), c.known(), c.unknown(), c.empty(), c.environment()};
}

std::vector<std::uint8_t> Client::export_model(const std::string& object_id, const std::string& format) {
  std::mutex mutex;
  std::condition_variable condition;
  std::map<std::string, std::vector<std::uint8_t>> files;  // by SHA-256
  dds::Subscriber<msg::ModelFile> subscriber(*impl_->node, "periplus/model/file", dds::qos_stream(4), [&](const msg::ModelFile& f) {
    const std::string digest = sha256_hex(std::string_view(reinterpret_cast<const char*>(f.data().data()), f.data().size()));
    const std::lock_guard lock(mutex);
    if (digest == f.sha256().to_string() && f.object_id().to_string() == object_id) files[digest] = f.data();
    condition.notify_all();
  });
  dds::RpcClient<msg::ExportRequest, msg::ExportReply> client(*impl_->node, "model/export");
  // A sample sent right after two ends met may be lost: so it is asked for again.
  for (int attempt = 0; attempt < 3; ++attempt) {
    msg::ExportRequest request;
    request.object_id(object_id);
    request.format(format);
    msg::ExportReply reply;
    client.call(request, reply, patient(60s)).throw_if_failed("model/export");
    std::unique_lock lock(mutex);
    const std::string wanted = reply.sha256().to_string();
    if (condition.wait_for(lock, 4s, [&] { return files.contains(wanted); })) return files[wanted];
  }
  throw Error(ErrorCode::supervisor_service_lost, "the model server answered, but its file did not arrive in three attempts; see `periplus doctor`");
}

}  // namespace periplus::supervisor::cli
