#include "common/dds/node.h"

#include <arpa/inet.h>
#include <pthread.h>
#include <time.h>

#include <algorithm>
#include <condition_variable>
#include <cstdlib>
#include <deque>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <shared_mutex>
#include <sstream>
#include <thread>

#include "common/core/error.h"
#include "common/core/log.h"
#include "common/dds/participant.h"

namespace periplus::dds {
namespace {

using std::chrono::milliseconds;

// Goes on while the computer sleeps, unlike the steady clock: peers do not wait for it.
struct BootClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<BootClock>;
  static constexpr bool is_steady = true;
  static time_point now() {
    timespec t{};
    clock_gettime(CLOCK_BOOTTIME, &t);
    return time_point(std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec));
  }
};
using Clock = BootClock;

// Also the period at which RPC writers assert their liveliness: four times within their lease of 500 ms.
constexpr milliseconds kWatchPeriod{120};
// A service that starts with its computer may be there before the network is.
constexpr milliseconds kInterfacePatience{10000};
// What a transient-local writer keeps of its own samples, to publish them again after the node joined anew.
constexpr std::size_t kHistoryBytes = 256U << 20;

std::string environment(const char* name, const std::string& otherwise) {
  const char* value = std::getenv(name);
  return value && *value ? value : otherwise;
}

