// Back end on Cyclone DDS 0.10.
#include <dds/dds.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <mutex>
#include <set>

#include "common/core/error.h"
#include "common/dds/cyclonedds/sertype.h"
#include "common/dds/participant.h"

namespace periplus::dds {
namespace {

using std::chrono::milliseconds;

[[noreturn]] void refuse(const std::string& what, dds_return_t code) {
  throw Error(ErrorCode::internal, "Cyclone DDS refused " + what + ": " + dds_strretcode(-code));
}

Guid convert(const dds_guid_t& guid) {
  Guid out;
  static_assert(sizeof guid.v == sizeof out);
  std::memcpy(out.data(), guid.v, sizeof guid.v);
  return out;
}

class VendorQos {
 public:
  VendorQos() : qos_(dds_create_qos()) {}
  explicit VendorQos(const Qos& qos) : VendorQos() {
    dds_qset_reliability(qos_, qos.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT, DDS_SECS(1));
    dds_qset_durability(qos_, qos.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    if (qos.depth > 0) {
      dds_qset_history(qos_, DDS_HISTORY_KEEP_LAST, qos.depth);
    } else {
      dds_qset_history(qos_, DDS_HISTORY_KEEP_ALL, 0);
      dds_qset_resource_limits(qos_, 5000, DDS_LENGTH_UNLIMITED, 5000);
    }
    if (qos.transient_local) {
      dds_qset_durability_service(qos_, 0, qos.depth > 0 ? DDS_HISTORY_KEEP_LAST : DDS_HISTORY_KEEP_ALL, std::max(1, qos.depth),
                                  DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
    }
    if (qos.liveliness.count() > 0) dds_qset_liveliness(qos_, DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(qos.liveliness.count()));
    dds_qset_writer_data_lifecycle(qos_, false);
    const dds_data_representation_id_t representation = DDS_DATA_REPRESENTATION_XCDR1;  // the one that Fast DDS 2.9 speaks
    dds_qset_data_representation(qos_, 1, &representation);
    if (!qos.partition.empty()) dds_qset_partition1(qos_, qos.partition.c_str());
  }
  ~VendorQos() { dds_delete_qos(qos_); }
  VendorQos(const VendorQos&) = delete;
  VendorQos& operator=(const VendorQos&) = delete;
  dds_qos_t* get() const { return qos_; }

 private:
  dds_qos_t* qos_;
};

// GUIDs of matched remote endpoints by their instance handles, which Cyclone's calls speak of.
class GuidCache {
 public:
  // `fetch(handle)` returns the endpoint's description, or nullptr if it went.
  template <class Fetch>
  std::optional<Guid> find(dds_instance_handle_t handle, Fetch fetch) {
    const std::lock_guard lock(mutex_);
    if (const auto known = guids_.find(handle); known != guids_.end()) return known->second;
    dds_builtintopic_endpoint_t* endpoint = fetch(handle);
    if (!endpoint) return std::nullopt;
    const Guid guid = convert(endpoint->key);
    dds_builtintopic_free_endpoint(endpoint);
    guids_[handle] = guid;
    return guid;
  }

 private:
  std::mutex mutex_;
  std::map<dds_instance_handle_t, Guid> guids_;
};

template <class Get>
std::vector<dds_instance_handle_t> handles(Get get) {
  std::vector<dds_instance_handle_t> out(16);
  for (;;) {
    const dds_return_t n = get(out.data(), out.size());
    if (n < 0) return {};
    const bool all = static_cast<std::size_t>(n) <= out.size();
    out.resize(static_cast<std::size_t>(n));
    if (all) return out;
  }
}

class CycloneWriter : public Writer {
 public:
  CycloneWriter(dds_entity_t participant, dds_entity_t topic, const std::string& name, const Qos& qos) {
    writer_ = dds_create_writer(participant, topic, VendorQos(qos).get(), nullptr);
    if (writer_ < 0) refuse("a writer on topic " + name, writer_);
  }
  ~CycloneWriter() override { dds_delete(writer_); }

  bool write(const void* sample) override { return dds_write(writer_, sample) == DDS_RETCODE_OK; }
  int matched_count() override {
    dds_publication_matched_status_t status{};
    dds_get_publication_matched_status(writer_, &status);
    return static_cast<int>(status.current_count);
  }
  std::vector<Guid> matched_readers() override {
    std::vector<Guid> out;
    for (const auto handle : handles([&](auto* to, std::size_t n) { return dds_get_matched_subscriptions(writer_, to, n); })) {
      const auto guid = guids_.find(handle, [&](auto h) { return dds_get_matched_subscription_data(writer_, h); });
      if (guid) out.push_back(*guid);
    }
    return out;
  }
  bool matched(const Guid& reader) override {
    const std::vector<Guid> readers = matched_readers();
    return std::find(readers.begin(), readers.end(), reader) != readers.end();
  }
  void assert_liveliness() override { dds_assert_liveliness(writer_); }
  Guid guid() const {
    dds_guid_t guid{};
    dds_get_guid(writer_, &guid);
    return convert(guid);
  }

 private:
  dds_entity_t writer_;
  GuidCache guids_;
};

class CycloneReader : public Reader {
 public:
  CycloneReader(dds_entity_t participant, dds_entity_t topic, const std::string& name, const Codec& codec, const Qos& qos)
      : codec_(codec), liveliness_(qos.liveliness.count() > 0) {
    dds_listener_t* listener = dds_create_listener(this);
    dds_lset_liveliness_changed(listener, [](dds_entity_t, const dds_liveliness_changed_status_t status, void* self) {
      static_cast<CycloneReader*>(self)->on_liveliness(status);
    });
    reader_ = dds_create_reader(participant, topic, VendorQos(qos).get(), listener);
    dds_delete_listener(listener);
    if (reader_ < 0) refuse("a reader on topic " + name, reader_);
    waitset_ = dds_create_waitset(participant);
    guard_ = dds_create_guardcondition(participant);
    const dds_entity_t condition = dds_create_readcondition(reader_, DDS_ANY_STATE);
    dds_waitset_attach(waitset_, condition, 0);
    dds_waitset_attach(waitset_, guard_, 1);
  }
  ~CycloneReader() override {
    dds_delete(waitset_);
    dds_delete(guard_);
    dds_delete(reader_);
  }

  Take take(void* sample) override {
    ddsi_serdata* data = nullptr;
    dds_sample_info_t info;
    if (dds_takecdr(reader_, &data, 1, &info, DDS_ANY_STATE) <= 0) return Take::none;
    Take taken = Take::no_data;
    if (info.valid_data) taken = cyclonedds::decode(data, codec_, sample) ? Take::data : Take::bad;
    cyclonedds::release(data);
    return taken;
  }
  bool wait(milliseconds timeout) override {
    dds_attach_t fired[2] = {};
    const dds_return_t n = dds_waitset_wait(waitset_, fired, 2, DDS_MSECS(timeout.count()));
    if (n <= 0) return false;
    bool woken = false;
    dds_take_guardcondition(guard_, &woken);
    return n == 2 || fired[0] == 0;
  }
  void wake() override { dds_set_guardcondition(guard_, true); }
  Guid guid() override {
    dds_guid_t guid{};
    dds_get_guid(reader_, &guid);
    return convert(guid);
  }
  int matched_count() override {
    dds_subscription_matched_status_t status{};
    dds_get_subscription_matched_status(reader_, &status);
    return static_cast<int>(status.current_count);
  }
  int alive_writers() override { return static_cast<int>(alive_writer_guids().size()); }
  std::vector<Guid> alive_writer_guids() override {
    std::set<dds_instance_handle_t> alive, died;
    {
      const std::lock_guard lock(mutex_);
      alive = alive_;
      died = died_;
    }
    // A writer without matched readers sends no heartbeats, so Cyclone DDS counts it as not alive once its lease is over, and
    // heartbeats alone never bring it back: only a sample does. One that is matched in that state is unknown, not dead; it
    // is named where none is known to be alive.
    std::vector<Guid> out, unknown;
    for (const auto handle : handles([&](auto* to, std::size_t n) { return dds_get_matched_publications(reader_, to, n); })) {
      if (liveliness_ && died.contains(handle)) continue;
      const auto guid = guids_.find(handle, [&](auto h) { return dds_get_matched_publication_data(reader_, h); });
      if (guid) (!liveliness_ || alive.contains(handle) ? out : unknown).push_back(*guid);
    }
    return out.empty() ? unknown : out;
  }

 private:
  void on_liveliness(const dds_liveliness_changed_status_t& status) {
    const std::lock_guard lock(mutex_);
    if (status.alive_count_change > 0) {
      alive_.insert(status.last_publication_handle);
      died_.erase(status.last_publication_handle);
    } else if (status.alive_count_change < 0) {
      alive_.erase(status.last_publication_handle);
      died_.insert(status.last_publication_handle);
    }
  }

  const Codec& codec_;
  const bool liveliness_;
  dds_entity_t reader_ = 0, waitset_ = 0, guard_ = 0;
  GuidCache guids_;
  std::mutex mutex_;
  std::set<dds_instance_handle_t> alive_, died_;   // in neither: not heard of since it was matched
};

std::string configuration(const ParticipantSettings& settings) {
  const NodeOptions& options = settings.options;
  const bool multicast = options.peers.empty();
  std::string xml = "<CycloneDDS><Domain><General>";
  if (!settings.interface.address.empty()) {
    // Linux does not flag the loopback interface as able to multicast, though it is.
    xml += "<Interfaces><NetworkInterface address=\"" + settings.interface.address + "\"" + (multicast ? " multicast=\"true\"" : "") +
           "/></Interfaces>";
  }
  xml += std::string("<AllowMulticast>") + (multicast ? "spdp" : "false") +
         "</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize><FragmentSize>64000B</FragmentSize></General>"
         "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>64</MaxAutoParticipantIndex>"
         "<LeaseDuration>" + std::to_string(options.participant_lease.count()) + "ms</LeaseDuration><SPDPInterval>" +
         std::to_string(settings.announcement.count()) + "ms</SPDPInterval><Ports><UnicastDataOffset>" + std::to_string(kUnicastPortOffset) +
         "</UnicastDataOffset></Ports><Peers>";
  for (const std::string& peer : options.peers) xml += "<Peer Address=\"" + peer + "\"/>";
  if (!multicast && !settings.interface.address.empty()) xml += "<Peer Address=\"" + settings.interface.address + "\"/>";
  // A least buffer size above the system's limit would make the domain fail.
  return xml + "</Peers></Discovery><Internal><SocketReceiveBufferSize max=\"8MB\"/></Internal></Domain></CycloneDDS>";
}

// A domain is configured once in a process; several participants (tests only) share it.
class Domain {
 public:
  static std::shared_ptr<Domain> get(const ParticipantSettings& settings) {
    static std::mutex mutex;
    static std::map<int, std::weak_ptr<Domain>> domains;
    const std::lock_guard lock(mutex);
    auto& known = domains[settings.options.domain];
    auto domain = known.lock();
    if (!domain) known = domain = std::make_shared<Domain>(settings);
    return domain;
  }
  explicit Domain(const ParticipantSettings& settings) {
    entity_ = dds_create_domain(static_cast<dds_domainid_t>(settings.options.domain), configuration(settings).c_str());
    if (entity_ < 0) refuse("domain " + std::to_string(settings.options.domain) + " on interface " + settings.options.interface, entity_);
  }
  ~Domain() { dds_delete(entity_); }
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

 private:
  dds_entity_t entity_;
};

class CycloneParticipant : public Participant {
 public:
  CycloneParticipant(const ParticipantSettings& settings, EndpointMatching& matching) : matching_(matching), domain_(Domain::get(settings)) {
    const VendorQos qos;
    dds_qset_entity_name(qos.get(), settings.options.name.c_str());
    participant_ = dds_create_participant(static_cast<dds_domainid_t>(settings.options.domain), qos.get(), nullptr);
    if (participant_ < 0) refuse("a participant in domain " + std::to_string(settings.options.domain), participant_);
    participants_ = dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr);
    publications_ = dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr);
    subscriptions_ = dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr);
  }
  ~CycloneParticipant() override { dds_delete(participant_); }

