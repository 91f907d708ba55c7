#include "services/model_server/model_server_service.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>

#include "common/core/clock.h"
#include "common/core/error.h"
#include "common/core/hash.h"
#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/object_model/model_export.h"
#include "common/scene/scene.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_publisher.h"
#include "common/wire/object_wire.h"
#include "common/wire/perception_wire.h"
#include "idl/model.h"
#include "idl/vision.h"
#include "services/model_server/model_keeper.h"
#include "services/model_server/ros_topics_service.h"

namespace periplus::model {

namespace {

using Clock = std::chrono::steady_clock;

// The newest perceptions, by view.
class PerceptionBuffer {
 public:
  explicit PerceptionBuffer(int kept) : kept_(static_cast<std::size_t>(kept)) {}

  void put(object_model::Perception perception) {
    auto fresh = std::make_shared<const object_model::Perception>(std::move(perception));
    {
      std::lock_guard lock(mutex_);
      std::erase_if(newest_, [&](const auto& p) { return p->view_id == fresh->view_id; });
      newest_.push_back(std::move(fresh));
      if (newest_.size() > kept_) newest_.pop_front();
    }
    arrived_.notify_all();
  }

  // Null if it does not arrive in time.
  std::shared_ptr<const object_model::Perception> wait(const std::string& view_id, std::chrono::milliseconds timeout) const {
    std::shared_ptr<const object_model::Perception> found;
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, timeout, [&] {
      for (const auto& p : newest_)
        if (p->view_id == view_id) found = p;
      return found != nullptr;
    });
    return found;
  }

 private:
  std::size_t kept_;
  mutable std::mutex mutex_;
  mutable std::condition_variable arrived_;
  std::deque<std::shared_ptr<const object_model::Perception>> newest_;
};

// Checks everything, the robot too, and leaves out what only a simulator may know.
KnownTexts known(const msg::Environment& m) {
  wire::KnownEnvironment parsed = wire::environment_from_wire(m);
  EnvironmentTexts texts = wire::texts_from_wire(m);
  if (parsed.scene.truth) {
    texts.scene_yaml = scene::without_truth(texts.scene_yaml);
    parsed.revision = wire::environment_revision(texts.scene_yaml, texts.robot_yaml, texts.robot_urdf);
    parsed.scene.truth.reset();
  }
  return {std::move(texts), parsed.revision, std::make_shared<const scene::Scene>(std::move(parsed.scene)), parsed.collision};
}

}  // namespace

struct ModelServerService::Impl {
  Impl(service::Service& service, const ModelSettings& s)
      : settings(s),
        keeper(s.store_folder.empty() ? default_store_folder(service.node().options().domain) : s.store_folder, s.carving, s.growth),
        perceptions(s.perceptions_kept),
        environments_out(service.node(), "periplus/environment", dds::qos_latest()),
        objects_out(service.node()),
        files_out(service.node(), "periplus/model/file", dds::qos_stream(4)),
        ros(s.ros_topics ? std::make_unique<RosTopics>(service.node()) : nullptr),
        perceptions_in(service.node(), "periplus/perception", dds::qos_latest(s.perceptions_kept),
                       [this](const msg::Perception& m) { take(m); }) {
    resume();
  }

  // What a killed server knew, for those who still need it.
  void resume() {
    try {
      if (const auto texts = keeper.stored_environment()) {
        keeper.set_environment(known(wire::environment_to_wire(*texts)));
        publish_environment();
      }
    } catch (const Error& e) {
      log::warn("the stored environment cannot be used; send it again", {{"reason", e.what()}});
    }
    for (const auto& model : keeper.models()) {
      publish(model->state().object_id);
      log::info("object taken up from the store", {{"object", model->state().object_id},
                                                   {"revision", std::to_string(model->grid().revision)},
                                                   {"views", std::to_string(model->state().views.size())}});
    }
  }

