#include "common/service/other_instances.h"
#include "common/service/service.h"
#include "services/model_server/model_server_service.h"
#include "services/model_server/settings.h"

int main(int argc, char** argv) {
  using periplus::service::Service;
  return periplus::service::run(
      argc, argv, {.name = "model_server", .summary = "keeps environment, robot and object models; carves and labels", .options = {}},
      [](Service& service) {
        const auto settings = periplus::model::read_settings(service.configuration());
        if (service.check_only()) return;
        periplus::service::require_alone(service, "model_server", periplus::ErrorCode::bad_input);
        const periplus::model::ModelServerService model(service, settings);
        service.ready();
        service.wait_until_stopped();
      });
}
