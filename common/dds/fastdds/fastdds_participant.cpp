// Back end on Fast DDS 2.9. The generated *PubSubTypes are not used: they let exceptions escape from hostile payloads
// and overflow on long string keys; our Type goes through the codec.
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <map>
#include <mutex>
#include <set>

#include "common/core/error.h"
#include "common/dds/key_hash.h"
#include "common/dds/participant.h"

namespace periplus::dds {
namespace {

// Writers assert their liveliness several times within this.
constexpr std::chrono::seconds kFirstSign{1};

namespace fdds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::Duration_t;
using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;
using std::chrono::milliseconds;

// Samples that failed to decode on this thread since take() looked last: Fast DDS calls deserialize() within take.
struct DecodeFailures {
  bool taking = false;
  int count = 0;
};
thread_local DecodeFailures decode_failures;

class Type : public fdds::TopicDataType {
 public:
  Type(const Codec& codec, std::atomic<std::uint64_t>& bad_samples) : codec_(codec), bad_samples_(bad_samples) {
    setName(codec.type_name.c_str());
    m_typeSize = 1024;  // of the first allocation; histories reallocate
    m_isGetKeyDefined = codec.keyed;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }

  bool serialize(void* sample, rtps::SerializedPayload_t* payload) override {
    const std::size_t bytes = codec_.encode(sample, payload->data, payload->max_size);
    payload->length = static_cast<std::uint32_t>(bytes);
    payload->encapsulation = CDR_LE;
    return bytes != 0;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* sample) override {
    if (codec_.decode(payload->data, payload->length, sample)) return true;
    if (decode_failures.taking) {
      ++decode_failures.count;
    } else {
      ++bad_samples_;  // a sample without key hash, decoded on the vendor's thread to find its key
    }
    return false;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* sample) override {
    return [this, sample] { return static_cast<std::uint32_t>(codec_.size(sample)); };
  }
  void* createData() override { return codec_.create(); }
  void deleteData(void* sample) override { codec_.destroy(sample); }
  bool getKey(void* sample, rtps::InstanceHandle_t* handle, bool force_md5) override {
    const auto hash = codec_.keyed ? key_hash(codec_, sample, force_md5) : std::nullopt;
    if (!hash) return false;
    for (unsigned i = 0; i < 16; ++i) handle->value[i] = (*hash)[i];
    return true;
  }

 private:
  const Codec& codec_;
  std::atomic<std::uint64_t>& bad_samples_;
};

Duration_t duration(milliseconds d) {
  return Duration_t(static_cast<std::int32_t>(d.count() / 1000), static_cast<std::uint32_t>(d.count() % 1000) * 1000000U);
}

std::int64_t nanoseconds(const Duration_t& d) {
  return d == eprosima::fastrtps::c_TimeInfinite ? std::numeric_limits<std::int64_t>::max() : d.to_ns();
}

Guid convert(const rtps::GUID_t& guid) {
  Guid out;
  std::memcpy(out.data(), guid.guidPrefix.value, 12);
  std::memcpy(out.data() + 12, guid.entityId.value, 4);
  return out;
}

template <class VendorQos>
void set_common(VendorQos& to, const Qos& qos) {
  to.reliability().kind = qos.reliable ? fdds::RELIABLE_RELIABILITY_QOS : fdds::BEST_EFFORT_RELIABILITY_QOS;
  to.durability().kind = qos.transient_local ? fdds::TRANSIENT_LOCAL_DURABILITY_QOS : fdds::VOLATILE_DURABILITY_QOS;
  auto& limits = to.resource_limits();
  limits.max_instances = 0;  // unlimited; the default of 10 would refuse the eleventh key
  if (qos.depth > 0) {
    to.history().kind = fdds::KEEP_LAST_HISTORY_QOS;
    to.history().depth = qos.depth;
    limits.max_samples_per_instance = qos.depth;
    limits.max_samples = 0;
    limits.allocated_samples = std::min(qos.depth, 8);
  } else {
    to.history().kind = fdds::KEEP_ALL_HISTORY_QOS;
    limits.max_samples = limits.max_samples_per_instance = 5000;
    limits.allocated_samples = 8;
  }
  if (qos.liveliness.count() > 0) {
    // Not AUTOMATIC: there Fast DDS 2.9 takes a sign of life of any participant as one of all of them.
    to.liveliness().kind = fdds::MANUAL_BY_TOPIC_LIVELINESS_QOS;
    to.liveliness().lease_duration = duration(qos.liveliness);
  }
  to.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  to.data_sharing().off();  // refuses unbounded types
}

class FastWriter : public Writer, private fdds::DataWriterListener {
 public:
  FastWriter(fdds::Publisher& publisher, fdds::Topic& topic, const fdds::DataWriterQos& qos) : publisher_(publisher) {
    writer_ = publisher.create_datawriter(&topic, qos, this, fdds::StatusMask::publication_matched());
    if (!writer_) throw Error(ErrorCode::internal, "Fast DDS refused a writer on topic " + topic.get_name());
  }
  ~FastWriter() override {
    writer_->set_listener(nullptr);
    publisher_.delete_datawriter(writer_);
  }
  bool write(const void* sample) override { return writer_->write(const_cast<void*>(sample)); }
  bool matched(const Guid& reader) override {
    const std::lock_guard lock(mutex_);
    return readers_.contains(reader);
  }
  int matched_count() override {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(readers_.size());
  }
  std::vector<Guid> matched_readers() override {
    const std::lock_guard lock(mutex_);
    return {readers_.begin(), readers_.end()};
  }
  void assert_liveliness() override { writer_->assert_liveliness(); }
  Guid guid() const { return convert(writer_->guid()); }