  void take(const msg::Perception& m) {
    try {
      perceptions.put(wire::from_wire(m));
    } catch (const Error& e) {
      log::warn("perception refused", {{"view", m.view_id().to_string()}, {"reason", e.what()}});
    }
  }

  void publish_environment() { environments_out.publish(wire::environment_to_wire(keeper.environment().texts)); }
  // The newest revision of an object, which it returns, and no older one after it: requests are served at the same time.
  ModelKeeper::Model publish(const std::string& object_id, bool all = false) {
    const std::lock_guard lock(publishing);
    const auto model = keeper.model(object_id);
    std::vector<Pose> views;
    for (const auto& view : model->state().views) views.push_back(view->X_WC);
    if (ros) ros->offer(model);
    const auto sent = objects_out.publish(object_id, model->grid(), model->landmarks(settings.landmarks, &matches[object_id]), views, all);
    log::debug("object published", {{"object", object_id},
                                    {"revision", std::to_string(model->grid().revision)},
                                    {"chunks", std::to_string(sent.chunks)},
                                    {"octets", std::to_string(sent.octets)}});
    return model;
  }

  // The service keeps the servers until its end, after ModelServerService is gone: each handler holds on to this.
  static void serve(const std::shared_ptr<Impl>& self, service::Service& service) {
    service.serve<msg::SetEnvironmentRequest, msg::SetEnvironmentReply>(
        "model/set_environment", [self](const auto& q, auto& r, dds::RpcContext&) {
          const KnownTexts environment = known(q.environment());
          self->keeper.set_environment(environment);
          self->publish_environment();
          r.revision(environment.revision);
        });
    service.serve<msg::EnvironmentRequest, msg::EnvironmentReply>(
        "model/environment", [self](const auto&, auto& r, dds::RpcContext&) { r.environment(wire::environment_to_wire(self->keeper.environment().texts)); });
    service.serve<msg::BeginRequest, msg::BeginReply>("model/begin", [self](const auto& q, auto& r, dds::RpcContext&) {
      const std::string id = wire::id_from_wire(q.object_id(), "object_id");
      const auto model = self->keeper.begin(id, wire::from_wire(q.box()), q.voxel_m(), q.reset());
      self->publish(id);
      r.revision(model->grid().revision);
      r.box(wire::to_wire(model->state().box));
      r.counts(wire::to_wire(model->grid().counts()));
    });
    service.serve<msg::IntegrateRequest, msg::IntegrateReply>(
        "model/integrate", [self](const auto& q, auto& r, dds::RpcContext&) { self->integrate(q, r); });
    service.serve<msg::ReviseRequest, msg::ReviseReply>("model/revise", [self](const auto& q, auto& r, dds::RpcContext&) { self->revise(q, r); });
    service.serve<msg::PublishRequest, msg::PublishReply>("model/publish", [self](const auto& q, auto& r, dds::RpcContext&) {
      const std::string id = wire::id_from_wire(q.object_id(), "object_id");
      self->keeper.model(id);  // says so if there is none, before anything goes out
      self->publish_environment();
      const auto model = self->publish(id, true);
      r.revision(model->grid().revision);
    });
    service.serve<msg::ExportRequest, msg::ExportReply>(
        "model/export", [self](const auto& q, auto& r, dds::RpcContext&) { self->export_model(q, r); });
    service.serve<msg::DigestRequest, msg::DigestReply>("model/digest", [self](const auto& q, auto& r, dds::RpcContext&) {
      const auto model = self->keeper.model(wire::id_from_wire(q.object_id(), "object_id"));
      r.revision(model->grid().revision);
      r.digest(model->digest());
      r.views(static_cast<std::uint32_t>(model->state().views.size()));
      r.counts(wire::to_wire(model->grid().counts()));
    });
  }

