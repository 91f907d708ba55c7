// Robot YAMLs beside the committed URDF: what is read can be put into its posture.
#include "common/core/file.h"
#include "common/robot/robot_model.h"
#include "integration-tests/fuzz/expected_refusal.h"

using namespace periplus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string urdf = read_file(PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.urdf");
  const auto model = fuzz::result_or_refusal([&] { return robot::RobotModel::load(urdf, std::string(fuzz::text(data, size))); });
  if (!model) return 0;
  fuzz::result_or_refusal([&] { return (*model)->stereo_rig(); });
  const Eigen::VectorXd q = (*model)->half_sitting();
  if (!q.allFinite()) fuzz::finding("half-sitting is no posture");
  robot::Kinematics kinematics(*model);
  kinematics.set(q);
  if (!is_finite(kinematics.X_WS_left()) || !kinematics.center_of_mass().allFinite()) fuzz::finding("a sole or the centre of mass is nowhere");
  for (std::size_t i = 0; i < (*model)->capsules().size(); ++i) {
    Eigen::Vector3d a, b;
    kinematics.capsule(static_cast<int>(i), a, b);
    if (!a.allFinite() || !b.allFinite()) fuzz::finding("a capsule is nowhere");
  }
  return 0;
}
