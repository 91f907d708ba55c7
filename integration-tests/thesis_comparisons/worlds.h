// Objects as the thesis' planner meets them (3.4): on a table or on the floor, carved a few times, seen by one camera.
// World frame W, metres, radians; camera poses are those of the optical frame.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "integration-tests/nbv_benchmark/arena.h"
#include "integration-tests/nbv_benchmark/reconstruction.h"
#include "integration-tests/nbv_benchmark/subject.h"
#include "services/nbv_planner/evaluation.h"

namespace periplus::thesis_comparisons {

// The camera of 4.1.1 in 640x480, and 4.1.2: height, pitch and (little) roll. No farthest distance: the thesis has none.
Pinhole thesis_camera();
robot::ViewLimits thesis_limits();
// 3.4.7: p 6, gamma 20, more than 5 pixels a voxel; each penalty as large as the largest N_u where its constraint is violated
// (3.2.1.5). No landmarks.
nbv::EvaluationSettings thesis_evaluation();

struct World {
  nbv_benchmark::Subject subject;
  nbv_benchmark::Arena arena;
};
World on_table(nbv_benchmark::Subject subject, std::shared_ptr<const robot::RobotModel> robot);
World on_floor(nbv_benchmark::Subject subject, std::shared_ptr<const robot::RobotModel> robot);

// Shapes with holes, steps and insides, beside those that can be fetched: ring, box without a lid, stairs, arch.
std::vector<std::pair<std::string, mesh::TriangleMesh>> generated_shapes();

// What carving from a pose adds: true depth of each pixel.
nbv_benchmark::Look look(const World& world, const Pose& X_WC);
// A feasible pose that looks at the middle of the object from about `azimuth`; the same for the same seed.
Pose pose_around(const nbv::Evaluator& evaluator, const World& world, double azimuth, std::uint64_t seed);

// A state of the model, ready to be planned on. Address fixed: the evaluator refers to the situation.
struct State {
  std::string object;
  double size = 0;           // longest side [m]
  nbv::Situation situation;
  std::unique_ptr<nbv::Evaluator> evaluator;
  Pose last;                 // where it was carved from last
  std::vector<Pose> starts;  // poses around it from which something unknown is seen
  double greatest = 1;       // the largest N_u of some hundred poses around it
};
// After `views` looks from around the object.
std::unique_ptr<State> carved(const World& world, int views, int starts, std::uint64_t seed);

}  // namespace periplus::thesis_comparisons
