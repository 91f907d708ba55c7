// Scenes: what is read can be collided with, and nothing of the truth is left in what the robot may know.
#include "common/scene/scene.h"
#include "integration-tests/fuzz/expected_refusal.h"

using namespace periplus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view yaml = fuzz::text(data, size);
  const auto scene = fuzz::result_or_refusal([&] { return scene::parse_scene(yaml, "scene.yaml"); });
  const auto known = fuzz::result_or_refusal([&] { return scene::without_truth(yaml); });
  if (known) {
    const auto robots = fuzz::result_or_refusal([&] { return scene::parse_scene(*known, "known.yaml"); });
    if (robots && robots->truth) fuzz::finding("the robot is told the truth");
  }
  if (!scene) {
    fuzz::accepted = 0;  // what can only be rid of its truth is no scene
    return 0;
  }
  const scene::CollisionWorld world(*scene);
  const scene::Closest c = world.capsule_distance({0, 0, 0.5}, {0.1, 0.2, 1.5}, 0.1, 2);
  if (!(c.distance <= 2)) fuzz::finding("a distance beyond the range, or no number");
  world.first_hit({-1, -1, 1}, {1, 1, 1});
  world.contains_or_floor({0, 0, 0.5});
  return 0;
}
