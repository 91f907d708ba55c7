// The model server on the bus: RPCs and topics of model.idl. README.md lists them with their error codes.
#pragma once

#include <memory>

#include "common/service/service.h"
#include "services/model_server/settings.h"

namespace periplus::model {

class ModelServerService {
 public:
  ModelServerService(service::Service& service, const ModelSettings& settings);
  ~ModelServerService();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace periplus::model
