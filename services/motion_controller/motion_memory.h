// What became of each motion, so that a request asked twice is answered alike and moves the robot once.
#pragma once

#include <Eigen/Core>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include "common/core/error.h"
#include "common/geometry/pose.h"

namespace periplus::motion {

struct MotionResult {
  ErrorCode error = ErrorCode::ok;
  std::string message;
  Eigen::VectorXd configuration;  // reached
  Pose2 left, right;
  std::uint64_t ticks = 0;
  double plan_seconds = 0, execute_seconds = 0;
};

// Thread-safe.
class MotionMemory {
 public:
  explicit MotionMemory(std::size_t remembered = 64) : remembered_(remembered) {}

  // Claims the robot for motion `id`; `content` is what was asked for, as text. Nothing: it is the caller's, who must
  // call finish(). A result: it was done before, or by another caller while this one waited. Throws Error(motion_busy)
  // naming the other motion under way, Error(bad_input) if `id` was used for something else.
  std::optional<MotionResult> begin(const std::string& id, const std::string& content);
  // Remembers what was done and what was halted. What failed may be tried again under the same id.
  void finish(const MotionResult& result);

  // Asks the motion under way to halt; false if there is none.
  bool ask_to_halt();
  // Whether the motion under way was asked to.
  bool halt_asked() const;
  // Waits until nothing moves; false if `seconds` pass before.
  bool wait_until_still(double seconds) const;

 private:
  struct Entry {
    std::string id, content;
    MotionResult result;
  };
  std::size_t remembered_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::deque<Entry> done_;  // newest last
  std::optional<Entry> under_way_;
  bool halt_asked_ = false;
};

}  // namespace periplus::motion