 private:
  void on_publication_matched(fdds::DataWriter*, const fdds::PublicationMatchedStatus& status) override {
    const std::lock_guard lock(mutex_);
    const Guid reader = convert(rtps::iHandle2GUID(status.last_subscription_handle));
    if (status.current_count_change > 0) {
      readers_.insert(reader);
    } else {
      readers_.erase(reader);
    }
  }

  fdds::Publisher& publisher_;
  fdds::DataWriter* writer_ = nullptr;
  std::mutex mutex_;
  std::set<Guid> readers_;
};

class FastReader : public Reader, private fdds::DataReaderListener {
 public:
  FastReader(fdds::Subscriber& subscriber, fdds::Topic& topic, const fdds::DataReaderQos& qos, bool liveliness)
      : subscriber_(subscriber), liveliness_(liveliness) {
    reader_ = subscriber.create_datareader(
        &topic, qos, this,
        fdds::StatusMask::data_available() << fdds::StatusMask::subscription_matched() << fdds::StatusMask::liveliness_changed());
    if (!reader_) throw Error(ErrorCode::internal, "Fast DDS refused a reader on topic " + topic.get_name());
  }
  ~FastReader() override {
    reader_->set_listener(nullptr);
    subscriber_.delete_datareader(reader_);
  }

  Take take(void* sample) override {
    if (bad_ > 0) {
      --bad_;
      return Take::bad;
    }
    fdds::SampleInfo info;
    decode_failures = {.taking = true, .count = 0};
    const ReturnCode code = reader_->take_next_sample(sample, &info);
    bad_ = decode_failures.count;
    decode_failures = {};
    if (code == ReturnCode::RETCODE_OK) return info.valid_data ? Take::data : Take::no_data;
    if (bad_ == 0) return Take::none;
    --bad_;
    return Take::bad;
  }
  bool wait(milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    wake_.wait_for(lock, timeout, [&] { return available_ || woken_; });
    const bool available = available_;
    available_ = woken_ = false;
    return available;
  }
  void wake() override {
    const std::lock_guard lock(mutex_);
    woken_ = true;
    wake_.notify_all();
  }
  Guid guid() override { return convert(reader_->guid()); }
  int matched_count() override {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(matched_.size());
  }
  int alive_writers() override { return static_cast<int>(alive_writer_guids().size()); }
  // Fast DDS tells a reader only of changes: one that comes after another reader of the process saw the writer come to life
  // hears nothing. A matched writer that was not heard to die is therefore unknown: it counts while its first sign of life
  // may be under way, and for longer where none is known to be alive.
  std::vector<Guid> alive_writer_guids() override {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    std::vector<Guid> out, unknown;
    for (const auto& [writer, since] : matched_) {
      if (liveliness_ && died_.contains(writer)) continue;
      (!liveliness_ || alive_.contains(writer) || now - since < kFirstSign ? out : unknown).push_back(writer);
    }
    return out.empty() ? unknown : out;
  }

 private:
  void on_data_available(fdds::DataReader*) override {
    const std::lock_guard lock(mutex_);
    available_ = true;
    wake_.notify_all();
  }
  void on_subscription_matched(fdds::DataReader*, const fdds::SubscriptionMatchedStatus& status) override {
    const std::lock_guard lock(mutex_);
    const Guid writer = convert(rtps::iHandle2GUID(status.last_publication_handle));
    if (status.current_count_change > 0) {
      matched_[writer] = std::chrono::steady_clock::now();
    } else {
      matched_.erase(writer);
      alive_.erase(writer);
      died_.erase(writer);
    }
  }
  void on_liveliness_changed(fdds::DataReader*, const eprosima::fastrtps::LivelinessChangedStatus& status) override {
    const std::lock_guard lock(mutex_);
    const Guid writer = convert(rtps::iHandle2GUID(status.last_publication_handle));
    if (status.alive_count_change > 0) {
      alive_.insert(writer);
      died_.erase(writer);
    } else if (status.alive_count_change < 0) {
      alive_.erase(writer);
      if (matched_.contains(writer)) died_.insert(writer);
    }
  }

