// MuJoCo in one process: compiling models from several threads, and its errors as exceptions. Left alone, MuJoCo keeps the
// last XML that was read in a global, and ends the process with whatever it cannot do.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/core/error.h"

struct mjModel_;

namespace periplus::robot {

struct MjModelDeleter {
  void operator()(mjModel_* model) const;
};
using MjModelPtr = std::unique_ptr<mjModel_, MjModelDeleter>;

// Compiles MJCF that refers to `files` (name, bytes) by name; nothing is read from disk. Safe from several threads.
// Throws Error(refusal) with MuJoCo's own words.
MjModelPtr compile_mjcf(const std::string& mjcf, const std::vector<std::pair<std::string, std::string>>& files, ErrorCode refusal);

// While it lives, what MuJoCo cannot do on this thread is Error(code); without one it is Error(internal).
class MujocoErrors {
 public:
  explicit MujocoErrors(ErrorCode code);
  ~MujocoErrors();
  MujocoErrors(const MujocoErrors&) = delete;
  MujocoErrors& operator=(const MujocoErrors&) = delete;

 private:
  ErrorCode outer_;
};

}  // namespace periplus::robot