bool is_ipv4(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

void check(const NodeOptions& options) {
  require(options.vendor == "fastdds" || options.vendor == "cyclonedds", ErrorCode::bad_input,
          "PERIPLUS_DDS: \"" + options.vendor + "\" is no DDS vendor that Periplus knows; use fastdds or cyclonedds");
  require(options.domain >= 0 && options.domain <= 101, ErrorCode::bad_input,
          "PERIPLUS_DOMAIN: " + std::to_string(options.domain) + " is not in 0..101 (ports of higher domains collide with ephemeral ones)");
  for (const std::string& peer : options.peers) {
    require(is_ipv4(peer), ErrorCode::bad_input, "PERIPLUS_PEERS: \"" + peer + "\" is no IPv4 address; give addresses separated by commas");
  }
  require(options.participant_lease >= milliseconds(1000), ErrorCode::bad_input, "the participant lease must be at least 1 s");
}

// The vendor's entities are used under a shared lock and exchanged under the exclusive one.
class Gate {
 public:
  class Pass {
   public:
    explicit Pass(Gate& gate) : gate_(gate) {
      while (gate_.closing_) std::this_thread::sleep_for(milliseconds(1));
      gate_.mutex_.lock_shared();
    }
    ~Pass() { gate_.mutex_.unlock_shared(); }
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;

   private:
    Gate& gate_;
  };
  // New passes wait from here on; then those inside are waited for.
  void begin_closing() { closing_ = true; }
  void lock() { mutex_.lock(); }
  void unlock() {
    mutex_.unlock();
    closing_ = false;
  }

 private:
  std::atomic<bool> closing_{false};
  std::shared_mutex mutex_;
};

// An endpoint whose vendor entity can be made anew.
struct Renewable {
  virtual ~Renewable() = default;
  virtual void interrupt() {}
  virtual void assert_alive() {}
  virtual void drop() = 0;
  virtual void make(Participant& participant) = 0;
};

struct Core {
  Gate gate;
  std::mutex mutex;  // of `endpoints`
  std::set<Renewable*> endpoints;
  std::unique_ptr<Participant> participant;
  EndpointMatching matching;
  std::atomic<std::uint64_t> rejoins{0};
};

class RenewableWriter : public Writer, private Renewable {
 public:
  RenewableWriter(std::shared_ptr<Core> core, std::string topic, const Codec& codec, const Qos& qos)
      : core_(std::move(core)), topic_(std::move(topic)), codec_(codec), qos_(qos) {
    const Gate::Pass pass(core_->gate);
    if (core_->participant) make(*core_->participant);
    const std::lock_guard lock(core_->mutex);
    core_->endpoints.insert(this);
  }
  ~RenewableWriter() override {
    const Gate::Pass pass(core_->gate);
    {
      const std::lock_guard lock(core_->mutex);
      core_->endpoints.erase(this);
    }
    writer_.reset();
  }

  bool write(const void* sample) override {
    const Gate::Pass pass(core_->gate);
    if (qos_.transient_local && !remember(sample)) return false;
    return writer_ && writer_->write(sample);
  }
  bool matched(const Guid& reader) override {
    const Gate::Pass pass(core_->gate);
    return writer_ && writer_->matched(reader);
  }
  int matched_count() override {
    const Gate::Pass pass(core_->gate);
    return writer_ ? writer_->matched_count() : 0;
  }
  std::vector<Guid> matched_readers() override {
    const Gate::Pass pass(core_->gate);
    return writer_ ? writer_->matched_readers() : std::vector<Guid>{};
  }
  void assert_liveliness() override {
    const Gate::Pass pass(core_->gate);
    assert_alive();
  }

 private:
  struct Remembered {
    std::vector<std::uint8_t> key, bytes;
  };

  void assert_alive() override {
    if (writer_ && qos_.liveliness.count() > 0) writer_->assert_liveliness();
  }
  void drop() override { writer_.reset(); }
  void make(Participant& participant) override {
    writer_ = participant.writer(topic_, codec_, qos_);
    const std::lock_guard lock(history_mutex_);
    for (const Remembered& r : history_) {
      const std::unique_ptr<void, void (*)(void*)> sample(codec_.create(), codec_.destroy);
      if (codec_.decode(r.bytes.data(), r.bytes.size(), sample.get())) writer_->write(sample.get());
    }
  }

  bool remember(const void* sample) {
    Remembered r;
    if (codec_.keyed && !codec_.key_be(sample, r.key)) return false;
    r.bytes.resize(codec_.size(sample));
    const std::size_t bytes = codec_.encode(sample, r.bytes.data(), r.bytes.size());
    if (bytes == 0) return false;
    r.bytes.resize(bytes);
    const std::lock_guard lock(history_mutex_);
    const auto same_key = by_key_.find(r.key);
    if (qos_.depth > 0 && same_key != by_key_.end() && same_key->second.size() >= static_cast<std::size_t>(qos_.depth)) forget(same_key->second.front());
    history_bytes_ += r.bytes.size();
    history_.push_back(std::move(r));
    by_key_[history_.back().key].push_back(std::prev(history_.end()));
    while (history_bytes_ > kHistoryBytes && history_.size() > 1) forget(history_.begin());
    return true;
  }

  // The oldest of its key.
  void forget(std::list<Remembered>::iterator oldest) {
    const auto same_key = by_key_.find(oldest->key);
    same_key->second.pop_front();
    if (same_key->second.empty()) by_key_.erase(same_key);
    history_bytes_ -= oldest->bytes.size();
    history_.erase(oldest);
  }

  const std::shared_ptr<Core> core_;
  const std::string topic_;
  const Codec& codec_;
  const Qos qos_;
  std::unique_ptr<Writer> writer_;
  std::mutex history_mutex_;
  std::list<Remembered> history_;  // oldest first
  std::map<std::vector<std::uint8_t>, std::deque<std::list<Remembered>::iterator>> by_key_;
  std::size_t history_bytes_ = 0;
};

class RenewableReader : public Reader, private Renewable {
 public:
  RenewableReader(std::shared_ptr<Core> core, std::string topic, const Codec& codec, const Qos& qos)
      : core_(std::move(core)), topic_(std::move(topic)), codec_(codec), qos_(qos) {
    const Gate::Pass pass(core_->gate);
    if (core_->participant) make(*core_->participant);
    const std::lock_guard lock(core_->mutex);
    core_->endpoints.insert(this);
  }
  ~RenewableReader() override {
    const Gate::Pass pass(core_->gate);
    {
      const std::lock_guard lock(core_->mutex);
      core_->endpoints.erase(this);
    }
    reader_.reset();
  }

  Take take(void* sample) override {
    const Gate::Pass pass(core_->gate);
    return reader_ ? reader_->take(sample) : Take::none;
  }
  bool wait(milliseconds timeout) override {
    {
      const Gate::Pass pass(core_->gate);
      if (reader_) return reader_->wait(timeout);
    }
    std::this_thread::sleep_for(std::min(timeout, milliseconds(20)));
    return false;
  }
  void wake() override {
    const Gate::Pass pass(core_->gate);
    if (reader_) reader_->wake();
  }
  Guid guid() override {
    const Gate::Pass pass(core_->gate);
    return reader_ ? reader_->guid() : Guid{};
  }
  int matched_count() override {
    const Gate::Pass pass(core_->gate);
    return reader_ ? reader_->matched_count() : 0;
  }
  int alive_writers() override {
    const Gate::Pass pass(core_->gate);
    return reader_ ? reader_->alive_writers() : 0;
  }
  std::vector<Guid> alive_writer_guids() override {
    const Gate::Pass pass(core_->gate);
    return reader_ ? reader_->alive_writer_guids() : std::vector<Guid>{};
  }

 private:
  void interrupt() override {
    if (reader_) reader_->wake();
  }
  void drop() override { reader_.reset(); }
  void make(Participant& participant) override { reader_ = participant.reader(topic_, codec_, qos_); }

  const std::shared_ptr<Core> core_;
  const std::string topic_;
  const Codec& codec_;
  const Qos qos_;
  std::unique_ptr<Reader> reader_;
};

class ManagedNode : public Node {
 public:
  explicit ManagedNode(const NodeOptions& options) : Node(options), core_(std::make_shared<Core>()) {
    check(options_);
    core_->participant = join(wait_for_interface(options_.interface, kInterfacePatience));
    watch_ = std::thread([this] { watch(); });
  }
  ~ManagedNode() override {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    stop_.notify_all();
    watch_.join();
    core_->gate.begin_closing();
    const std::lock_guard lock(core_->gate);
    {
      // Endpoints should be gone by now; those that are not fall silent instead of using a participant that went.
      const std::lock_guard endpoints(core_->mutex);
      for (Renewable* endpoint : core_->endpoints) endpoint->drop();
    }
    core_->participant.reset();
  }

  std::unique_ptr<Writer> writer(const std::string& topic, const Codec& codec, const Qos& qos) override {
    return std::make_unique<RenewableWriter>(core_, topic, codec, with_partition(qos));
  }
  std::unique_ptr<Reader> reader(const std::string& topic, const Codec& codec, const Qos& qos) override {
    return std::make_unique<RenewableReader>(core_, topic, codec, with_partition(qos));
  }
  std::uint64_t rejoins() const override { return core_->rejoins; }
  std::uint64_t mismatches() const override { return core_->matching.mismatches(); }

 private:
  Qos with_partition(Qos qos) const {
    if (qos.partition.empty()) qos.partition = options_.partition;
    return qos;
  }

  std::unique_ptr<Participant> join(const NetworkInterface& interface) {
    const ParticipantSettings settings{options_, interface, announcement_period(options_.participant_lease)};
    return options_.vendor == "fastdds" ? make_fastdds_participant(settings, core_->matching, bad_samples)
                                        : make_cyclonedds_participant(settings, core_->matching, bad_samples);
  }

  // Peers forget a participant that they have not heard for its lease, and not all find it again by themselves (some
  // remember that they said goodbye). So a node that was frozen, or whose interface was away, for nearly that long
  // leaves and joins anew. Peers count from the last announcement, one period before the silence at worst.
  void watch() {
    const auto longest_silence = options_.participant_lease - announcement_period(options_.participant_lease);
    auto last_tick = Clock::now();
    auto interface_seen = last_tick;
    auto interface_checked = last_tick;
    std::unique_lock lock(mutex_);
    while (!stop_.wait_for(lock, kWatchPeriod, [&] { return stopping_; })) {
      lock.unlock();
      auto now = Clock::now();
      std::string cause;
      if (now - last_tick > longest_silence) cause = "the process was frozen";
      if (now - interface_checked >= milliseconds(500)) {
        interface_checked = now;
        if (interface_is_up(options_.interface)) {
          if (now - interface_seen > longest_silence && cause.empty()) cause = "interface " + options_.interface + " was away";
          interface_seen = now;
        }
      }
      if (!cause.empty() || !core_->participant) {
        // Joining may take long on a loaded computer: that is no silence of the new participant.
        if (const auto joined = rejoin(cause)) now = interface_seen = *joined;
      } else {
        core_->participant->poll();
        const std::lock_guard endpoints(core_->mutex);
        for (Renewable* endpoint : core_->endpoints) endpoint->assert_alive();
      }
      last_tick = now;
      lock.lock();
    }
  }

  // Only the watch thread exchanges the participant, so it alone may look at it without the gate. When the new
  // participant first announced itself; nothing if it could not join.
  std::optional<Clock::time_point> rejoin(const std::string& cause) {
    std::optional<Clock::time_point> joined;
    if (!cause.empty()) log::warn("joining the bus anew: " + cause + " for longer than the participant lease", {{"node", options_.name}});
    core_->gate.begin_closing();
    {
      const std::lock_guard endpoints(core_->mutex);
      for (Renewable* endpoint : core_->endpoints) endpoint->interrupt();
    }
    const std::lock_guard lock(core_->gate);
    const std::lock_guard endpoints(core_->mutex);
    for (Renewable* endpoint : core_->endpoints) endpoint->drop();
    core_->participant.reset();
    core_->matching.clear();
    try {
      core_->participant = join(find_interface(options_.interface));
      joined = Clock::now();
      for (Renewable* endpoint : core_->endpoints) endpoint->make(*core_->participant);
      ++core_->rejoins;
      unjoined_.clear();
    } catch (const std::exception& error) {
      if (unjoined_ != error.what()) log::warn(std::string("could not join the bus, trying again: ") + error.what(), {{"node", options_.name}});
      unjoined_ = error.what();
      for (Renewable* endpoint : core_->endpoints) endpoint->drop();
      core_->participant.reset();
      joined.reset();
    }
    return joined;
  }

  const std::shared_ptr<Core> core_;
  std::mutex mutex_;
  std::condition_variable stop_;
  bool stopping_ = false;
  std::string unjoined_;  // why the last try to join anew failed; of the watch thread
  std::thread watch_;
};

}  // namespace

