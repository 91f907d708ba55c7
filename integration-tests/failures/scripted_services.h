// Stands in for vision, model, planners and motion towards the supervisor: every remote call it makes, answered at once and
// by script, so that a failure happens at the call and with the sentence that a test wants. Nothing is computed.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/core/error.h"
#include "common/dds/node.h"
#include "common/geometry/pose.h"
#include "common/robot/robot_model.h"

namespace periplus::failures {

class ScriptedServices {
 public:
  // `absent`: calls that nobody offers ("nbv/plan").
  ScriptedServices(dds::Node& node, std::shared_ptr<const robot::RobotModel> model, const std::set<std::string>& absent = {});
  ~ScriptedServices();

  // Calls number `first` (from 1) to `last` of `rpc` are answered with this error.
  void fail(const std::string& rpc, ErrorCode code, const std::string& sentence, int first = 1, int last = 1 << 30);
  // From now on `rpc` takes until its caller cancels, and answers motion_halted then.
  void hold(const std::string& rpc);
  // Replies of nbv/plan carry a pose that is not a number, or promise so many voxels.
  void plan_not_a_number();
  void promise(double voxels);
  // What robot/state says of where and what the robot is; nothing, until told.
  void stand_in(const std::string& scene_id, const std::string& scene_revision, const std::string& robot_revision);
  // The object's revision that the model server has from an earlier run, and from which call of model/integrate on it has none of
  // what it was told before.
  void model_revision(std::uint32_t known, int forgotten_at = 0);
  // Says by heartbeat that all services but the supervisor are ready.
  void heartbeat();

  int calls(const std::string& rpc) const;
  // Waits up to 20 s until `rpc` was called.
  bool wait_for_call(const std::string& rpc) const;
  // Environment revisions that requests named.
  std::set<std::string> environment_revisions() const;
  // What motion/set_posture was asked for, in that order.
  std::vector<std::vector<double>> postures() const;
  // Whether each model/begin asked to begin anew.
  std::vector<bool> resets() const;
  // Where the last walk left the robot.
  std::vector<double> walk_end() const;
  // Forbidden poses that each nbv/plan carried; poses that it answered.
  std::vector<std::vector<Pose>> forbidden() const;
  std::vector<Pose> planned() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace periplus::failures
