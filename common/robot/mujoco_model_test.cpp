#include "common/robot/mujoco_model.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <thread>

namespace periplus::robot {
namespace {

std::string ball_of(const std::string& name) {
  return "<mujoco><worldbody><body name=\"" + name + "\"><geom size=\"0.1\"/></body></worldbody></mujoco>";
}

ErrorCode code_of_mujoco_error() {
  try {
    mju_error("provoked");
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "MuJoCo: provoked");
    return error.code();
  }
  return ErrorCode::ok;
}

TEST(MujocoModel, RefusalCarriesItsWordsAndTheCodeAskedFor) {
  try {
    compile_mjcf("<mujoco><nonsense/></mujoco>", {}, ErrorCode::sim_scene_bad);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::sim_scene_bad);
    EXPECT_NE(std::string(error.what()).find("nonsense"), std::string::npos) << error.what();
  }
}

TEST(MujocoModel, ErrorsAreExceptionsOfTheInnermostCode) {
  const MujocoErrors outer(ErrorCode::sim_render_failed);
  {
    const MujocoErrors inner(ErrorCode::bad_input);
    EXPECT_EQ(code_of_mujoco_error(), ErrorCode::bad_input);
  }
  EXPECT_EQ(code_of_mujoco_error(), ErrorCode::sim_render_failed);
  std::thread([] { EXPECT_EQ(code_of_mujoco_error(), ErrorCode::internal); }).join();
}

TEST(MujocoModel, SeveralThreadsMayCompile) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([t] {
      for (int i = 0; i < 25; ++i) {
        const std::string name = "ball" + std::to_string(t) + "." + std::to_string(i);
        const MjModelPtr model = compile_mjcf(ball_of(name), {}, ErrorCode::bad_input);
        EXPECT_EQ(mj_name2id(model.get(), mjOBJ_BODY, name.c_str()), 1);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(MujocoModel, TooManyFilesAreRefused) {
  std::vector<std::pair<std::string, std::string>> files;
  for (int i = 0; i <= mjMAXVFS; ++i) files.emplace_back("f" + std::to_string(i) + ".txt", "x");
  EXPECT_THROW(compile_mjcf(ball_of("a"), files, ErrorCode::sim_scene_bad), Error);
}

}  // namespace
}  // namespace periplus::robot
