#include "common/service/service.h"
#include "services/nbv_planner/nbv_planner_service.h"
#include "services/nbv_planner/settings.h"

int main(int argc, char** argv) {
  using periplus::service::Service;
  return periplus::service::run(argc, argv, {.name = "nbv_planner", .summary = "where to look from next", .options = {}},
                                [](Service& service) {
                                  const auto settings = periplus::nbv::read_settings(service.configuration());
                                  if (service.check_only()) return;
                                  const periplus::nbv::NbvPlannerService planner(service, settings);
                                  service.ready();
                                  service.wait_until_stopped();
                                });
}
