#include "services/vision_server/captured_view.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>

namespace periplus::vision {

namespace {
constexpr std::size_t kReadingsKept = 8;
constexpr std::uint64_t kTimeKept = 2'000'000'000;  // of streams [ns]: an image may come that late
constexpr std::size_t kMostKept = 4096;             // of streams, whatever their rate
constexpr std::uint64_t kOutOfOrder = 100'000'000;  // of streams [ns]: what comes as late as that is no clock gone back
constexpr std::uint64_t kOneExposure = 1'000'000;   // of a pair [ns]: the stamps of two cameras that fire together

std::uint64_t apart(std::int64_t a, std::int64_t b) {
  return a > b ? static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b)
               : static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a);
}

std::string seconds(std::uint64_t ns) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g s", static_cast<double>(ns) * 1e-9);
  return text;
}

void check_size(const ImageU8& image, const CameraCalibration& c, const char* eye) {
  require(image.width == c.width && image.height == c.height, ErrorCode::vision_image_bad,
          std::string("the ") + eye + " image has " + std::to_string(image.width) + " x " + std::to_string(image.height) +
              " pixels, its camera info says " + std::to_string(c.width) + " x " + std::to_string(c.height) +
              "; check the camera driver");
}
}  // namespace

void check_sizes(const CapturedView& view) {
  check_size(view.left, view.left_calibration, "left");
  check_size(view.right, view.right_calibration, "right");
}

template <class T>
void ViewCollector::Track<T>::add(std::int64_t stamp, std::uint64_t arrival, T value) {
  // The clock went back: what came before belongs to another run of it.
  if (by_time && !readings.empty() && stamp < readings.back().stamp && apart(stamp, readings.back().stamp) > kOutOfOrder)
    readings.clear();
  // The same reading may be published again: the newest copy counts.
  std::erase_if(readings, [&](const auto& r) { return r.stamp == stamp; });
  readings.push_back({stamp, arrival, std::move(value)});
  const auto too_many = [&] {
    if (readings.size() <= kReadingsKept) return false;
    return !by_time || readings.size() > kMostKept || apart(readings.front().stamp, stamp) > kTimeKept;
  };
  while (too_many()) readings.pop_front();
}

template <class T>
const T* ViewCollector::Track<T>::find(std::int64_t stamp, std::int64_t tolerance, std::uint64_t arrival) const {
  const T* best = nullptr;
  std::uint64_t nearest = std::numeric_limits<std::uint64_t>::max();
  for (const auto& r : readings)
    if (const std::uint64_t d = apart(r.stamp, stamp);
        r.arrival > arrival && d <= static_cast<std::uint64_t>(tolerance) && d < nearest) {
      nearest = d;
      best = &r.value;
    }
  return best;
}

template <class T>
std::string ViewCollector::Track<T>::instead(std::int64_t stamp, std::uint64_t arrival) const {
  const Reading<T>* nearest = nullptr;
  for (const auto& r : readings)
    if (r.arrival > arrival && (!nearest || apart(r.stamp, stamp) < apart(nearest->stamp, stamp))) nearest = &r;
  if (!nearest || nearest->stamp == stamp) return "";
  return " (the nearest that came is " + seconds(apart(nearest->stamp, stamp)) + (nearest->stamp < stamp ? " older)" : " newer)");
}

template <class T>
void ViewCollector::add(Track<T>& track, std::int64_t stamp, T value) {
  const std::lock_guard lock(mutex_);
  track.add(stamp, ++arrivals_, std::move(value));
  changed_.notify_all();
}

void ViewCollector::add_image(Part eye, std::int64_t stamp_ns, ImageU8 image) {
  add(eye == Part::left ? left_ : right_, stamp_ns, std::move(image));
}

void ViewCollector::add_calibration(Part eye, std::int64_t stamp_ns, CameraCalibration calibration) {
  add(eye == Part::left_calibration ? left_calibration_ : right_calibration_, stamp_ns, std::move(calibration));
}

void ViewCollector::add_joints(std::int64_t stamp_ns, JointPositions joints) { add(joints_, stamp_ns, std::move(joints)); }

