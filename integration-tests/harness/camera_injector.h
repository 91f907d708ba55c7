// Stands in for the simulator or a robot's drivers towards vision: answers camera/trigger with stereo images of an
// analytic scene, camera infos, joint states and base pose of one stamp; and spoils them on demand.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/dds/node.h"
#include "common/geometry/pose.h"
#include "common/robot/robot_model.h"
#include "integration-tests/harness/analytic_scene.h"

namespace periplus::harness {

enum class Fault {
  none,
  no_images,          // only joints and base pose come
  lost_once,          // the right image is missing, the first time each view is asked for
  truncated,          // the right image lacks its last octets
  wrong_size,         // the right image has half the height that its camera info says
  wrong_encoding,
  stale,              // the right image is 30 ms old
  blank_right,        // as with a lens cap: noise alone
  not_a_number_pose,  // base pose
  missing_joint,
};

class CameraInjector {
 public:
  // `sigma`: sensor noise in grey levels; the right eye has a gain of 1.03 and an offset of 2.
  CameraInjector(dds::Node& node, AnalyticScene scene, std::shared_ptr<const robot::RobotModel> model, double sigma = 2);
  ~CameraInjector();

  // From now on the left eye stands there; joints are those of half-sitting, the base is where that takes it.
  void stand(const Pose& X_WC);
  void fail_by(Fault fault);
  // Times that the cameras were triggered.
  int triggers() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::harness
