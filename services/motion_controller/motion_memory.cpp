#include "services/motion_controller/motion_memory.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace periplus::motion {

std::optional<MotionResult> MotionMemory::begin(const std::string& id, const std::string& content) {
  std::unique_lock lock(mutex_);
  const auto same = [&id, &content](const Entry& e) {
    if (e.id != id) return false;
    require(e.content == content, ErrorCode::bad_input,
            "motion " + id + " was another motion before; give each motion an id of its own");
    return true;
  };
  if (under_way_ && same(*under_way_)) changed_.wait(lock, [this, &id] { return !under_way_ || under_way_->id != id; });
  const auto before = std::find_if(done_.begin(), done_.end(), same);
  if (before != done_.end()) return before->result;
  require(!under_way_, ErrorCode::motion_busy,
          "the robot still executes motion " + (under_way_ ? under_way_->id : std::string()) +
              "; wait for its end or call motion/halt");
  under_way_ = Entry{id, content, {}};
  halt_asked_ = false;
  return std::nullopt;
}

void MotionMemory::finish(const MotionResult& result) {
  {
    const std::lock_guard lock(mutex_);
    PERIPLUS_ASSERT(under_way_.has_value());
    under_way_->result = result;
    // What failed may be asked for again: its reason may be gone, and the motion goes on from where the robot stands.
    if (result.error == ErrorCode::ok || result.error == ErrorCode::motion_halted) {
      done_.push_back(std::move(*under_way_));
    }
    under_way_.reset();
    if (done_.size() > remembered_) done_.pop_front();
  }
  changed_.notify_all();
}

bool MotionMemory::ask_to_halt() {
  const std::lock_guard lock(mutex_);
  halt_asked_ = under_way_.has_value();
  return halt_asked_;
}

bool MotionMemory::halt_asked() const {
  const std::lock_guard lock(mutex_);
  return halt_asked_;
}

bool MotionMemory::wait_until_still(double seconds) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return !under_way_; });
}

}  // namespace periplus::motion