void ViewCollector::add_base_pose(std::int64_t stamp_ns, const Pose& X_WB) { add(base_pose_, stamp_ns, X_WB); }

bool ViewCollector::add_fault(const std::string& why) {
  constexpr std::size_t kMostFaults = 64;
  const std::lock_guard lock(mutex_);
  fault_ = why;
  return faults_.size() < kMostFaults && faults_.insert(why).second;
}

ViewCollector::Moment ViewCollector::now() const {
  const std::lock_guard lock(mutex_);
  return Moment{arrivals_};
}

std::optional<CapturedView> ViewCollector::wait(std::int64_t stamp_ns, Moment triggered, std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, timeout, [&] { return parts(stamp_ns, triggered).complete(); })) return std::nullopt;
  const Parts p = parts(stamp_ns, triggered);
  return CapturedView{stamp_ns, *p.left, *p.right, *p.left_calibration, *p.right_calibration, *p.joints, *p.X_WB};
}

ViewCollector::Parts ViewCollector::parts(std::int64_t stamp_ns, Moment triggered) const {
  const auto sent = static_cast<std::uint64_t>(triggered);
  const auto streamed = tolerance_ns_ == 0 ? sent : 0;
  Parts p{left_.find(stamp_ns, tolerance_ns_, sent),
          right_.find(stamp_ns, tolerance_ns_, sent),
          left_calibration_.find(stamp_ns, tolerance_ns_, sent),
          right_calibration_.find(stamp_ns, tolerance_ns_, sent),
          joints_.find(stamp_ns, tolerance_ns_, streamed),
          base_pose_.find(stamp_ns, tolerance_ns_, streamed),
          0};
  if (!p.left || !p.right) return p;
  // Of several pairs the nearest.
  const auto usable = [&](const Reading<ImageU8>& r) { return r.arrival > sent && apart(r.stamp, stamp_ns) <= static_cast<std::uint64_t>(tolerance_ns_); };
  std::uint64_t nearest = std::numeric_limits<std::uint64_t>::max(), least_apart = nearest;
  for (const auto& l : left_.readings)
    for (const auto& r : right_.readings) {
      if (!usable(l) || !usable(r)) continue;
      const std::uint64_t between = apart(l.stamp, r.stamp), away = apart(l.stamp, stamp_ns);
      least_apart = std::min(least_apart, between);
      if (between > kOneExposure || away + between >= nearest) continue;
      nearest = away + between;
      p.left = &l.value;
      p.right = &r.value;
    }
  if (least_apart > kOneExposure) p.torn = least_apart;
  return p;
}

std::string ViewCollector::missing(std::int64_t stamp_ns, Moment triggered) const {
  const std::lock_guard lock(mutex_);
  const Parts p = parts(stamp_ns, triggered);
  std::string text;
  const auto check = [&](const void* part, const std::string& name) {
    if (!part) text += (text.empty() ? "" : ", ") + name;
  };
  const auto sent = static_cast<std::uint64_t>(triggered);
  check(p.left, "left image" + left_.instead(stamp_ns, sent));
  check(p.right, "right image" + right_.instead(stamp_ns, sent));
  if (p.torn > 0) text = "left and right image of one exposure (they are " + seconds(p.torn) + " apart; have both cameras triggered together)";
  check(p.left_calibration, "left camera info" + left_calibration_.instead(stamp_ns, sent));
  check(p.right_calibration, "right camera info" + right_calibration_.instead(stamp_ns, sent));
  // Hours or days here mean that the clocks of the cameras' host and the robot's are not the same.
  const auto streamed = tolerance_ns_ == 0 ? sent : 0;
  check(p.joints, "joint states" + joints_.instead(stamp_ns, streamed));
  check(p.X_WB, "base pose" + base_pose_.instead(stamp_ns, streamed));
  return text;
}

std::string ViewCollector::fault() const {
  const std::lock_guard lock(mutex_);
  return fault_;
}

void ViewCollector::clear_faults() {
  const std::lock_guard lock(mutex_);
  fault_.clear();
  faults_.clear();
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
