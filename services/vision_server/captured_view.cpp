#include "services/vision_server/captured_view.h"

#include <cstdlib>
#include <limits>

namespace periplus::vision {

namespace {
constexpr std::size_t kReadingsKept = 8;

std::uint64_t apart(std::int64_t a, std::int64_t b) {
  return a > b ? static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b)
               : static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a);
}
}  // namespace

template <class T>
void ViewCollector::Track<T>::add(std::int64_t stamp, T value) {
  // The same reading may be published again: the newest copy counts.
  std::erase_if(readings, [&](const auto& r) { return r.first == stamp; });
  readings.emplace_back(stamp, std::move(value));
  if (readings.size() > kReadingsKept) readings.pop_front();
}

template <class T>
const T* ViewCollector::Track<T>::find(std::int64_t stamp, std::int64_t tolerance) const {
  const T* best = nullptr;
  std::uint64_t nearest = std::numeric_limits<std::uint64_t>::max();
  for (const auto& [at, value] : readings)
    if (const std::uint64_t d = apart(at, stamp); d <= static_cast<std::uint64_t>(tolerance) && d < nearest) {
      nearest = d;
      best = &value;
    }
  return best;
}

void ViewCollector::add_image(Part eye, std::int64_t stamp_ns, ImageU8 image) {
  const std::lock_guard lock(mutex_);
  (eye == Part::left ? left_ : right_).add(stamp_ns, std::move(image));
  changed_.notify_all();
}

void ViewCollector::add_calibration(Part eye, std::int64_t stamp_ns, CameraCalibration calibration) {
  const std::lock_guard lock(mutex_);
  (eye == Part::left_calibration ? left_calibration_ : right_calibration_).add(stamp_ns, std::move(calibration));
  changed_.notify_all();
}

void ViewCollector::add_joints(std::int64_t stamp_ns, JointPositions joints) {
  const std::lock_guard lock(mutex_);
  joints_.add(stamp_ns, std::move(joints));
  changed_.notify_all();
}

void ViewCollector::add_base_pose(std::int64_t stamp_ns, const Pose& X_WB) {
  const std::lock_guard lock(mutex_);
  base_pose_.add(stamp_ns, X_WB);
  changed_.notify_all();
}

void ViewCollector::add_fault(const std::string& why) {
  const std::lock_guard lock(mutex_);
  fault_ = why;
}

std::optional<CapturedView> ViewCollector::wait(std::int64_t stamp_ns, std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, timeout, [&] { return missing_parts(stamp_ns).empty(); })) return std::nullopt;
  return CapturedView{stamp_ns,
                      *left_.find(stamp_ns, tolerance_ns_),
                      *right_.find(stamp_ns, tolerance_ns_),
                      *left_calibration_.find(stamp_ns, tolerance_ns_),
                      *right_calibration_.find(stamp_ns, tolerance_ns_),
                      *joints_.find(stamp_ns, tolerance_ns_),
                      *base_pose_.find(stamp_ns, tolerance_ns_)};
}

std::vector<std::string> ViewCollector::missing_parts(std::int64_t stamp_ns) const {
  std::vector<std::string> names;
  const auto check = [&](const auto& track, const char* name) {
    if (!track.find(stamp_ns, tolerance_ns_)) names.emplace_back(name);
  };
  check(left_, "left image");
  check(right_, "right image");
  check(left_calibration_, "left camera info");
  check(right_calibration_, "right camera info");
  check(joints_, "joint states");
  check(base_pose_, "base pose");
  return names;
}

std::string ViewCollector::missing(std::int64_t stamp_ns) const {
  const std::lock_guard lock(mutex_);
  std::string text;
  for (const std::string& name : missing_parts(stamp_ns)) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string ViewCollector::fault() const {
  const std::lock_guard lock(mutex_);
  return fault_;
}

void ViewCollector::clear_faults() {
  const std::lock_guard lock(mutex_);
  fault_.clear();
}

void ViewStore::put(const std::string& view_id, CapturedView view) {
  const std::lock_guard lock(mutex_);
  std::erase(order_, view_id);
  order_.push_back(view_id);
  views_[view_id] = std::make_shared<const CapturedView>(std::move(view));
  while (order_.size() > capacity_) {
    views_.erase(order_.front());
    order_.pop_front();
  }
}

std::shared_ptr<const CapturedView> ViewStore::find(const std::string& view_id) const {
  const std::lock_guard lock(mutex_);
  const auto it = views_.find(view_id);
  return it == views_.end() ? nullptr : it->second;
}

}  // namespace periplus::vision