  std::unique_ptr<Writer> writer(const std::string& name, const Codec& codec, const Qos& qos) override {
    auto writer = std::make_unique<Described<CycloneWriter>>(matching_, participant_, topic(name, codec), name, qos);
    writer->add(describe(writer->guid(), true, name, codec, qos));
    return writer;
  }
  std::unique_ptr<Reader> reader(const std::string& name, const Codec& codec, const Qos& qos) override {
    auto reader = std::make_unique<Described<CycloneReader>>(matching_, participant_, topic(name, codec), name, codec, qos);
    reader->add(describe(reader->guid(), false, name, codec, qos));
    return reader;
  }

  void poll() override {
    take<dds_builtintopic_participant_t>(participants_, [&](const dds_builtintopic_participant_t& p, bool alive) {
      char* name = nullptr;
      if (alive && p.qos && dds_qget_entity_name(p.qos, &name) && name) {
        peers_[convert(p.key)] = name;
        dds_free(name);
      } else if (!alive) {
        peers_.erase(convert(p.key));
      }
    });
    take<dds_builtintopic_endpoint_t>(publications_, [&](const auto& e, bool alive) { endpoint(e, true, alive); });
    take<dds_builtintopic_endpoint_t>(subscriptions_, [&](const auto& e, bool alive) { endpoint(e, false, alive); });
  }

