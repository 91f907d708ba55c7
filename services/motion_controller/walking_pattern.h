// What walking asks of the body, tick by tick: where the feet are, which one stands, where the zero-moment point shall
// be, and the motion of the centre of mass that puts it there (thesis 5.2.5, with Kajita's preview control).
// World frame, floor at z = 0. Foot 0 is the left one, 1 the right one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "common/geometry/pose.h"
#include "services/motion_controller/preview_control.h"

namespace periplus::motion {

struct GaitSettings {
  double single_support = 0.7;      // [s]
  double double_support = 0.1;      // between two steps [s]
  double first_hold = 0.8;          // standing with the plan already in the preview [s]
  double end_double_support = 0.6;  // first and last shift of the weight [s]
  double settle = 1.6;              // standing at the end, where the centre of mass comes to rest [s]
  double step_height = 0.05;        // [m]
  double zmp_ahead = 0.012;         // of the sole frame's origin, along the sole [m]
  PreviewSettings preview;

  void check() const;  // throws Error(bad_input)
};

struct Step {
  int foot = 0;  // that moves
  Pose2 sole;    // where it lands
};

// A sole in the air or on the floor; it stays level.
struct SolePose {
  Eigen::Vector3d position{0, 0, 0};
  double yaw = 0;
};

struct PatternTick {
  std::array<SolePose, 2> soles;
  int support = 2;       // 0 left, 1 right, 2 both
  double waist_yaw = 0;  // [rad]
  Eigen::Vector2d zmp_reference{0, 0};
  Eigen::Vector2d zmp{0, 0};                   // of the cart-table model
  Eigen::Vector2d com{0, 0}, com_speed{0, 0};  // [m], [m/s]
  int steps_done = 0;
};

class WalkingPattern {
 public:
  // From rest with the centre of mass at `com` (height kept throughout). Throws Error(bad_input): settings, or a foot
  // other than 0 and 1, or the same foot twice in a row.
  WalkingPattern(const GaitSettings& settings, const std::array<Pose2, 2>& feet, const Eigen::Vector3d& com,
                 const std::vector<Step>& steps);

  const std::vector<PatternTick>& ticks() const { return ticks_; }
  // Ends the walk as soon as it can stand after `tick` was executed: the step under way is finished, and the next one
  // if too little of the present one is left to see the end coming; then `further` more. Ticks up to `tick` stay as they
  // are.
  void halt(std::size_t tick, std::size_t further = 0);

  // Where the weight rests on a sole: its origin shifted ahead.
  static Eigen::Vector2d pressure_point(const GaitSettings& settings, const Pose2& sole);

 private:
  void compose_ticks();
  void begin();
  void add_step(const Step& step, double double_support);
  void shift_weight(const Eigen::Vector2d& to, double duration);
  void finish();
  Eigen::Vector2d middle() const;
  void run_preview(std::size_t from);
  void come_to_rest();
  std::size_t ticks_of(double seconds) const;

  GaitSettings settings_;
  PreviewControl control_;
  std::vector<Step> steps_;
  std::vector<std::size_t> landed_;  // tick at which each step is done
  std::vector<PatternTick> ticks_;
  std::vector<std::array<PreviewState, 2>> states_;  // x and y at every tick
  PatternTick now_;                                  // end of ticks_
  std::array<Pose2, 2> feet_;                        // on the floor at the end of ticks_
};

}  // namespace periplus::motion