NodeOptions NodeOptions::from_environment(const std::string& name) {
  NodeOptions options;
  options.name = name;
  options.vendor = environment("PERIPLUS_DDS", options.vendor);
  const std::string domain = environment("PERIPLUS_DOMAIN", std::to_string(options.domain));
  require(domain.size() <= 3 && domain.find_first_not_of("0123456789") == std::string::npos, ErrorCode::bad_input,
          "PERIPLUS_DOMAIN: \"" + domain + "\" is no number in 0..101");
  options.domain = std::atoi(domain.c_str());
  options.interface = environment("PERIPLUS_INTERFACE", options.interface);
  std::istringstream peers(environment("PERIPLUS_PEERS", ""));
  for (std::string peer; std::getline(peers, peer, ',');) {
    const auto begin = peer.find_first_not_of(' ');
    if (begin != std::string::npos) options.peers.push_back(peer.substr(begin, peer.find_last_not_of(' ') - begin + 1));
  }
  const std::string shm = environment("PERIPLUS_SHM", "1");
  require(shm == "0" || shm == "1", ErrorCode::bad_input, "PERIPLUS_SHM: \"" + shm + "\" is neither 0 nor 1");
  options.shared_memory = shm == "1";
  check(options);
  return options;
}

std::shared_ptr<Node> Node::create(const NodeOptions& options) { return std::make_shared<ManagedNode>(options); }

