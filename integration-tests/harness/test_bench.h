// What every test of running programs needs: a domain of its own, a node in it, programs, and the known environment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/dds/node.h"
#include "common/dds/testing/test_domain.h"
#include "common/object_model/perception.h"
#include "common/robot/robot_model.h"
#include "common/scene/scene.h"
#include "integration-tests/harness/analytic_scene.h"
#include "integration-tests/harness/program.h"

namespace periplus::harness {

// A ball on a table in a room: the analytic counterpart of a modelling task.
struct BallOnTable {
  static constexpr double kRadius = 0.15;           // [m]
  static const char* scene_yaml();                  // without the ball
  static Eigen::Vector3d center();
  static object_model::ObjectBox box();             // 5 cm of slack, standing on the table
  static AnalyticScene scene(bool plain = false);
  // Left eye at `azimuth` [rad] around the ball, its middle in both eyes' view.
  static Pose view(double azimuth, double height = 1.2, double distance = 1.15);
};

class TestBench {
 public:
  // In a domain of its own. The vendor of the test's own node comes from PERIPLUS_DDS.
  explicit TestBench(const std::string& name);
  ~TestBench();

  dds::Node& node() { return *node_; }
  std::shared_ptr<const robot::RobotModel> robot() const { return robot_; }
  // Texts of the robot in deploy/robots.
  const std::string& robot_yaml() const { return robot_yaml_; }
  const std::string& robot_urdf() const { return robot_urdf_; }

  // Starts a program of the build ("periplus-vision-server") in this domain, with a folder of its own for what it stores.
  Program& start(const std::string& program, const std::vector<std::string>& arguments = {},
                 const Program::Environment& more = {});
  void stop_all();
  // Folder for what the programs write; removed at the end.
  const std::string& folder() const { return folder_; }
  // What the programs wrote to their standard outputs, for messages of failed tests.
  std::string logs() const;

 private:
  std::string folder_;
  dds::testing::TestDomain domain_;
  std::shared_ptr<dds::Node> node_;
  std::string robot_yaml_, robot_urdf_;
  std::shared_ptr<const robot::RobotModel> robot_;
  std::vector<std::unique_ptr<Program>> programs_;
};

}  // namespace periplus::harness
