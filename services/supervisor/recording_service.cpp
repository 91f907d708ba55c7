#include "services/supervisor/recording_service.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/wire/common_wire.h"
#include "common/wire/perception_wire.h"
#include "idl/model.h"
#include "idl/ros2.h"
#include "idl/sim.h"
#include "idl/vision.h"

namespace periplus::supervisor {

namespace {
using RosImage = sensor_msgs::msg::dds_::Image_;
constexpr std::size_t kept = 4;  // of each kind: the newest views

std::int64_t stamp_of(const RosImage& image) {
  return static_cast<std::int64_t>(image.header().stamp().sec()) * 1000000000 + image.header().stamp().nanosec();
}
}  // namespace

struct Recording::Impl {
  explicit Impl(dds::Node& n) : node(n) {}

  dds::Node& node;
  std::mutex mutex;
  std::condition_variable arrived;
  // Samples are large: they are copied once, when they come.
  std::map<std::string, std::map<std::int64_t, std::shared_ptr<const RosImage>>> images;   // camera -> stamp -> image
  std::deque<std::shared_ptr<const msg::Perception>> perceptions;
  std::map<std::string, std::shared_ptr<const msg::ModelFile>> files;                      // SHA-256 -> file
  std::unique_ptr<msg::Truth> truth;

  std::vector<std::unique_ptr<dds::Subscriber<RosImage>>> cameras;
  std::unique_ptr<dds::Subscriber<msg::Perception>> perception;
  std::unique_ptr<dds::Subscriber<msg::ModelFile>> file;
  std::unique_ptr<dds::Subscriber<msg::Truth>> truths;

  // A new reader: the newest truth of each simulator that is alive comes again.
  void read_truth() {
    truths.reset();   // before the lock: it waits for its callback
    {
      const std::lock_guard lock(mutex);
      truth.reset();
    }
    dds::Qos qos = dds::qos_latest(1);
    qos.partition = "truth";
    truths = std::make_unique<dds::Subscriber<msg::Truth>>(node, "periplus/truth", qos, [this](const msg::Truth& t) {
      const std::lock_guard lock(mutex);
      truth = std::make_unique<msg::Truth>(t);
      arrived.notify_all();
    });
  }

  template <class Ready>
  bool wait(std::unique_lock<std::mutex>& lock, std::chrono::milliseconds timeout, Ready ready) {
    return arrived.wait_for(lock, timeout, ready);
  }
};

Recording::Recording(dds::Node& node) : impl_(std::make_unique<Impl>(node)) {
  Impl& i = *impl_;
  for (const auto& [camera, topic] : {std::pair{"left", "rt/stereo/left/image_raw"}, {"right", "rt/stereo/right/image_raw"}, {"wide", "rt/wide/image_raw"}})
    i.cameras.push_back(std::make_unique<dds::Subscriber<RosImage>>(node, topic, dds::qos_stream(8), [&i, name = std::string(camera)](const RosImage& image) {
      auto kept_image = std::make_shared<const RosImage>(image);
      std::lock_guard lock(i.mutex);
      auto& ring = i.images[name];
      ring[stamp_of(image)] = std::move(kept_image);
      while (ring.size() > kept) ring.erase(ring.begin());
      i.arrived.notify_all();
    }));
  i.perception = std::make_unique<dds::Subscriber<msg::Perception>>(node, "periplus/perception", dds::qos_latest(8), [&i](const msg::Perception& p) {
    auto kept_perception = std::make_shared<const msg::Perception>(p);
    std::lock_guard lock(i.mutex);
    i.perceptions.push_back(std::move(kept_perception));
    while (i.perceptions.size() > kept) i.perceptions.pop_front();
    i.arrived.notify_all();
  });
  i.file = std::make_unique<dds::Subscriber<msg::ModelFile>>(node, "periplus/model/file", dds::qos_stream(4), [&i](const msg::ModelFile& f) {
    const std::string data(f.data().begin(), f.data().end());
    const std::string digest = sha256_hex(data);
    if (digest != f.sha256().to_string()) {
      log::warn("a model file arrived damaged and was dropped", {{"format", f.format().to_string()}});
      return;
    }
    auto kept_file = std::make_shared<const msg::ModelFile>(f);
    std::lock_guard lock(i.mutex);
    i.files[digest] = std::move(kept_file);
    i.arrived.notify_all();
  });
  i.read_truth();
}

Recording::~Recording() = default;

void Recording::clear() {
  {
    std::lock_guard lock(impl_->mutex);
    impl_->images.clear();
    impl_->perceptions.clear();
    impl_->files.clear();
  }
  impl_->read_truth();
}

bool Recording::save_images(const RunRecorder& recorder, int look, std::int64_t stamp_ns, std::chrono::milliseconds timeout) {
  std::map<std::string, std::shared_ptr<const RosImage>> found;
  {
    std::unique_lock lock(impl_->mutex);
    const auto all_there = [&] {
      for (const char* camera : {"left", "right", "wide"})
        if (!impl_->images[camera].count(stamp_ns)) return false;
      return true;
    };
    if (!impl_->wait(lock, timeout, all_there)) log::warn("an image of this look did not reach the recorder; its picture is missing in the run folder", {{"look", std::to_string(look)}});
    for (auto& [camera, ring] : impl_->images)
      if (const auto it = ring.find(stamp_ns); it != ring.end()) found[camera] = it->second;
  }
  for (const auto& [camera, image] : found) recorder.save_image(look, camera, wire::from_wire(*image).image);
  return found.size() == 3;
}

bool Recording::save_perception(const RunRecorder& recorder, int look, const std::string& view_id, std::chrono::milliseconds timeout) {
  std::shared_ptr<const msg::Perception> p;
  {
    std::unique_lock lock(impl_->mutex);
    const auto find = [&] {
      for (const auto& candidate : impl_->perceptions)
        if (candidate->view_id().to_string() == view_id) {
          p = candidate;
          return true;
        }
      return false;
    };
    if (!impl_->wait(lock, timeout, find)) {
      log::warn("the perception of this look did not reach the recorder; its depth is missing in the run folder", {{"look", std::to_string(look)}});
      return false;
    }
  }
  recorder.save_perception(look, wire::from_wire(*p));
  return true;
}

bool Recording::save_model(const RunRecorder& recorder, const std::string& name, const std::string& sha256, std::chrono::milliseconds timeout) {
  std::shared_ptr<const msg::ModelFile> file;
  {
    std::unique_lock lock(impl_->mutex);
    if (!impl_->wait(lock, timeout, [&] { return impl_->files.count(sha256) > 0; })) return false;
    file = impl_->files[sha256];
  }
  recorder.save_bytes(name, file->data().data(), file->data().size());
  return true;
}

bool Recording::save_truth(const RunRecorder& recorder) {
  std::lock_guard lock(impl_->mutex);
  if (!impl_->truth) return false;
  const msg::Truth& t = *impl_->truth;
  recorder.save_json("truth.json", {{"scene", t.scene().to_string()},
                                    {"mesh", t.mesh().to_string()},
                                    {"longest_side_m", t.longest_side_m()},
                                    {"up_axis", t.up_axis().to_string()},
                                    {"scale", t.scale()},
                                    {"pose_world_object", to_json(wire::from_wire(t.pose_world_object()))}});
  recorder.save_bytes("truth.ply", t.mesh_ply().data(), t.mesh_ply().size());
  return true;
}

}  // namespace periplus::supervisor
