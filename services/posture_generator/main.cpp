#include "services/posture_generator/posture_generator_service.h"

int main(int argc, char** argv) {
  return periplus::service::run(
      argc, argv, {.name = "posture_generator", .summary = "a whole-body posture that puts the cameras where a view wants them", .options = {}},
      [](periplus::service::Service& service) {
        const auto settings = periplus::posture::read_settings(service.configuration());
        service.configuration().finish();
        if (service.check_only()) return;
        const periplus::posture::PostureGeneratorService posture_generator(service, settings);
        service.ready();
        service.wait_until_stopped();
      });
}
