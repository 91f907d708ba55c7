// What the cameras and the robot delivered for one view, and its gathering from separate messages by their stamp.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/geometry/calibration.h"
#include "common/geometry/image.h"
#include "common/geometry/pose.h"

namespace periplus::vision {

// Joint positions [rad] by name.
using JointPositions = std::vector<std::pair<std::string, double>>;

struct CapturedView {
  std::int64_t stamp_ns = 0;
  ImageU8 left, right;                                   // raw, rgb or grey
  CameraCalibration left_calibration, right_calibration;
  JointPositions joints;
  Pose X_WB = Pose::Identity();                          // base link as the robot reports it
};

// Throws Error(vision_image_bad) if an image has another size than its camera info.
void check_sizes(const CapturedView& view);

// Thread-safe. Images and camera infos keep their last few readings, joints and base pose, which may stream at a high rate,
// those of the last two seconds; a view is complete when every part has a reading of its stamp.
//
// Stamps alone do not name a reading: a simulator that was started again counts from 0 once more. What the cameras send on
// a trigger must therefore have come after that trigger. With a tolerance of 0 that goes for joints and base pose as well,
// which are then sent with the images; otherwise they may be older, but not from before their clock went back.
class ViewCollector {
 public:
  enum class Part { left, right, left_calibration, right_calibration, joints, base_pose };
  // A moment in the order of arrival.
  enum class Moment : std::uint64_t { begin = 0 };

  // `tolerance`: how far a part's stamp may be from the view's [ns]; 0 asks for the same. Left and right image must be of one
  // exposure whatever it is: no more than a millisecond apart.
  explicit ViewCollector(std::int64_t tolerance_ns) : tolerance_ns_(tolerance_ns) {}

  void add_image(Part eye, std::int64_t stamp_ns, ImageU8 image);
  void add_calibration(Part eye, std::int64_t stamp_ns, CameraCalibration calibration);
  void add_joints(std::int64_t stamp_ns, JointPositions joints);
  void add_base_pose(std::int64_t stamp_ns, const Pose& X_WB);
  // Something came that could not be used; its reason goes into the error if the view stays incomplete. True for a reason that is new
  // since clear_faults(): a camera that is set wrongly gives the same with every image. Of 64 reasons the rest are no news.
  bool add_fault(const std::string& why);

  // To be taken before the trigger.
  Moment now() const;
  // Waits until the view of this stamp is complete with what came after `triggered`; nothing if it is not in time.
  std::optional<CapturedView> wait(std::int64_t stamp_ns, Moment triggered, std::chrono::milliseconds timeout);
  // Names of what is missing for that stamp: "right image, base pose"; how stale those are that came instead, or how far apart the
  // two images were taken.
  std::string missing(std::int64_t stamp_ns, Moment triggered) const;
  // The last fault since clear_faults(); empty if none.
  std::string fault() const;
  void clear_faults();

 private:
  template <class T>
  struct Reading {
    std::int64_t stamp;
    std::uint64_t arrival;
    T value;
  };
  template <class T>
  struct Track {
    bool by_time = false;                        // else by count
    std::deque<Reading<T>> readings = {};        // in the order of arrival
    void add(std::int64_t stamp, std::uint64_t arrival, T value);
    // The nearest one that came after `arrival`; nullptr if none is near enough.
    const T* find(std::int64_t stamp, std::int64_t tolerance, std::uint64_t arrival) const;
    // " (the nearest that came is 0.033 s older)", or nothing.
    std::string instead(std::int64_t stamp, std::uint64_t arrival) const;
  };
  struct Parts {  // of one view; null where missing
    const ImageU8 *left, *right;
    const CameraCalibration *left_calibration, *right_calibration;
    const JointPositions* joints;
    const Pose* X_WB;
    std::uint64_t torn;  // left and right image are of two exposures, so many nanoseconds apart; else 0
    bool complete() const { return torn == 0 && left && right && left_calibration && right_calibration && joints && X_WB; }
  };
  template <class T>
  void add(Track<T>& track, std::int64_t stamp, T value);
  Parts parts(std::int64_t stamp_ns, Moment triggered) const;

  const std::int64_t tolerance_ns_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t arrivals_ = 0;
  Track<ImageU8> left_, right_;
  Track<CameraCalibration> left_calibration_, right_calibration_;
  Track<JointPositions> joints_{.by_time = true};
  Track<Pose> base_pose_{.by_time = true};
  std::string fault_;
  std::set<std::string> faults_;
};

// The last views by their id. Thread-safe.
class ViewStore {
 public:
  explicit ViewStore(std::size_t capacity) : capacity_(capacity) {}
  void put(const std::string& view_id, CapturedView view);
  std::shared_ptr<const CapturedView> find(const std::string& view_id) const;  // nullptr if unknown

 private:
  const std::size_t capacity_;
  mutable std::mutex mutex_;
  std::deque<std::string> order_;
  std::map<std::string, std::shared_ptr<const CapturedView>> views_;
};

}  // namespace periplus::vision