 private:
  template <class Sample, class Use>
  void take(dds_entity_t reader, Use use) {
    constexpr int kBatch = 32;
    for (int n = kBatch; n == kBatch;) {
      void* samples[kBatch] = {};
      dds_sample_info_t infos[kBatch];
      n = dds_take(reader, samples, infos, kBatch, kBatch);
      if (n <= 0) return;
      for (int i = 0; i < n; ++i) use(*static_cast<const Sample*>(samples[i]), infos[i].instance_state == DDS_IST_ALIVE && infos[i].valid_data);
      dds_return_loan(reader, samples, n);
    }
  }

  void endpoint(const dds_builtintopic_endpoint_t& e, bool writer, bool alive) {
    const Guid guid = convert(e.key);
    dds_guid_t own{};
    dds_get_guid(participant_, &own);
    if (std::equal(guid.begin(), guid.begin() + 12, own.v)) return;  // our own endpoints stand in the built-in topics too
    if (!alive) {
      matching_.remove(guid);
      return;
    }
    EndpointDescription d;
    d.guid = guid;
    d.writer = writer;
    d.topic = e.topic_name ? e.topic_name : "";
    d.type = e.type_name ? e.type_name : "";
    if (const auto peer = peers_.find(convert(e.participant_key)); peer != peers_.end()) d.peer = peer->second;
    dds_reliability_kind_t reliability{};
    dds_durability_kind_t durability{};
    dds_liveliness_kind_t liveliness{};
    dds_ownership_kind_t ownership{};
    dds_duration_t ignored = 0, lease = DDS_INFINITY, deadline = DDS_INFINITY;
    d.reliable = !writer;  // the defaults of the specification, should the peer not say
    if (dds_qget_reliability(e.qos, &reliability, &ignored)) d.reliable = reliability == DDS_RELIABILITY_RELIABLE;
    if (dds_qget_durability(e.qos, &durability)) d.durability = static_cast<int>(durability);
    if (dds_qget_liveliness(e.qos, &liveliness, &lease)) d.liveliness = static_cast<int>(liveliness);
    if (dds_qget_deadline(e.qos, &deadline)) d.deadline_ns = deadline;
    if (dds_qget_ownership(e.qos, &ownership)) d.exclusive_ownership = ownership == DDS_OWNERSHIP_EXCLUSIVE;
    d.lease_ns = lease;
    matching_.add_remote(d);
  }

  dds_entity_t topic(const std::string& name, const Codec& codec) {
    const std::lock_guard lock(mutex_);
    auto& [entity, known] = topics_[name];
    if (entity <= 0) {
      entity = cyclonedds::create_topic(participant_, name.c_str(), codec);
      if (entity < 0) refuse("topic " + name, entity);
      known = &codec;
    }
    if (known->type_name != codec.type_name) {
      throw Error(ErrorCode::bad_input, "topic " + name + " carries " + known->type_name + " in this process, not " + codec.type_name);
    }
    return entity;
  }

  EndpointMatching& matching_;
  std::shared_ptr<Domain> domain_;
  dds_entity_t participant_ = 0, participants_ = 0, publications_ = 0, subscriptions_ = 0;
  std::mutex mutex_;
  std::map<std::string, std::pair<dds_entity_t, const Codec*>> topics_;
  std::map<Guid, std::string> peers_;  // of poll() alone
};

}  // namespace

std::unique_ptr<Participant> make_cyclonedds_participant(const ParticipantSettings& settings, EndpointMatching& matching,
                                                         std::atomic<std::uint64_t>&) {
  return std::make_unique<CycloneParticipant>(settings, matching);
}

}  // namespace periplus::dds
