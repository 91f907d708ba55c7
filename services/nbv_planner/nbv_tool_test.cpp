// periplus-nbv as a person runs it: files in, a pose out.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/object_model/model_file.h"
#include "common/object_model/testing/sphere_views.h"
#include "common/robot/robot_model.h"
#include "services/nbv_planner/tool/camera_file.h"
#include "services/nbv_planner/tool/pose_text.h"

namespace periplus::nbv {
namespace {

struct Answer {
  int status = -1;
  std::string out, err;
  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

class NbvProgram : public ::testing::Test {
 protected:
  static std::filesystem::path folder() { return std::filesystem::temp_directory_path() / ("periplus_nbv_program_test_" + std::to_string(::getpid())); }
  static std::string file(const std::string& name) { return (folder() / name).string(); }
  static void write(const std::string& name, const std::string& text) { std::ofstream(file(name), std::ios::binary) << text; }

  static void SetUpTestSuite() {
    std::filesystem::create_directories(folder());
    // A ball, seen twice from one side.
    object_model::ObjectModel model("ball", object_model::testing::box_around({}), 0.02, {});
    for (int n : {0, 1}) model.integrate(object_model::testing::ideal_view({}, n, 8), {}, {});
    write("ball.periplus", object_model::write_model(model));
    write("hand.yaml", "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\nlimits: {height_m: [0.3, 2.0], distance_m: [0.5, 2.5], pitch_deg: [-60, 80]}\n");
    write("pair.yaml", "resolution_px: [640, 480]\nvertical_fov_deg: 25\nbaseline_m: 0.144\nlimits: {height_m: [0.8, 1.6], distance_m: [0.6, 2.5]}\n");
    write("wall.yaml", "schema: periplus-scene-1\nname: walled\nroom: {size_m: [6, 6, 2.8]}\nsolids:\n"
                       "  - {name: wall, shape: box, size_m: [0.1, 5.9, 2.7], position_m: [-0.6, 0, 1.4]}\n");
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder()); }

