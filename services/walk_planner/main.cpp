#include "common/service/service.h"
#include "services/walk_planner/walk_planner_service.h"

int main(int argc, char** argv) {
  return periplus::service::run(
      argc, argv, {.name = "walk_planner", .summary = "the steps that lead to a posture", .options = {}},
      [](periplus::service::Service& service) {
        const periplus::walk::WalkSettings settings = periplus::walk::read_settings(service.configuration());
        service.configuration().finish();
        if (service.check_only()) return;
        const periplus::walk::WalkPlannerService planner(service, settings);
        service.ready();
        service.wait_until_stopped();
      });
}
