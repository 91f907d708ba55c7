#include "integration-tests/harness/planner_bench.h"

#include <cmath>

#include "common/core/error.h"
#include "common/core/random.h"
#include "common/dds/codec_impl.h"
#include "common/dds/testing/eventually.h"
#include "common/wire/common_wire.h"
#include "common/wire/object_wire.h"

namespace periplus::harness {

using namespace std::chrono_literals;

namespace {

using voxel::VoxelState;

// The ball as it is known after a look or two, with holes and bumps that a search can get lost in.
voxel::OccupancyGrid half_known_ball() {
  voxel::GridGeometry g;
  g.voxel_size = 0.01;
  g.size = {40, 40, 36};
  g.X_WG = make_pose({-0.2, -0.2, 0.7}, Eigen::Matrix3d::Identity());
  voxel::OccupancyGrid grid(g);
  Random random(3);
  for (int x = 0; x < g.size.x(); ++x) {
    for (int y = 0; y < g.size.y(); ++y) {
      for (int z = 0; z < g.size.z(); ++z) {
        const Eigen::Vector3d p = g.center_world({x, y, z}) - BallOnTable::center();
        const double r = p.norm() + 0.01 * std::sin(40 * p.x() + 25 * p.z());
        const bool unknown = p.x() + 0.3 * p.y() > 0.02 || random.uniform() < 0.05;
        grid.set_state({x, y, z}, r > BallOnTable::kRadius ? VoxelState::empty : unknown ? VoxelState::unknown : VoxelState::known);
      }
    }
  }
  grid.revision = 1;
  return grid;
}

}  // namespace

PlannerBench::PlannerBench(const std::string& name)
    : bench_(name), client_(bench_.node(), "nbv/plan"), environments_(bench_.node(), "periplus/environment", dds::qos_latest()),
      objects_(bench_.node()) {
  environment_ = wire::environment_to_wire("ball-on-table", BallOnTable::scene_yaml(), bench_.robot_yaml(), bench_.robot_urdf());
  environments_.publish(environment_);
  objects_.publish("ball", half_known_ball());
}

Program& PlannerBench::start(const char* vendor, std::vector<std::string> more) {
  more.insert(more.begin(), {"--set", "search.threads=1"});
  const int before = planners();
  Program& program = bench_.start("periplus-nbv-planner", more, {{"PERIPLUS_DDS", vendor}});
  require(dds::testing::eventually([&] { return planners() > before; }), ErrorCode::not_ready, "a planner does not answer\n" + logs());
  return program;
}

msg::PlanViewRequest PlannerBench::request(std::uint32_t evaluations) const {
  msg::PlanViewRequest q;
  q.plan_id("plan");
  q.object_id("ball");
  q.revision(1);
  q.environment_revision(environment_.revision());
  q.rig(wire::to_wire(bench_.robot()->stereo_rig()));
  q.pose_world_camera(wire::to_wire(BallOnTable::view(3)));
  q.height_min_m(1.0);
  q.height_max_m(1.35);
  q.distance_min_m(0.6);
  q.distance_max_m(2.5);
  q.pitch_min_rad(-0.4);
  q.pitch_max_rad(1.0);
  q.seed(1);
  q.max_evaluations(evaluations);
  q.scatter(true);
  return q;
}

dds::RpcResult PlannerBench::ask(msg::PlanViewRequest request, msg::PlanViewReply& reply, dds::CallOptions options) {
  options.deadline = 60s;
  options.wait_for_server = 10s;
  return client_.call(request, reply, options);
}

}  // namespace periplus::harness
