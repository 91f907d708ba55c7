#include "services/posture_generator/posture_generator_service.h"

#include <chrono>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "common/core/log.h"
#include "common/dds/codec_impl.h"
#include "common/wire/common_wire.h"
#include "common/wire/knowledge.h"
#include "idl/posture.h"
#include "services/posture_generator/posture_generator.h"

namespace periplus::posture {

struct PostureGeneratorService::Impl {
  Impl(service::Service& service, const Settings& s)
      : settings(s),
        knowledge(service.node()),
        server(service.serve<msg::PostureRequest, msg::PostureReply>(
            "posture/generate",
            [this](const msg::PostureRequest& request, msg::PostureReply& reply, dds::RpcContext&) { generate(request, reply); })) {}

  // What follows from the robot is worked out once for each environment.
  std::shared_ptr<const PostureGenerator> generator_for(const wire::KnownEnvironment& environment) {
    const std::lock_guard lock(mutex);
    if (!generator || generator_revision != environment.revision) {
      generator = std::make_shared<const PostureGenerator>(environment.robot, settings);
      generator_revision = environment.revision;
    }
    return generator;
  }

  void generate(const msg::PostureRequest& request, msg::PostureReply& reply) {
    const auto begin = std::chrono::steady_clock::now();
    const std::string posture_id = wire::id_from_wire(request.posture_id(), "posture_id");
    const std::string object_id = wire::id_from_wire(request.object_id(), "object_id", true);
    const Pose X_WC = wire::from_wire(request.pose_world_camera());
    std::optional<Eigen::VectorXd> start;
    if (!request.start().empty()) start = wire::vector_from_wire(request.start(), "start");

    const auto environment =
        knowledge.environment_or_throw(wire::id_from_wire(request.environment_revision(), "environment_revision"), ErrorCode::posture_revision_not_here);
    ObjectObstacle obstacle;
    if (!object_id.empty()) {
      const auto object = knowledge.object(object_id, request.revision());
      require(object != nullptr, ErrorCode::posture_revision_not_here,
              "revision " + std::to_string(request.revision()) + " of object '" + object_id + "' has not arrived here; ask again, or have it published");
      obstacle = ObjectObstacle(*object->grid, settings.object_cell);
    }
    const auto from = generator_for(*environment);
    const auto known = std::chrono::steady_clock::now();
    const Surroundings surroundings{&environment->scene, environment->collision.get(), object_id.empty() ? nullptr : &obstacle};
    const Posture posture = from->generate(X_WC, surroundings, start);
    const auto end = std::chrono::steady_clock::now();

    const auto seconds = [](auto duration) { return std::chrono::duration<double>(duration).count(); };
    reply.seconds({wire::named("knowledge", seconds(known - begin)), wire::named("solve", seconds(end - known))});
    reply.iterations(static_cast<std::uint32_t>(posture.iterations));
    log::info(posture.feasible ? "posture" : "no posture", {{"posture_id", posture_id},
                                                            {"failed_constraint", posture.failed_constraint},
                                                            {"iterations", std::to_string(posture.iterations)},
                                                            {"seconds", std::to_string(seconds(end - known))}});
    if (!posture.feasible) {
      reply.failed_constraint(posture.failed_constraint.substr(0, 64));
      throw_error(ErrorCode::posture_infeasible,
                  "no posture puts the camera there: " + posture.failed_constraint + " cannot be kept; forbid this view and plan another");
    }
    reply.configuration(wire::vector_to_wire(posture.q));
    reply.left_foot(wire::to_wire(posture.left_foot));
    reply.right_foot(wire::to_wire(posture.right_foot));
    reply.center_of_mass(wire::to_wire(posture.center_of_mass));
    reply.camera_error_m(posture.camera_error);
    reply.camera_error_rad(posture.camera_error_angle);
  }

  const Settings settings;
  wire::Knowledge knowledge;
  std::mutex mutex;
  std::shared_ptr<const PostureGenerator> generator;
  std::string generator_revision;
  // Last: its threads end before what they use.
  std::shared_ptr<dds::RpcServer<msg::PostureRequest, msg::PostureReply>> server;
};

PostureGeneratorService::PostureGeneratorService(service::Service& service, const Settings& settings)
    : impl_(std::make_unique<Impl>(service, settings)) {}
PostureGeneratorService::~PostureGeneratorService() = default;

}  // namespace periplus::posture
