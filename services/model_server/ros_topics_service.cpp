#include "services/model_server/ros_topics_service.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/dds/node.h"
#include "common/wire/ros_model_wire.h"
#include "idl/ros2.h"

namespace periplus::model {

namespace {

using Model = std::shared_ptr<const object_model::ObjectModel>;
constexpr const char* kFrame = "world";
constexpr std::chrono::milliseconds kLook{200};  // how often somebody is looked for who began to read

std::int64_t stamp_of(const object_model::ObjectModel& model) { return model.state().views.empty() ? 0 : model.state().views.back()->stamp_ns; }

octomap_msgs::msg::dds_::Octomap_ octomap_of(const object_model::ObjectModel& model) {
  return wire::octomap_to_wire(stamp_of(model), kFrame, model.grid().geometry().voxel_size, object_model::octomap_data(model.grid()));
}
sensor_msgs::msg::dds_::PointCloud2_ points_of(const object_model::ObjectModel& model) {
  return wire::to_wire(stamp_of(model), kFrame, object_model::surface_points(model));
}

template <class Message>
struct Topic {
  Topic(dds::Node& node, const char* topic, Message (*message_of)(const object_model::ObjectModel&))
      : name(topic), make(message_of), out(node, topic, dds::qos_latest()) {}

  void publish(const Model& model) {
    std::vector<dds::Guid> now = out.raw().matched_readers();
    std::sort(now.begin(), now.end());
    const bool somebody_new = !std::includes(readers.begin(), readers.end(), now.begin(), now.end());
    readers = std::move(now);
    if (!model || readers.empty() || (!somebody_new && model == published.lock())) return;
    published = model;
    try {
      if (!out.publish(make(*model))) log::warn("a model could not be published for ROS", {{"topic", name}});
    } catch (const std::exception& e) {
      log::warn("a model could not be made for ROS", {{"topic", name}, {"object", model->state().object_id}, {"reason", e.what()}});
    }
  }

  const char* name;
  Message (*make)(const object_model::ObjectModel&);
  dds::Publisher<Message> out;
  std::weak_ptr<const object_model::ObjectModel> published;
  std::vector<dds::Guid> readers;  // ascending; when it was looked last
};

}  // namespace

struct RosTopics::Impl {
  explicit Impl(dds::Node& node) : octomap(node, "rt/octomap_binary", octomap_of), points(node, "rt/object_points", points_of) {
    thread = std::thread([this] { run(); });
  }
  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stop = true;
    }
    changed.notify_all();
    thread.join();
  }

  void run() {
    std::unique_lock lock(mutex);
    while (!stop) {
      const Model model = newest;
      lock.unlock();
      octomap.publish(model);
      points.publish(model);
      lock.lock();
      changed.wait_for(lock, kLook, [&] { return stop || newest != model; });
    }
  }

  std::mutex mutex;
  std::condition_variable changed;
  Model newest;
  bool stop = false;
  Topic<octomap_msgs::msg::dds_::Octomap_> octomap;
  Topic<sensor_msgs::msg::dds_::PointCloud2_> points;
  std::thread thread;
};

RosTopics::RosTopics(dds::Node& node) : impl_(std::make_unique<Impl>(node)) {}
RosTopics::~RosTopics() = default;

void RosTopics::offer(Model model) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->newest = std::move(model);
  }
  impl_->changed.notify_all();
}

}  // namespace periplus::model
