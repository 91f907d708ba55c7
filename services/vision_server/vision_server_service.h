// The vision server on the bus: RPC vision/capture and vision/process, topic periplus/perception. README.md lists topics,
// parameters and error codes.
#pragma once

#include <memory>

#include "common/service/service.h"
#include "services/vision_server/settings.h"

namespace periplus::vision {

class VisionServerService {
 public:
  VisionServerService(service::Service& service, const VisionSettings& settings);
  ~VisionServerService();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace periplus::vision
