// Camera files, those of `periplus calibrate` among them: what is read of one, written as calibration writes it, is the same camera.
#include <cmath>

#include "integration-tests/fuzz/expected_refusal.h"
#include "services/nbv_planner/tool/camera_file.h"
#include "services/vision_server/calibration_file.h"

using namespace periplus;

namespace {

bool same(double a, double b) { return std::abs(a - b) <= 1e-8 * std::abs(a); }

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = fuzz::result_or_refusal([&] { return nbv::parse_camera(fuzz::text(data, size), "camera.yaml"); });
  if (!file) return 0;
  const std::string written = vision::view_camera_yaml(file->rig, "again");
  const StereoRig again = fuzz::must_read("a camera was read and written", [&] { return nbv::parse_camera(written, "again.yaml"); }).rig;
  const Pinhole &a = file->rig.camera, &b = again.camera;
  if (a.width != b.width || a.height != b.height || !same(a.fx, b.fx) || !same(a.fy, b.fy) || !same(a.cx, b.cx) || !same(a.cy, b.cy) ||
      !same(file->rig.baseline, again.baseline))
    fuzz::finding("a camera that was read and written is another one:\n" + written);
  return 0;
}
