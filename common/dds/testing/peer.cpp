// The other process of the tests: one node of the vendor asked for, which does what its first argument says until SIGTERM.
//
//   dds_peer VENDOR DOMAIN LEASE_MS serve NAME            RPC server; what it does stands in the request's object_id
//   dds_peer VENDOR DOMAIN LEASE_MS forgetful NAME        the same, forgetting clients that were silent for a second
//   dds_peer VENDOR DOMAIN LEASE_MS status COUNT          keyed transient-local state, published before anyone listens
//   dds_peer VENDOR DOMAIN LEASE_MS images COUNT          1.8 MB images once a sample on the topic "go" says that the reader is ready
//   dds_peer VENDOR DOMAIN LEASE_MS beat                  a status every 50 ms, with the number of rejoins
//   dds_peer VENDOR DOMAIN LEASE_MS best-effort           a best-effort writer on the topic "mismatch"
//   dds_peer VENDOR DOMAIN LEASE_MS bad                   broken samples between good ones, keyed and unkeyed
//
// Interface, peers and shared memory come from the environment, as for a service. Prints "ready" when its node stands.
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/dds/rpc.h"
#include "idl/common.h"
#include "idl/model.h"
#include "idl/ros2.h"

namespace {

using namespace std::chrono_literals;
using namespace periplus;

volatile std::sig_atomic_t stopped = 0;

void until_stopped() {
  while (!stopped) std::this_thread::sleep_for(20ms);
}

void serve(dds::Node& node, const std::string& name, std::chrono::seconds expiry) {
  std::atomic<std::uint32_t> runs{0};
  const dds::RpcServer<msg::ExportRequest, msg::ExportReply> server(
      node, name,
      [&](const msg::ExportRequest& request, msg::ExportReply& reply, dds::RpcContext& context) {
        const std::string what = request.object_id().to_string();
        reply.revision(++runs);
        reply.bytes(static_cast<std::uint64_t>(getpid()));
        reply.sha256(request.format().to_string());
        if (what == "slow") std::this_thread::sleep_for(900ms);
        if (what == "hang") std::this_thread::sleep_for(30s);
        if (what == "refuse") throw Error(ErrorCode::model_object_unknown, "no object of that name; begin it first");
        if (what == "defect") throw std::runtime_error("a defect");
        if (what == "long") {
          for (int i = 0; i < 30; ++i) {
            context.progress(i / 30.0, std::to_string(getpid()));
            context.throw_if_cancelled();
            std::this_thread::sleep_for(50ms);
          }
        }
      },
      {.threads = 4, .expiry = expiry});
  until_stopped();
}

msg::ServiceStatus status(const std::string& instance) {
  msg::ServiceStatus s;
  s.instance(instance);
  s.pid(static_cast<std::uint32_t>(getpid()));
  return s;
}

void publish_status(dds::Node& node, int count) {
  dds::Publisher<msg::ServiceStatus> out(node, "state", dds::qos_latest());
  for (int i = 0; i < 2 * count; ++i) {  // twice: the second of each key is what late joiners get
    auto s = status("instance-with-a-key-over-sixteen-bytes-" + std::to_string(i % count));
    s.uptime_s(i);
    out.publish(s);
  }
  until_stopped();
}

void publish_images(dds::Node& node, int count) {
  dds::Publisher<sensor_msgs::msg::dds_::Image_> out(node, "rt/image", dds::qos_stream(32));  // deeper than what is sent: nothing is overwritten while it is repaired
  // The reader knows when it has matched us; we may count it as matched seconds before it does.
  std::atomic<bool> go{false};
  dds::Subscriber<msg::Cancel> in(node, "go", dds::qos_latest(), [&](const auto&) { go = true; });
  while (!stopped && (!go || out.matched() == 0)) std::this_thread::sleep_for(10ms);
  sensor_msgs::msg::dds_::Image_ image;
  image.encoding("rgb8");
  image.data().resize(1843200);
  for (std::size_t i = 0; i < image.data().size(); ++i) image.data()[i] = static_cast<std::uint8_t>(i * 31);
  // Cyclone drops volatile samples until a writer's first heartbeat, and Fast DDS sends none before the first sample:
  // one that does not count goes ahead.
  image.header().stamp().sec(-1);
  out.publish(image);
  std::this_thread::sleep_for(500ms);
  for (int i = 0; i < count && !stopped; ++i) {
    image.header().stamp().sec(i);
    out.publish(image);
    std::this_thread::sleep_for(30ms);
  }
  until_stopped();
}

void beat(dds::Node& node) {
  dds::Publisher<msg::ServiceStatus> out(node, "beat", dds::qos_stream(1));
  const dds::RpcServer<msg::ExportRequest, msg::ExportReply> server(
      node, "test/beat", [](const msg::ExportRequest& request, msg::ExportReply& reply, dds::RpcContext&) { reply.sha256(request.format().to_string()); });
  dds::Publisher<msg::ServiceStatus> state(node, "state", dds::qos_latest());
  for (const char* detail : {"old", "new"}) {
    for (const char* instance : {"kept", "kept-too"}) {
      auto s = status(instance);
      s.detail(detail);
      state.publish(s);
    }
  }
  while (!stopped) {
    auto s = status("beat");
    s.bad_samples(node.rejoins());
    out.publish(s);
    std::this_thread::sleep_for(50ms);
  }
}

// A codec whose payload is broken for the samples that `is_bad` picks.
template <class T, bool (*is_bad)(const T&)>
const dds::Codec& corrupting_codec() {
  static const dds::Codec instance = [] {
    dds::Codec c = dds::codec<T>();
    c.encode = [](const void* sample, std::uint8_t* bytes, std::size_t capacity) noexcept -> std::size_t {
      const std::size_t n = dds::codec<T>().encode(sample, bytes, capacity);
      if (n > 8 && is_bad(*static_cast<const T*>(sample))) std::memset(bytes + 4, 0xff, n - 4);
      return n;
    };
    return c;
  }();
  return instance;
}
bool bad_status(const msg::ServiceStatus& s) { return s.pid() == 0; }
bool bad_digest(const msg::DigestRequest& r) { return r.header().number() % 2 == 1; }

void publish_bad(dds::Node& node) {
  const auto keyed = node.writer("keyed", corrupting_codec<msg::ServiceStatus, bad_status>(), dds::qos_stream());
  const auto unkeyed = node.writer("unkeyed", corrupting_codec<msg::DigestRequest, bad_digest>(), dds::qos_stream());
  for (int i = 0; !stopped; ++i) {
    auto s = status("x");
    if (i % 2 == 1) s.pid(0);
    keyed->write(&s);
    msg::DigestRequest r;
    r.header().number(i);
    r.object_id("bunny");
    unkeyed->write(&r);
    std::this_thread::sleep_for(20ms);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  std::signal(SIGTERM, [](int) { stopped = 1; });
  const std::string mode = argv[4], argument = argc > 5 ? argv[5] : "";
  auto options = dds::NodeOptions::from_environment("peer-" + mode);
  options.vendor = argv[1];
  options.domain = std::atoi(argv[2]);
  options.participant_lease = std::chrono::milliseconds(std::atoi(argv[3]));
  const auto node = dds::Node::create(options);
  std::puts("ready");
  std::fflush(stdout);
  if (mode == "serve") serve(*node, argument, dds::RpcServerOptions{}.expiry);
  if (mode == "forgetful") serve(*node, argument, 1s);
  if (mode == "status") publish_status(*node, std::atoi(argument.c_str()));
  if (mode == "images") publish_images(*node, std::atoi(argument.c_str()));
  if (mode == "beat") beat(*node);
  if (mode == "bad") publish_bad(*node);
  if (mode == "best-effort") {
    const dds::Publisher<msg::Cancel> out(*node, "mismatch", {.reliable = false});
    until_stopped();
  }
  return 0;
}