struct ReaderThread::Impl {
  Impl(Node& owner, std::string topic_name, const Codec& sample_codec, const Qos& qos, std::function<void(const void*)> on_sample)
      : node(owner),
        topic(std::move(topic_name)),
        codec(sample_codec),
        callback(std::move(on_sample)),
        reader(owner.reader(topic, sample_codec, qos)) {}

  void run() {
    const std::unique_ptr<void, void (*)(void*)> sample(codec.create(), codec.destroy);
    while (!stop) {
      if (!reader->wait(milliseconds(500))) continue;
      for (Take taken; !stop && (taken = reader->take(sample.get())) != Take::none;) {
        if (taken == Take::bad) {
          count_bad();
        } else if (taken == Take::data) {
          call(sample.get());
        }
      }
    }
  }

  void call(const void* sample) {
    try {
      callback(sample);
    } catch (const std::exception& error) {
      log::error(std::string("a callback failed: ") + error.what(), {{"topic", topic}, {"type", codec.type_name}});
    }
  }

  void count_bad() {
    ++bad;
    ++node.bad_samples;
    ++unlogged;
    const auto now = Clock::now();
    if (logged && now - *logged < std::chrono::seconds(5)) return;
    log::warn("dropped samples that could not be decoded; does a peer use another version of this type?",
              {{"topic", topic}, {"type", codec.type_name}, {"samples", std::to_string(unlogged)}, {"total", std::to_string(bad)}});
    logged = now;
    unlogged = 0;
  }

  Node& node;
  const std::string topic;
  const Codec& codec;
  const std::function<void(const void*)> callback;
  std::unique_ptr<Reader> reader;
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> bad{0};
  std::uint64_t unlogged = 0;
  std::optional<Clock::time_point> logged;
  std::thread thread;
};

ReaderThread::ReaderThread(Node& node, const std::string& topic, const Codec& codec, const Qos& qos,
                           std::function<void(const void*)> callback)
    : impl_(std::make_unique<Impl>(node, topic, codec, qos, std::move(callback))) {
  impl_->thread = std::thread([impl = impl_.get()] {
    pthread_setname_np(pthread_self(), "periplus-reader");  // as debuggers show it
    impl->run();
  });
}

ReaderThread::~ReaderThread() {
  impl_->stop = true;
  impl_->reader->wake();
  impl_->thread.join();
}

Reader& ReaderThread::reader() { return *impl_->reader; }
std::uint64_t ReaderThread::bad() const { return impl_->bad; }

}  // namespace periplus::dds
