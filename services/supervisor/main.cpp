#include "services/supervisor/supervisor_service.h"

int main(int argc, char** argv) {
  using namespace periplus;
  return service::run(argc, argv, {.name = "supervisor", .summary = "decides what the robot does next, and keeps the whiteboard", .options = {}},
                      [](service::Service& service) {
                        const supervisor::SupervisorSettings settings = supervisor::read_settings(service.configuration());
                        if (service.check_only()) return;
                        supervisor::SupervisorService supervisor(service, settings);
                        service.ready();
                        service.wait_until_stopped();
                      });
}
