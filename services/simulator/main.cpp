#include <filesystem>

#include "common/core/locate.h"
#include "common/service/service.h"
#include "services/simulator/settings.h"
#include "services/simulator/simulator_service.h"

namespace {

// As given, or among the files that belong to the programs.
std::string shared_file(const std::string& name) {
  if (std::filesystem::exists(name)) return name;
  for (const auto& folder : periplus::share_folders())
    if (std::filesystem::exists(folder / name)) return (folder / name).string();
  return name;
}

}  // namespace

int main(int argc, char** argv) {
  using periplus::service::Service;
  namespace sim = periplus::simulator;
  sim::SimulatorOptions options{"scenes/bunny.yaml", "robots/hrp2like.yaml", false};
  return periplus::service::run(argc, argv,
                                {.name = "simulator",
                                 .summary = "stands in for the robot: its motion and what its cameras see",
                                 .options =
                                     [&](periplus::service::Options& own) {
                                       own.text("--scene", options.scene_file, "scene YAML");
                                       own.text("--robot", options.robot_file, "robot YAML; the URDF stands beside it");
                                       own.flag("--truth", options.truth, "publish the true object in the partition `truth`, for evaluation");
                                     }},
                                [&](Service& service) {
                                  const sim::SimulatorSettings settings = sim::read_settings(service.configuration());
                                  if (service.check_only()) return;
                                  options.scene_file = shared_file(options.scene_file);
                                  options.robot_file = shared_file(options.robot_file);
                                  service.waiting_for("scene and pictures");
                                  const sim::SimulatorService simulator(service, settings, options);
                                  service.ready();
                                  service.wait_until_stopped();
                                });
}
