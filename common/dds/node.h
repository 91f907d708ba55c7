// A process' place on the bus, over Fast DDS or Cyclone DDS, chosen at run time. No vendor header is seen by users.
//
//   auto node = dds::Node::create(dds::NodeOptions::from_environment("vision-server"));
//   dds::Publisher<msg::Perception> out(*node, "periplus/perception", dds::qos_latest(4));
//   dds::Subscriber<msg::Perception> in(*node, "periplus/perception", dds::qos_latest(4), [](const msg::Perception& p) {...});
//
// Callbacks run on the subscriber's own thread, never on a DDS thread. Bad samples are counted and logged, never fatal.
// One Node per process.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/dds/codec.h"

namespace periplus::dds {

using Guid = std::array<std::uint8_t, 16>;

struct NodeOptions {
  std::string name;                       // for logs and discovery
  std::string vendor = "fastdds";         // PERIPLUS_DDS: fastdds | cyclonedds
  int domain = 42;                        // PERIPLUS_DOMAIN: 0..101
  std::string interface = "lo";           // PERIPLUS_INTERFACE: name or address; loopback by default
  std::vector<std::string> peers;         // PERIPLUS_PEERS: comma-separated addresses; multicast is off when given
  bool shared_memory = true;              // PERIPLUS_SHM: 0 switches Fast DDS' shared memory off
  std::string partition;                  // default partition of its topics; "truth" for what only a simulator knows
  std::chrono::milliseconds participant_lease{20000};

  // Reads the environment variables named above. Throws Error(bad_input) with what is allowed.
  static NodeOptions from_environment(const std::string& name);
};

struct Qos {
  bool reliable = true;
  bool transient_local = false;           // late joiners get the last `depth` samples
  int depth = 16;                         // 0: keep all
  std::chrono::milliseconds liveliness{0};  // 0: infinite
  std::string partition = {};             // empty: the node's
};
inline Qos qos_stream(int depth = 16) { return {.depth = depth}; }                              // samples as they come
inline Qos qos_latest(int depth = 1) { return {.transient_local = true, .depth = depth}; }      // state for late joiners
inline Qos qos_rpc() { return {.depth = 0, .liveliness = std::chrono::milliseconds(500)}; }

// --- the vendor interface: implemented in fastdds/ and cyclonedds/
enum class Take { none, data, no_data, bad };
struct Writer {
  virtual ~Writer() = default;
  virtual bool write(const void*) = 0;
  virtual bool matched(const Guid& reader) = 0;
  virtual int matched_count() = 0;
  virtual std::vector<Guid> matched_readers() = 0;
  // Called by the node's own thread for writers whose QoS has a liveliness lease.
  virtual void assert_liveliness() = 0;
};
struct Reader {
  virtual ~Reader() = default;
  virtual Take take(void*) = 0;
  virtual bool wait(std::chrono::milliseconds) = 0;   // true: something may be there
  virtual void wake() = 0;                            // ends a wait
  virtual Guid guid() = 0;
  virtual int matched_count() = 0;
  virtual int alive_writers() = 0;
  // Matched writers that keep their liveliness lease (all matched ones where the QoS has none).
  virtual std::vector<Guid> alive_writer_guids() = 0;
};

class Node {
 public:
  static std::shared_ptr<Node> create(const NodeOptions& options);
  virtual ~Node() = default;

  virtual std::unique_ptr<Writer> writer(const std::string& topic, const Codec&, const Qos&) = 0;
  virtual std::unique_ptr<Reader> reader(const std::string& topic, const Codec&, const Qos&) = 0;
  const NodeOptions& options() const { return options_; }
  // How often this node had to join anew after it was frozen or cut off for longer than its lease. GUIDs change then;
  // Publishers, Subscribers, RPC clients and servers stay valid, transient-local samples are published again.
  virtual std::uint64_t rejoins() const = 0;
  // Pairs of endpoints on one topic that were found not to match; each is logged with peer, topic and policy.
  virtual std::uint64_t mismatches() const = 0;
  // Samples that could not be decoded, over all readers of this node.
  std::atomic<std::uint64_t> bad_samples{0};

 protected:
  explicit Node(NodeOptions options) : options_(std::move(options)) {}
  NodeOptions options_;
};

// Takes samples off a reader on a thread of its own.
class ReaderThread {
 public:
  ReaderThread(Node& node, const std::string& topic, const Codec& codec, const Qos& qos, std::function<void(const void*)> callback);
  ~ReaderThread();  // joins
  ReaderThread(const ReaderThread&) = delete;
  ReaderThread& operator=(const ReaderThread&) = delete;
  Reader& reader();
  std::uint64_t bad() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

template <class T>
class Publisher {
 public:
  Publisher(Node& node, const std::string& topic, const Qos& qos) : writer_(node.writer(topic, codec<T>(), qos)) {}
  // False if the sample could not be encoded or the vendor refused it. Safe from several threads.
  bool publish(const T& sample) { return writer_->write(&sample); }
  int matched() { return writer_->matched_count(); }
  Writer& raw() { return *writer_; }

 private:
  std::unique_ptr<Writer> writer_;
};

template <class T>
class Subscriber {
 public:
  Subscriber(Node& node, const std::string& topic, const Qos& qos, std::function<void(const T&)> callback)
      : thread_(node, topic, codec<T>(), qos,
                [callback = std::move(callback)](const void* sample) { callback(*static_cast<const T*>(sample)); }) {}
  int matched() { return thread_.reader().matched_count(); }
  std::uint64_t bad() const { return thread_.bad(); }
  Reader& raw() { return thread_.reader(); }

 private:
  ReaderThread thread_;
};

}  // namespace periplus::dds
