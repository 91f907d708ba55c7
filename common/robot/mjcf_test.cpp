#include "common/robot/mjcf.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <cstdlib>
#include <filesystem>

#include "common/core/error.h"
#include "common/core/file.h"
#include "common/robot/mujoco_model.h"

namespace periplus::robot {

namespace {
const char* const kArm =
    "<robot name='arm'><link name='base'><inertial><mass value='3'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
    "<link name='fore &amp; aft'/><joint name='elbow' type='revolute'><parent link='base'/><child link='fore &amp; aft'/>"
    "<origin xyz='0 0 1'/><axis xyz='0 1 0'/><limit lower='-1' upper='2' effort='5' velocity='3'/></joint></robot>";
}

TEST(Mjcf, BaseJointsThenTheUrdfs) {
  const MjModelPtr model = compile_mjcf(write_mjcf(parse_urdf(kArm), {}, {}), {}, ErrorCode::bad_input);
  ASSERT_EQ(model->nq, 7);
  ASSERT_EQ(model->nv, 7);
  for (int i = 0; i < 6; ++i) EXPECT_EQ(mj_name2id(model.get(), mjOBJ_JOINT, kBaseJoints[i]), i);
  EXPECT_EQ(mj_name2id(model.get(), mjOBJ_JOINT, "elbow"), 6);
  EXPECT_EQ(model->jnt_range[12], -1);
  EXPECT_EQ(model->jnt_range[13], 2);
  EXPECT_GT(mj_name2id(model.get(), mjOBJ_BODY, "fore & aft"), 0);
  EXPECT_NEAR(mj_getTotalmass(model.get()), 3, 1e-6);
}

TEST(Mjcf, CapsulesAndCamerasStandWhereTheyAreSaid) {
  Capsule capsule{.link = "base", .a = {0, 0, 0}, .b = {0, 0, 0.4}, .radius = 0.1, .name = "trunk"};
  Camera camera{.name = "eye", .link = "base", .X_LC = look_along({0.1, 0.2, 0.3}, 0, 0), .pinhole = Pinhole::from_vertical_fov(64, 48, 0.5)};
  const MjModelPtr model = compile_mjcf(write_mjcf(parse_urdf(kArm), {capsule}, {camera}), {}, ErrorCode::bad_input);
  const int geom = mj_name2id(model.get(), mjOBJ_GEOM, "trunk");
  ASSERT_GE(geom, 0);
  EXPECT_NEAR(model->geom_size[3 * geom], 0.1, 1e-12);
  EXPECT_NEAR(model->geom_size[3 * geom + 1], 0.2, 1e-12);
  EXPECT_EQ(model->geom_contype[geom], 0);
  const int eye = mj_name2id(model.get(), mjOBJ_CAMERA, "eye");
  ASSERT_GE(eye, 0);
  EXPECT_NEAR(model->cam_fovy[eye], 0.5 * 180 / 3.14159265358979, 1e-9);
  // MuJoCo's camera looks along its -z axis.
  double R[9];
  mju_quat2Mat(R, model->cam_quat + 4 * eye);
  EXPECT_NEAR(-R[2], 1, 1e-12);
  EXPECT_NEAR(R[7], 1, 1e-12);  // its y axis points up
}

TEST(Mjcf, MujocosRefusalIsPassedOn) {
  try {
    compile_mjcf("<mujoco><worldbody><body/><nothing/></worldbody></mujoco>", {}, ErrorCode::bad_input);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::bad_input);
    EXPECT_NE(std::string(error.what()).find("nothing"), std::string::npos) << error.what();
  }
}

// URDF files of real robots as Debian has them (package dart-doc, unpacked anywhere): read and compiled, or refused with
// a sentence.
TEST(Mjcf, RealRobots) {
  const char* folder = std::getenv("PERIPLUS_URDF_FOLDER");
  if (folder == nullptr) GTEST_SKIP() << "set PERIPLUS_URDF_FOLDER to a folder with URDF files";
  int compiled = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".urdf") continue;
    try {
      const Urdf urdf = parse_urdf(read_file(entry.path()));
      const MjModelPtr model = compile_mjcf(write_mjcf(urdf, {}, {}), {}, ErrorCode::bad_input);
      std::printf("%s: %d links, %d degrees of freedom, %.1f kg\n", entry.path().c_str(), model->nbody - 1, model->nv, mj_getTotalmass(model.get()));
      ++compiled;
    } catch (const Error& error) {
      std::printf("%s: %s\n", entry.path().c_str(), error.what());
    }
  }
  EXPECT_GT(compiled, 0);
}

}  // namespace periplus::robot
