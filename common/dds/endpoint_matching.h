// Why two endpoints of one topic do not hear each other: the rules of DDS 1.4, 2.2.3 (offered against requested QoS) and
// the type's name. Vendor-neutral, so that both back ends report a mismatch in the same words.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/node.h"

namespace periplus::dds {

struct EndpointDescription {
  Guid guid{};
  bool writer = false;
  std::string topic, type;
  std::string peer;  // name of its participant, or empty
  bool reliable = true;
  int durability = 0;  // 0 volatile, 1 transient-local, 2 transient, 3 persistent
  int liveliness = 0;  // 0 automatic, 1 manual by participant, 2 manual by topic
  std::int64_t lease_ns = std::numeric_limits<std::int64_t>::max();     // of liveliness
  std::int64_t deadline_ns = std::numeric_limits<std::int64_t>::max();
  bool exclusive_ownership = false;
};

EndpointDescription describe(const Guid& guid, bool writer, const std::string& topic, const Codec& codec, const Qos& qos);

struct Mismatch {
  std::string policy;     // "reliability", "durability", "liveliness", "deadline", "ownership" or "type"
  std::string offered, requested;
};
// The first policy that keeps `writer` and `reader`, both of one topic, apart.
std::optional<Mismatch> find_mismatch(const EndpointDescription& writer, const EndpointDescription& reader);

// Compares each remote endpoint with each local one and logs every mismatched pair once. Thread-safe.
class EndpointMatching {
 public:
  void add_local(const EndpointDescription& endpoint);
  void add_remote(const EndpointDescription& endpoint);
  void remove(const Guid& guid);
  void clear();
  std::uint64_t mismatches() const;

 private:
  void compare(const EndpointDescription& local, const EndpointDescription& remote);
  mutable std::mutex mutex_;
  std::map<Guid, EndpointDescription> local_, remote_;
  std::set<std::pair<Guid, Guid>> logged_;
  std::uint64_t mismatches_ = 0;
};

// A writer or reader of a back end, known to the matching as long as it lives.
template <class Base>
class Described : public Base {
 public:
  template <class... Args>
  explicit Described(EndpointMatching& matching, Args&&... args) : Base(std::forward<Args>(args)...), matching_(matching) {}
  ~Described() override { matching_.remove(registered_); }
  void add(const EndpointDescription& description) {
    registered_ = description.guid;
    matching_.add_local(description);
  }

 private:
  EndpointMatching& matching_;
  Guid registered_{};
};

// "01.0f.5a…": as the vendors' own tools print it.
std::string to_string(const Guid& guid);

}  // namespace periplus::dds
