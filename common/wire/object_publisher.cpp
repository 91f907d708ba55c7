#include "common/wire/object_publisher.h"

#include <mutex>
#include <string>

#include "common/core/error.h"
#include "common/dds/codec_impl.h"
#include "common/wire/object_chunks.h"

namespace periplus::wire {

struct ObjectPublisher::Impl {
  explicit Impl(dds::Node& node) : chunks(node, "periplus/object/chunk", dds::qos_latest()), revisions(node, "periplus/object", dds::qos_latest()) {}

  template <class T>
  static std::size_t send(dds::Publisher<T>& out, const T& sample) {
    require(out.publish(sample), ErrorCode::internal, "object " + sample.object_id().to_string() + " could not be published");
    return dds::codec<T>().size(&sample);
  }

  std::mutex mutex;
  ObjectSplitter splitter;
  dds::Publisher<msg::ObjectChunk> chunks;
  dds::Publisher<msg::ObjectRevision> revisions;
};

ObjectPublisher::ObjectPublisher(dds::Node& node) : impl_(std::make_unique<Impl>(node)) {}
ObjectPublisher::~ObjectPublisher() = default;

ObjectPublisher::Sent ObjectPublisher::publish(std::string_view object_id, const voxel::OccupancyGrid& grid,
                                               const std::vector<object_model::Landmark>& landmarks, const std::vector<Pose>& views, bool all) {
  const std::lock_guard lock(impl_->mutex);
  if (all) impl_->splitter.forget(object_id);
  Sent sent;
  try {
    const ObjectOnWire object = impl_->splitter.split(object_id, grid, landmarks, views);
    for (const msg::ObjectChunk& chunk : object.chunks) sent.octets += Impl::send(impl_->chunks, chunk);
    sent.chunks = object.chunks.size();
    sent.octets += Impl::send(impl_->revisions, object.revision);
  } catch (...) {
    impl_->splitter.forget(object_id);
    throw;
  }
  return sent;
}

}  // namespace periplus::wire
