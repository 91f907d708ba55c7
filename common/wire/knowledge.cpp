#include "common/wire/knowledge.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>

#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/wire/object_wire.h"
#include "idl/model.h"

namespace periplus::wire {

struct Knowledge::Impl {
  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  std::deque<std::shared_ptr<const KnownEnvironment>> environments;  // the one heard of last at the end
  struct Revisions {
    std::deque<std::shared_ptr<const KnownObject>> kept;  // oldest revision first
    std::uint64_t heard = 0;                              // count of samples when it was last heard of
  };
  std::map<std::string, Revisions> objects;
  std::uint64_t samples = 0;
  std::unique_ptr<dds::Subscriber<msg::Environment>> environments_in;
  std::mutex assembling;  // taken before `mutex`
  ObjectAssembler assembler;
  std::unique_ptr<dds::Subscriber<msg::ObjectRevision>> objects_in;
  std::unique_ptr<dds::Subscriber<msg::ObjectChunk>> chunks_in;

  void take(const msg::Environment& sample) {
    {
      // The same texts again (a republication) need not be parsed again.
      std::lock_guard lock(mutex);
      const auto same = std::find_if(environments.begin(), environments.end(), [&](const auto& e) {
        return e->revision == sample.revision().to_string() && e->scene_id == sample.scene_id().to_string();
      });
      if (same != environments.end()) {
        std::rotate(same, same + 1, environments.end());
        return;
      }
    }
    try {
      auto known = std::make_shared<const KnownEnvironment>(environment_from_wire(sample));
      std::lock_guard lock(mutex);
      environments.push_back(std::move(known));
      if (environments.size() > kEnvironmentsKept) environments.pop_front();
    } catch (const std::exception& e) {
      log::warn("environment refused", {{"reason", e.what()}});
      return;
    }
    changed.notify_all();
  }

  // A header or a chunk of an object.
  template <class Sample>
  void take_part(const Sample& sample) {
    try {
      const std::lock_guard in_order(assembling);
      for (auto& object : assembler.take(sample)) keep(std::move(object));
    } catch (const std::exception& e) {
      log::warn("part of an object refused", {{"object", sample.object_id().to_string()}, {"reason", e.what()}});
    }
  }

  void keep(std::shared_ptr<const KnownObject> known) {
    {
      const std::lock_guard lock(mutex);
      Revisions& revisions = objects[known->object_id];
      revisions.heard = ++samples;
      // A revision that is not newer means that the object was begun again: what came before it is void.
      std::erase_if(revisions.kept, [&](const auto& old) { return old->revision >= known->revision; });
      revisions.kept.push_back(std::move(known));
      if (revisions.kept.size() > kRevisionsKept) revisions.kept.pop_front();
      forget_what_is_too_much();
    }
    changed.notify_all();
  }

  // What was heard of last stays, whatever it takes.
  void forget_what_is_too_much() {
    const auto octets = [&] {
      std::size_t sum = 0;
      for (const auto& [id, revisions] : objects)
        for (const auto& object : revisions.kept) sum += 3 * sizeof(std::uint64_t) * object->grid->occupied().size();
      return sum;
    };
    while (objects.size() > kObjectsKept || octets() > kMostOctets) {
      const auto last = std::min_element(objects.begin(), objects.end(), [](const auto& a, const auto& b) { return a.second.heard < b.second.heard; });
      if (objects.size() > 1)
        objects.erase(last);
      else if (last->second.kept.size() > 1)
        last->second.kept.pop_front();
      else
        return;
    }
  }
};

Knowledge::Knowledge(dds::Node& node) : impl_(std::make_unique<Impl>()) {
  Impl* impl = impl_.get();
  impl_->environments_in = std::make_unique<dds::Subscriber<msg::Environment>>(
      node, "periplus/environment", dds::qos_latest(), [impl](const msg::Environment& m) { impl->take(m); });
  const dds::Qos qos = dds::qos_latest(static_cast<int>(kRevisionsKept));
  impl_->chunks_in =
      std::make_unique<dds::Subscriber<msg::ObjectChunk>>(node, "periplus/object/chunk", qos, [impl](const msg::ObjectChunk& m) { impl->take_part(m); });
  impl_->objects_in =
      std::make_unique<dds::Subscriber<msg::ObjectRevision>>(node, "periplus/object", qos, [impl](const msg::ObjectRevision& m) { impl->take_part(m); });
}

Knowledge::~Knowledge() {
  // Their threads use the members declared before them.
  impl_->environments_in.reset();
  impl_->objects_in.reset();
  impl_->chunks_in.reset();
}

std::shared_ptr<const KnownEnvironment> Knowledge::environment(const std::string& revision, std::chrono::milliseconds timeout) const {
  std::unique_lock lock(impl_->mutex);
  std::shared_ptr<const KnownEnvironment> found;
  impl_->changed.wait_for(lock, timeout, [&] {
    for (const auto& e : impl_->environments)
      if (e->revision == revision) found = e;
    return found != nullptr;
  });
  return found;
}

std::shared_ptr<const KnownEnvironment> Knowledge::environment_or_throw(const std::string& revision, ErrorCode not_here,
                                                                        std::chrono::milliseconds timeout) const {
  auto found = environment(revision, timeout);
  require(found != nullptr, not_here,
          "the environment of revision " + revision.substr(0, 12) +
              " has not arrived here; set it with model/set_environment, or have it published again with model/publish");
  return found;
}

std::shared_ptr<const KnownObject> Knowledge::object(const std::string& object_id, std::uint32_t revision,
                                                     std::chrono::milliseconds timeout) const {
  std::unique_lock lock(impl_->mutex);
  std::shared_ptr<const KnownObject> found;
  impl_->changed.wait_for(lock, timeout, [&] {
    const auto object = impl_->objects.find(object_id);
    if (object == impl_->objects.end()) return false;
    const auto& kept = object->second.kept;
    const auto it = std::find_if(kept.begin(), kept.end(), [&](const auto& o) { return o->revision == revision; });
    if (it == kept.end()) return false;
    found = *it;
    return true;
  });
  return found;
}

}  // namespace periplus::wire
