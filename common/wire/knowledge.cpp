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

namespace {
constexpr std::size_t kRevisionsKept = 4;
}

struct Knowledge::Impl {
  mutable std::mutex mutex;
  mutable std::condition_variable changed;
  std::shared_ptr<const KnownEnvironment> environment;
  std::map<std::string, std::deque<std::shared_ptr<const KnownObject>>> objects;  // oldest revision first
  std::unique_ptr<dds::Subscriber<msg::Environment>> environments_in;
  std::unique_ptr<dds::Subscriber<msg::ObjectGrid>> objects_in;

  void take(const msg::Environment& sample) {
    {
      // The same texts again (a republication) need not be parsed again.
      std::lock_guard lock(mutex);
      if (environment && environment->revision == sample.revision().to_string() &&
          environment->scene_id == sample.scene_id().to_string())
        return;
    }
    try {
      auto known = std::make_shared<const KnownEnvironment>(environment_from_wire(sample));
      std::lock_guard lock(mutex);
      environment = std::move(known);
    } catch (const std::exception& e) {
      log::warn("environment refused", {{"reason", e.what()}});
      return;
    }
    changed.notify_all();
  }

  void take(const msg::ObjectGrid& sample) {
    try {
      auto known = std::make_shared<const KnownObject>(object_from_wire(sample));
      std::lock_guard lock(mutex);
      auto& revisions = objects[known->object_id];
      // A revision that is not newer means that the object was begun again: what came before it is void.
      std::erase_if(revisions, [&](const auto& old) { return old->revision >= known->revision; });
      revisions.push_back(std::move(known));
      if (revisions.size() > kRevisionsKept) revisions.pop_front();
    } catch (const std::exception& e) {
      log::warn("object grid refused", {{"reason", e.what()}});
      return;
    }
    changed.notify_all();
  }
};

Knowledge::Knowledge(dds::Node& node) : impl_(std::make_unique<Impl>()) {
  Impl* impl = impl_.get();
  impl_->environments_in = std::make_unique<dds::Subscriber<msg::Environment>>(
      node, "periplus/environment", dds::qos_latest(), [impl](const msg::Environment& m) { impl->take(m); });
  impl_->objects_in = std::make_unique<dds::Subscriber<msg::ObjectGrid>>(
      node, "periplus/object", dds::qos_latest(kRevisionsKept), [impl](const msg::ObjectGrid& m) { impl->take(m); });
}

Knowledge::~Knowledge() {
  // Their threads use the members declared before them.
  impl_->environments_in.reset();
  impl_->objects_in.reset();
}

std::shared_ptr<const KnownEnvironment> Knowledge::environment(std::chrono::milliseconds timeout) const {
  std::unique_lock lock(impl_->mutex);
  impl_->changed.wait_for(lock, timeout, [&] { return impl_->environment != nullptr; });
  return impl_->environment;
}

std::shared_ptr<const KnownObject> Knowledge::object(const std::string& object_id, std::uint32_t revision,
                                                     std::chrono::milliseconds timeout) const {
  std::unique_lock lock(impl_->mutex);
  std::shared_ptr<const KnownObject> found;
  impl_->changed.wait_for(lock, timeout, [&] {
    const auto object = impl_->objects.find(object_id);
    if (object == impl_->objects.end()) return false;
    const auto it = std::find_if(object->second.begin(), object->second.end(), [&](const auto& o) { return o->revision == revision; });
    if (it == object->second.end()) return false;
    found = *it;
    return true;
  });
  return found;
}

}  // namespace periplus::wire