  fdds::Subscriber& subscriber_;
  const bool liveliness_;
  fdds::DataReader* reader_ = nullptr;
  int bad_ = 0;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool available_ = true;  // a sample may have come before the listener was set
  bool woken_ = false;
  std::map<Guid, std::chrono::steady_clock::time_point> matched_;
  std::set<Guid> alive_, died_;
};

class FastParticipant : public Participant, private fdds::DomainParticipantListener {
 public:
  FastParticipant(const ParticipantSettings& settings, EndpointMatching& matching, std::atomic<std::uint64_t>& bad_samples)
      : matching_(matching), bad_samples_(bad_samples) {
    participant_ = fdds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<std::uint32_t>(settings.options.domain), participant_qos(settings), this, fdds::StatusMask::none());
    if (!participant_) {
      throw Error(ErrorCode::internal, "Fast DDS could not join domain " + std::to_string(settings.options.domain) + " on interface " +
                                           settings.options.interface);
    }
  }
  ~FastParticipant() override {
    participant_->set_listener(nullptr);
    participant_->delete_contained_entities();
    fdds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  std::unique_ptr<Writer> writer(const std::string& topic_name, const Codec& codec, const Qos& qos) override {
    fdds::DataWriterQos q;
    set_common(q, qos);
    q.publish_mode().kind = fdds::SYNCHRONOUS_PUBLISH_MODE;
    q.reliability().max_blocking_time = Duration_t(1, 0);
    q.reliable_writer_qos().times.heartbeatPeriod = duration(milliseconds(100));  // default 3 s: what late joiners would wait
    q.reliable_writer_qos().times.nackResponseDelay = Duration_t(0, 0);
    auto writer = std::make_unique<Described<FastWriter>>(matching_, publisher(qos.partition), topic(topic_name, codec), q);
    writer->add(describe(writer->guid(), true, topic_name, codec, qos));
    return writer;
  }

  std::unique_ptr<Reader> reader(const std::string& topic_name, const Codec& codec, const Qos& qos) override {
    fdds::DataReaderQos q;
    set_common(q, qos);
    q.reliable_reader_qos().times.heartbeatResponseDelay = Duration_t(0, 0);
    auto reader = std::make_unique<Described<FastReader>>(matching_, subscriber(qos.partition), topic(topic_name, codec), q,
                                                          qos.liveliness.count() > 0);
    reader->add(describe(reader->guid(), false, topic_name, codec, qos));
    return reader;
  }

 private:
  static rtps::Locator_t locator(const std::string& address) {
    rtps::Locator_t l;
    l.kind = LOCATOR_KIND_UDPv4;
    rtps::IPLocator::setIPv4(l, address);
    l.port = 0;  // the well-known ports of participants 0 .. maxInitialPeersRange
    return l;
  }

  static fdds::DomainParticipantQos participant_qos(const ParticipantSettings& settings) {
    const NodeOptions& options = settings.options;
    fdds::DomainParticipantQos qos;
    qos.name(options.name.c_str());
    auto& transport = qos.transport();
    transport.use_builtin_transports = false;
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->sendBufferSize = udp->receiveBufferSize = 4U << 20;
    udp->maxInitialPeersRange = 64;
    if (!settings.interface.address.empty()) udp->interfaceWhiteList.push_back(settings.interface.address);
    transport.user_transports.push_back(udp);
    if (options.shared_memory) {
      auto shm = std::make_shared<eprosima::fastdds::rtps::SharedMemTransportDescriptor>();
      shm->segment_size(16U << 20);
      shm->max_message_size(4U << 20);
      transport.user_transports.push_back(shm);
    }
    qos.wire_protocol().port.offsetd3 = kUnicastPortOffset;
    auto& builtin = qos.wire_protocol().builtin;
    builtin.discovery_config.leaseDuration = duration(options.participant_lease);
    builtin.discovery_config.leaseDuration_announcementperiod = duration(settings.announcement);
    if (!options.peers.empty()) {
      // A unicast list of our own keeps Fast DDS from adding its multicast locators.
      builtin.metatrafficUnicastLocatorList.push_back(locator(settings.interface.address.empty() ? "0.0.0.0" : settings.interface.address));
      for (const std::string& peer : options.peers) builtin.initialPeersList.push_back(locator(peer));
      if (!settings.interface.address.empty()) builtin.initialPeersList.push_back(locator(settings.interface.address));
    }
    return qos;
  }

  fdds::Topic& topic(const std::string& name, const Codec& codec) {
    const std::lock_guard lock(mutex_);
    fdds::Topic*& topic = topics_[name];
    if (!topic) {
      if (participant_->find_type(codec.type_name).empty()) {
        fdds::TypeSupport(new Type(codec, bad_samples_)).register_type(participant_);
      }
      topic = participant_->create_topic(name, codec.type_name, fdds::TOPIC_QOS_DEFAULT);
    }
    if (!topic) throw Error(ErrorCode::internal, "Fast DDS refused topic " + name);
    if (topic->get_type_name() != codec.type_name) {
      throw Error(ErrorCode::bad_input, "topic " + name + " carries " + topic->get_type_name() + " in this process, not " + codec.type_name);
    }
    return *topic;
  }
  fdds::Publisher& publisher(const std::string& partition) {
    const std::lock_guard lock(mutex_);
    fdds::Publisher*& publisher = publishers_[partition];
    if (!publisher) {
      fdds::PublisherQos qos;
      if (!partition.empty()) qos.partition().push_back(partition.c_str());
      publisher = participant_->create_publisher(qos);
    }
    if (!publisher) throw Error(ErrorCode::internal, "Fast DDS refused a publisher in partition \"" + partition + "\"");
    return *publisher;
  }
  fdds::Subscriber& subscriber(const std::string& partition) {
    const std::lock_guard lock(mutex_);
    fdds::Subscriber*& subscriber = subscribers_[partition];
    if (!subscriber) {
      fdds::SubscriberQos qos;
      if (!partition.empty()) qos.partition().push_back(partition.c_str());
      subscriber = participant_->create_subscriber(qos);
    }
    if (!subscriber) throw Error(ErrorCode::internal, "Fast DDS refused a subscriber in partition \"" + partition + "\"");
    return *subscriber;
  }

  template <class VendorQos>
  EndpointDescription remote(const rtps::GUID_t& guid, bool writer, const std::string& topic, const std::string& type, const VendorQos& qos) {
    EndpointDescription d;
    d.guid = convert(guid);
    d.writer = writer;
    d.topic = topic;
    d.type = type;
    d.reliable = qos.m_reliability.kind == fdds::RELIABLE_RELIABILITY_QOS;
    d.durability = static_cast<int>(qos.m_durability.kind);
    d.liveliness = static_cast<int>(qos.m_liveliness.kind);
    d.lease_ns = nanoseconds(qos.m_liveliness.lease_duration);
    d.deadline_ns = nanoseconds(qos.m_deadline.period);
    d.exclusive_ownership = qos.m_ownership.kind == fdds::EXCLUSIVE_OWNERSHIP_QOS;
    const std::lock_guard lock(peers_mutex_);
    if (const auto peer = peers_.find(guid.guidPrefix); peer != peers_.end()) d.peer = peer->second;
    return d;
  }
  void on_participant_discovery(fdds::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& info) override {
    const std::lock_guard lock(peers_mutex_);
    if (info.status == rtps::ParticipantDiscoveryInfo::DISCOVERED_PARTICIPANT) {
      peers_[info.info.m_guid.guidPrefix] = info.info.m_participantName.to_string();
    } else if (info.status != rtps::ParticipantDiscoveryInfo::CHANGED_QOS_PARTICIPANT) {
      peers_.erase(info.info.m_guid.guidPrefix);
    }
  }
  void on_publisher_discovery(fdds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    if (info.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER) {
      matching_.remove(convert(info.info.guid()));
    } else {
      matching_.add_remote(remote(info.info.guid(), true, info.info.topicName().to_string(), info.info.typeName().to_string(), info.info.m_qos));
    }
  }
  void on_subscriber_discovery(fdds::DomainParticipant*, rtps::ReaderDiscoveryInfo&& info) override {
    if (info.status == rtps::ReaderDiscoveryInfo::REMOVED_READER) {
      matching_.remove(convert(info.info.guid()));
    } else {
      matching_.add_remote(remote(info.info.guid(), false, info.info.topicName().to_string(), info.info.typeName().to_string(), info.info.m_qos));
    }
  }

  EndpointMatching& matching_;
  std::atomic<std::uint64_t>& bad_samples_;
  fdds::DomainParticipant* participant_ = nullptr;
  std::mutex mutex_;
  std::map<std::string, fdds::Topic*> topics_;
  std::map<std::string, fdds::Publisher*> publishers_;
  std::map<std::string, fdds::Subscriber*> subscribers_;
  std::mutex peers_mutex_;  // taken on the vendor's threads, so never held while calling the vendor
  std::map<rtps::GuidPrefix_t, std::string> peers_;
};

}  // namespace

std::unique_ptr<Participant> make_fastdds_participant(const ParticipantSettings& settings, EndpointMatching& matching,
                                                      std::atomic<std::uint64_t>& bad_samples) {
  return std::make_unique<FastParticipant>(settings, matching, bad_samples);
}

}  // namespace periplus::dds
