// posture/generate over DDS. The only file here that knows wire types.
#pragma once

#include <memory>

#include "common/service/service.h"
#include "services/posture_generator/settings.h"

namespace periplus::posture {

class PostureGeneratorService {
 public:
  // Serves from construction to destruction.
  PostureGeneratorService(service::Service& service, const Settings& settings);
  ~PostureGeneratorService();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::posture
