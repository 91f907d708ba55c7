// URDFs: alone, and as the robot that the committed robot YAML describes, whose postures then are numbers.
#include "common/core/file.h"
#include "common/robot/robot_model.h"
#include "common/robot/urdf.h"
#include "integration-tests/fuzz/expected_refusal.h"

using namespace periplus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string yaml = read_file(PERIPLUS_SOURCE_DIR "/deploy/robots/hrp2like.yaml");
  const std::string xml(fuzz::text(data, size));
  const auto urdf = fuzz::result_or_refusal([&] { return robot::parse_urdf(xml); });
  const auto model = fuzz::result_or_refusal([&] { return robot::RobotModel::load(xml, yaml); });
  if (!model) return 0;
  if (!urdf) fuzz::finding("a robot is made of a URDF that is refused");
  if (!((*model)->mass() >= 0) || !(*model)->half_sitting().allFinite()) fuzz::finding("a robot's mass or posture is no number");
  return 0;
}