  void integrate(const msg::IntegrateRequest& q, msg::IntegrateReply& r) {
    const std::string object_id = wire::id_from_wire(q.object_id(), "object_id");
    const std::string view_id = wire::id_from_wire(q.view_id(), "view_id");
    auto start = Clock::now();
    std::shared_ptr<const object_model::Perception> perception;
    if (!keeper.has_view(object_id, view_id)) perception = perceptions.wait(view_id, settings.perception_wait);
    const double waited = seconds_since(start);
    start = Clock::now();
    const object_model::Integration result = keeper.integrate(object_id, view_id, perception.get());
    const double integrated = seconds_since(start);
    start = Clock::now();
    // The grid goes out before the answer: whoever is asked to plan with the new revision finds it on its way.
    const auto model = publish(object_id);
    r.revision(result.revision);
    r.box(wire::to_wire(model->state().box));
    r.counts(wire::to_wire(result.counts));
    r.found_gain_px(result.found_gain_px);
    r.found_gain_voxels(result.found_gain_voxels);
    r.seconds({wire::named("wait", waited), wire::named("integrate", integrated), wire::named("publish", seconds_since(start))});
    log::info("view integrated", {{"object", object_id},
                                  {"view", view_id},
                                  {"revision", std::to_string(result.revision)},
                                  {"known", std::to_string(result.counts.known)},
                                  {"unknown", std::to_string(result.counts.unknown)},
                                  {"gain_px", std::to_string(result.found_gain_px)},
                                  {"seconds", std::to_string(integrated)}});
  }

  void revise(const msg::ReviseRequest& q, msg::ReviseReply& r) {
    const std::string object_id = wire::id_from_wire(q.object_id(), "object_id");
    std::vector<object_model::BetterPose> better;
    for (const msg::ViewPose& v : q.better())
      better.push_back({wire::id_from_wire(v.view_id(), "view_id"), wire::from_wire(v.pose_world_camera()), wire::covariance_from_wire(v.pose_covariance())});
    std::vector<std::string> without;
    for (const msg::ViewName& v : q.without()) without.push_back(wire::id_from_wire(v.view_id(), "view_id"));
    const auto model = keeper.revise(object_id, better, without);
    publish(object_id);
    r.revision(model->grid().revision);
    r.counts(wire::to_wire(model->grid().counts()));
    r.views(static_cast<std::uint32_t>(model->state().views.size()));
    r.box(wire::to_wire(model->state().box));
    log::info("views revised", {{"object", object_id},
                                {"better", std::to_string(better.size())},
                                {"without", std::to_string(without.size())},
                                {"revision", std::to_string(model->grid().revision)}});
  }

  void export_model(const msg::ExportRequest& q, msg::ExportReply& r) {
    const auto model = keeper.model(wire::id_from_wire(q.object_id(), "object_id"));
    const std::string format = q.format().to_string();
    const std::string data = object_model::export_model(*model, format, settings.carving);
    require(data.size() <= 67108864, ErrorCode::bad_size,
            "the exported model is over 64 MiB and cannot be sent; export it where the server runs, with periplus model export --store, or use larger voxels");
    msg::ModelFile file;
    file.object_id(q.object_id());
    file.revision(model->grid().revision);
    file.format(format);
    file.sha256(sha256_hex(data));
    file.data(wire::text_to_wire(data));
    require(files_out.publish(file), ErrorCode::internal, "the model's file could not be published");
    r.revision(model->grid().revision);
    r.bytes(data.size());
    r.sha256(file.sha256());
  }

  ModelSettings settings;
  ModelKeeper keeper;
  PerceptionBuffer perceptions;
  dds::Publisher<msg::Environment> environments_out;
  std::mutex publishing;
  std::map<std::string, object_model::KeptMatches> matches;  // of each object
  wire::ObjectPublisher objects_out;
  dds::Publisher<msg::ModelFile> files_out;
  std::unique_ptr<RosTopics> ros;
  dds::Subscriber<msg::Perception> perceptions_in;  // last: its thread uses the members above
};

ModelServerService::ModelServerService(service::Service& service, const ModelSettings& settings)
    : impl_(std::make_shared<Impl>(service, settings)) {
  Impl::serve(impl_, service);
}
ModelServerService::~ModelServerService() = default;

}  // namespace periplus::model
