#include "common/dds/endpoint_matching.h"

#include <array>
#include <cstdio>

#include "common/core/log.h"

namespace periplus::dds {
namespace {

const char* durability_name(int durability) {
  constexpr std::array names = {"volatile", "transient-local", "transient", "persistent"};
  return durability >= 0 && durability < 4 ? names[static_cast<std::size_t>(durability)] : "unknown";
}

const char* liveliness_name(int liveliness) {
  constexpr std::array names = {"automatic", "manual by participant", "manual by topic"};
  return liveliness >= 0 && liveliness < 3 ? names[static_cast<std::size_t>(liveliness)] : "unknown";
}

std::string duration_name(std::int64_t ns) {
  return ns == std::numeric_limits<std::int64_t>::max() ? "infinite" : std::to_string(ns / 1000000) + " ms";
}

}  // namespace

EndpointDescription describe(const Guid& guid, bool writer, const std::string& topic, const Codec& codec, const Qos& qos) {
  EndpointDescription d;
  d.guid = guid;
  d.writer = writer;
  d.topic = topic;
  d.type = codec.type_name;
  d.reliable = qos.reliable;
  d.durability = qos.transient_local ? 1 : 0;
  if (qos.liveliness.count() > 0) {
    d.liveliness = 2;
    d.lease_ns = std::chrono::nanoseconds(qos.liveliness).count();
  }
  return d;
}

std::optional<Mismatch> find_mismatch(const EndpointDescription& writer, const EndpointDescription& reader) {
  if (writer.type != reader.type) return Mismatch{"type", writer.type, reader.type};
  if (!writer.reliable && reader.reliable) return Mismatch{"reliability", "best effort", "reliable"};
  if (writer.durability < reader.durability) {
    return Mismatch{"durability", durability_name(writer.durability), durability_name(reader.durability)};
  }
  if (writer.liveliness < reader.liveliness) {
    return Mismatch{"liveliness", liveliness_name(writer.liveliness), liveliness_name(reader.liveliness)};
  }
  if (writer.lease_ns > reader.lease_ns) {
    return Mismatch{"liveliness", "lease " + duration_name(writer.lease_ns), "lease " + duration_name(reader.lease_ns)};
  }
  if (writer.deadline_ns > reader.deadline_ns) {
    return Mismatch{"deadline", duration_name(writer.deadline_ns), duration_name(reader.deadline_ns)};
  }
  if (writer.exclusive_ownership != reader.exclusive_ownership) {
    return Mismatch{"ownership", writer.exclusive_ownership ? "exclusive" : "shared", reader.exclusive_ownership ? "exclusive" : "shared"};
  }
  return std::nullopt;
}

void EndpointMatching::compare(const EndpointDescription& local, const EndpointDescription& remote) {
  if (local.topic != remote.topic || local.writer == remote.writer) return;
  const auto mismatch = local.writer ? find_mismatch(local, remote) : find_mismatch(remote, local);
  if (!mismatch || !logged_.emplace(local.guid, remote.guid).second) return;
  ++mismatches_;
  log::warn("QoS mismatch: our " + std::string(local.writer ? "writer" : "reader") + " and a peer's " +
                (remote.writer ? "writer" : "reader") + " do not hear each other; give both the same " + mismatch->policy,
            {{"topic", local.topic},
             {"policy", mismatch->policy},
             {"offered", mismatch->offered},
             {"requested", mismatch->requested},
             {"peer", remote.peer.empty() ? to_string(remote.guid) : remote.peer},
             {"peer_guid", to_string(remote.guid)}});
}

void EndpointMatching::add_local(const EndpointDescription& endpoint) {
  const std::lock_guard lock(mutex_);
  local_[endpoint.guid] = endpoint;
  for (const auto& [guid, remote] : remote_) compare(endpoint, remote);
}

void EndpointMatching::add_remote(const EndpointDescription& endpoint) {
  const std::lock_guard lock(mutex_);
  if (local_.contains(endpoint.guid)) return;
  remote_[endpoint.guid] = endpoint;
  for (const auto& [guid, local] : local_) compare(local, endpoint);
}

void EndpointMatching::remove(const Guid& guid) {
  const std::lock_guard lock(mutex_);
  local_.erase(guid);
  remote_.erase(guid);
  std::erase_if(logged_, [&](const auto& pair) { return pair.first == guid || pair.second == guid; });
}

void EndpointMatching::clear() {
  const std::lock_guard lock(mutex_);
  local_.clear();
  remote_.clear();
  logged_.clear();
}

std::uint64_t EndpointMatching::mismatches() const {
  const std::lock_guard lock(mutex_);
  return mismatches_;
}

std::string to_string(const Guid& guid) {
  std::string text;
  for (std::size_t i = 0; i < guid.size(); ++i) {
    char octet[4];
    std::snprintf(octet, sizeof octet, "%02x", guid[i]);
    if (i) text += i == 12 ? '|' : '.';
    text += octet;
  }
  return text;
}

}  // namespace periplus::dds
