#include "common/service/service.h"
#include "services/vision_server/image_memory.h"
#include "services/vision_server/settings.h"
#include "services/vision_server/vision_server_service.h"

int main(int argc, char** argv) {
  using periplus::service::Service;
  return periplus::service::run(
      argc, argv, {.name = "vision_server", .summary = "cameras in; depth, features and camera poses out", .options = {}},
      [](Service& service) {
        const auto settings = periplus::vision::read_settings(service.configuration());
        if (service.check_only()) return;
        periplus::vision::keep_image_memory();
        const periplus::vision::VisionServerService vision(service, settings);
        service.ready();
        service.wait_until_stopped();
      });
}
