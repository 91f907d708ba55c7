#include "common/service/service.h"
#include "services/motion_controller/motion_controller_service.h"

int main(int argc, char** argv) {
  return periplus::service::run(
      argc, argv, {.name = "motion_controller", .summary = "walks the steps and holds the postures", .options = {}},
      [](periplus::service::Service& service) {
        const periplus::motion::MotionSettings settings = periplus::motion::read_settings(service.configuration());
        service.configuration().finish();
        if (service.check_only()) return;
        const periplus::motion::MotionControllerService controller(service, settings);
        service.ready();
        service.wait_until_stopped();
      });
}
