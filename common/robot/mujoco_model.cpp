#include "common/robot/mujoco_model.h"

#include <mujoco/mujoco.h>

#include <array>
#include <cstring>
#include <limits>
#include <mutex>

namespace periplus::robot {

namespace {

thread_local ErrorCode mujoco_error_code = ErrorCode::internal;

void throw_mujoco_error(const char* message) { throw_error(mujoco_error_code, std::string("MuJoCo: ") + message); }

void install_error_handler() {
  static std::once_flag once;
  std::call_once(once, [] { mju_user_error = throw_mujoco_error; });
}

struct DeleteFiles {
  void operator()(mjVFS* files) const {
    mj_deleteVFS(files);
    delete files;
  }
};

void add_file(mjVFS& files, const std::string& name, const std::string& bytes, ErrorCode refusal) {
  require(bytes.size() <= static_cast<std::size_t>(std::numeric_limits<int>::max()) &&
              mj_makeEmptyFileVFS(&files, name.c_str(), static_cast<int>(bytes.size())) == 0,
          refusal, "MuJoCo takes no more parts: " + name + " is one too many, or too large");
  std::memcpy(files.filedata[mj_findFileVFS(&files, name.c_str())], bytes.data(), bytes.size());
}

}  // namespace

void MjModelDeleter::operator()(mjModel_* model) const { mj_deleteModel(model); }

MujocoErrors::MujocoErrors(ErrorCode code) : outer_(mujoco_error_code) {
  install_error_handler();
  mujoco_error_code = code;
}
MujocoErrors::~MujocoErrors() { mujoco_error_code = outer_; }

MjModelPtr compile_mjcf(const std::string& mjcf, const std::vector<std::pair<std::string, std::string>>& files, ErrorCode refusal) {
  constexpr const char* kMain = "model.xml";
  const MujocoErrors errors(refusal);
  std::unique_ptr<mjVFS, DeleteFiles> all(new mjVFS);
  mj_defaultVFS(all.get());
  for (const auto& [name, bytes] : files) add_file(*all, name, bytes, refusal);
  add_file(*all, kMain, mjcf, refusal);
  std::array<char, 1024> error{};
  static std::mutex parsing;
  const std::lock_guard lock(parsing);
  MjModelPtr model(mj_loadXML(kMain, all.get(), error.data(), static_cast<int>(error.size())));
  require(model != nullptr, refusal, std::string("MuJoCo refuses the model: ") + error.data());
  return model;
}

}  // namespace periplus::robot