  static Answer run(const std::string& arguments) {
    const std::string command = std::string(PERIPLUS_BIN_DIR) + "/periplus-nbv " + arguments + " 2>" + file("err");
    Answer r;
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return r;
    char buffer[4096];
    for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) r.out.append(buffer, n);
    const int status = ::pclose(pipe);
    r.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    r.err = read_file(file("err"));
    return r;
  }
  static std::string ball(const std::string& camera) { return file("ball.periplus") + " " + file(camera) + " --max-evaluations 300 "; }
  // Refused with status 2; `says` is in the sentence.
  static void refused(const std::string& arguments, const std::string& says) {
    const Answer r = run(arguments);
    EXPECT_EQ(r.status, 2) << arguments << "\n" << r.err;
    EXPECT_NE(r.err.find(says), std::string::npos) << arguments << "\n" << r.err;
    EXPECT_TRUE(r.out.empty()) << r.out;
  }
};

TEST_F(NbvProgram, FindsAViewOfTheSideNotSeenYet) {
  for (const char* camera : {"hand.yaml", "pair.yaml"}) {
    const Answer r = run(ball(camera) + "--json");
    ASSERT_EQ(r.status, 0) << r.err;
    const auto j = r.json();
    EXPECT_EQ(j.at("schema"), "periplus-nbv-1");
    EXPECT_EQ(j.at("result"), "view");
    EXPECT_EQ(j.at("model").at("object"), "ball");
    EXPECT_EQ(j.at("model").at("views"), 2);
    EXPECT_GT(j.at("gain").at("voxels").get<int>(), 100) << camera;
    EXPECT_EQ(j.at("terms").at("N_u"), j.at("gain").at("voxels"));
    EXPECT_LE(j.at("evaluations").get<int>(), 300);
    // The two views looked from +x and from a little beside it: the other side is unknown.
    const auto p = j.at("view").at("position_m");
    EXPECT_LT(p[0].get<double>(), 0.3) << camera;
    // The three ways of writing the pose are one pose.
    const Pose X = parse_pose(j.at("view").at("text").get<std::string>(), "text");
    const auto q = j.at("view").at("quaternion_wxyz");
    const Eigen::Quaterniond rotation(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>());
    EXPECT_LT(angle_between(X, make_pose(X.translation(), rotation.toRotationMatrix())), 1e-5);
    EXPECT_NEAR(X.translation().x(), p[0].get<double>(), 1e-6);
  }
}

TEST_F(NbvProgram, TheSameForAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  const auto pose = [&](const std::string& arguments) { return run(ball("pair.yaml") + "--json " + arguments).json().at("view").at("text").get<std::string>(); };
  const std::string one = pose("--threads 1 --seed 3");
  EXPECT_EQ(one, pose("--threads 3 --seed 3"));
  EXPECT_NE(one, pose("--threads 1 --seed 4"));
}

TEST_F(NbvProgram, AForbiddenPoseDoesNotComeBack) {
  std::string forbid;
  std::vector<Pose> answers;
  for (int i = 0; i < 3; ++i) {
    const Answer r = run(ball("pair.yaml") + "--json" + forbid);
    ASSERT_EQ(r.status, 0) << r.err;
    const std::string text = r.json().at("view").at("text");
    EXPECT_EQ(r.json().at("forbidden").size(), answers.size());
    const Pose X = parse_pose(text, "answer");
    for (const Pose& other : answers)
      EXPECT_TRUE((other.translation() - X.translation()).norm() > 0.10 || angle_between(other, X) > 0.1745);
    answers.push_back(X);
    forbid += " --forbid " + text;  // may begin with a minus
  }
}

TEST_F(NbvProgram, WhereTheMotionIsDearItStaysNear) {
  const auto distance = [&](const std::string& from, const std::string& weight) {
    const Answer r = run(ball("hand.yaml") + "--json --from " + from + " --set evaluation.lambda_motion=" + weight);
    EXPECT_EQ(r.status, 0) << r.err;
    return (parse_pose(r.json().at("view").at("text").get<std::string>(), "").translation() - parse_pose(from, "").translation()).norm();
  };
  const auto both_ways = [&](const std::string& weight) { return distance("0,1.2,1.1,-90,0", weight) + distance("-0.2,-1.2,1.1,90,0", weight); };
  EXPECT_LT(both_ways("5"), 0.75 * both_ways("0"));
}

TEST_F(NbvProgram, PrintsForAPerson) {
  const Answer r = run(ball("hand.yaml") + "--method thesis");
  ASSERT_EQ(r.status, 0) << r.err;
  for (const char* word : {"ball", "position", "yaw", "rotation", "gain", "N_u", "K_distance", "thesis, seed 1", "evaluations", "landmark term"})
    EXPECT_NE(r.out.find(word), std::string::npos) << word << "\n" << r.out;
}

TEST_F(NbvProgram, AWallHidesTheUnknownSideOrLeavesNoView) {
  // The wall stands where the view from behind would be taken: from the other side the back is not seen as well.
  const Answer free = run(ball("pair.yaml") + "--json"), walled = run(ball("pair.yaml") + "--json --scene " + file("wall.yaml"));
  ASSERT_EQ(walled.status, 0) << walled.err;
  EXPECT_EQ(walled.json().at("scene"), "walled");
  EXPECT_GT(walled.json().at("view").at("position_m")[0].get<double>(), -0.6);
  EXPECT_LT(walled.json().at("gain").at("voxels").get<int>(), free.json().at("gain").at("voxels").get<int>());

  write("low.yaml", "resolution_px: [640, 480]\nvertical_fov_deg: 25\nlimits: {height_m: [3, 3.1], pitch_deg: [-60, -50]}\n");
  const Answer none = run(ball("low.yaml") + "--json");
  EXPECT_EQ(none.status, 4);
  EXPECT_EQ(none.json().at("result"), "no_reachable_view");
  EXPECT_FALSE(none.json().contains("view"));
  EXPECT_NE(none.json().at("reason").get<std::string>().find("limits"), std::string::npos);
}

TEST_F(NbvProgram, DrawsPicturesAndMaps) {
  const Answer r = run(ball("pair.yaml") + "--picture " + file("view.svg") + " --map N_u,K_distance " + file("map.png") + " --map-step 0.25");
  ASSERT_EQ(r.status, 0) << r.err;
  EXPECT_NE(r.out.find("position"), std::string::npos);
  EXPECT_EQ(read_file(file("view.svg")).find("<?xml"), 0u);
  EXPECT_EQ(read_file(file("map.png")).find("\x89PNG"), 0u);
  const Answer map = run(ball("pair.yaml") + "--map N_u " + file("map.csv") + " --map-step 0.5 --map-half-width 1");
  ASSERT_EQ(map.status, 0) << map.err;
  EXPECT_EQ(map.out, file("map.csv") + "\n");
  EXPECT_EQ(read_file(file("map.csv")).find("x_m,y_m,z_m,N_u\n"), 0u);
}

TEST_F(NbvProgram, SaysWhatToDoAboutBadInput) {
  const std::string model = file("ball.periplus"), hand = file("hand.yaml");
  refused("", "model");
  refused(file("absent.periplus") + " " + hand, "absent.periplus");
  refused(model + " " + file("absent.yaml"), "absent.yaml");
  refused(hand + " " + hand, "periplus model export");  // a YAML is no model
  std::string text = read_file(model);
  text[text.size() / 2] ^= 1;
  write("flipped.periplus", text);
  refused(file("flipped.periplus") + " " + hand, "flipped.periplus");
  write("half.periplus", read_file(model).substr(0, 2000));
  refused(file("half.periplus") + " " + hand, "half.periplus");
  // Another version of the file, its checksum right.
  text = read_file(model);
  text[std::string("PERIPLUS-MODEL ").size()] = '9';
  write("newer.periplus", text);
  refused(file("newer.periplus") + " " + hand, "version 9; this program reads versions 1 to 4");

  write("key.yaml", "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\nbase_line_m: 0.1\n");
  refused(model + " " + file("key.yaml"), "baseline_m");
  write("limits.yaml", "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\nlimits: {height_m: [2, 1]}\n");
  refused(model + " " + file("limits.yaml"), "least < greatest");
  write("nan.yaml", "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\nlimits: {height_m: [.nan, 1]}\n");
  refused(model + " " + file("nan.yaml"), "height_m");
  write("yaml.yaml", "resolution_px: [640, 480\n");
  refused(model + " " + file("yaml.yaml"), "yaml.yaml");
  write("scene.yaml", "resolution_px: [640, 480]\nhorizontal_fov_deg: 60\nscene: absent-scene.yaml\n");
  refused(model + " " + file("scene.yaml"), "absent-scene.yaml");

  const std::string both = model + " " + hand + " ";
  refused(both + "--forbid 1,2,3", "--forbid");
  refused(both + "--forbid 1,2,nan,4,5", "finite");
  refused(both + "--map K_distence " + file("m.png"), "K_distance");
  refused(both + "--map N_u " + file("m.jpg"), ".csv");
  refused(both + "--picture " + file("p.gif"), ".svg");
  refused(both + "--picture " + file("absent/p.png"), "absent/p.png");
  refused(both + "--method best", "method");
  refused(both + "--max-evaluations many", "max_evaluations");
  refused(both + "--set search.metod=fast", "method");
  refused(both + "--set nonsense", "key=value");
  refused(both + "--config " + file("absent-config.yaml"), "absent-config.yaml");
  refused(both + "--time-limit -1", "time-limit");
}

TEST_F(NbvProgram, LoadsNoMiddleware) {
  const std::string program = std::string(PERIPLUS_BIN_DIR) + "/periplus-nbv";
  FILE* pipe = ::popen(("ldd " + program).c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string out;
  char buffer[4096];
  for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;) out.append(buffer, n);
  ::pclose(pipe);
  EXPECT_NE(out.find("libcairo"), std::string::npos) << out;
  for (const char* library : {"fastrtps", "fastcdr", "ddsc"}) EXPECT_EQ(out.find(library), std::string::npos) << library;
}

// deploy/cameras says the same as the robot that it stands for, and every file there is read.
TEST(CamerasOfDeploy, AgreeWithTheRobot) {
  const std::string deploy = std::string(PERIPLUS_SOURCE_DIR) + "/deploy/";
  for (const auto& entry : std::filesystem::directory_iterator(deploy + "cameras")) EXPECT_NO_THROW(load_camera(entry.path().string())) << entry.path();
  const CameraFile pair = load_camera(deploy + "cameras/hrp2like-pair.yaml");
  const auto robot = robot::RobotModel::load_files(deploy + "robots/hrp2like.urdf", deploy + "robots/hrp2like.yaml");
  EXPECT_NEAR(pair.rig.baseline, robot->stereo_rig().baseline, 1e-6);
  EXPECT_NEAR(pair.rig.camera.fx, robot->stereo_rig().camera.fx, 1e-6);
  EXPECT_NEAR(pair.rig.camera.cx, robot->stereo_rig().camera.cx, 1e-6);
  const robot::ViewLimits &a = pair.limits, &b = robot->view_limits();
  for (const auto& [x, y] : {std::pair{a.height_min, b.height_min}, {a.height_max, b.height_max}, {a.distance_min, b.distance_min}, {a.distance_max, b.distance_max},
                             {a.pitch_min, b.pitch_min}, {a.pitch_max, b.pitch_max}, {a.roll_max, b.roll_max}, {a.yaw_min, b.yaw_min}, {a.yaw_max, b.yaw_max}})
    EXPECT_NEAR(x, y, 1e-9);
  ASSERT_TRUE(pair.body);
  EXPECT_TRUE(pair.body->lower.isApprox(robot->body_box().lower) && pair.body->upper.isApprox(robot->body_box().upper));
}

}  // namespace
}  // namespace periplus::nbv
