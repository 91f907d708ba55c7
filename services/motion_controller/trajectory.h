// A motion as the robot executes it: one command every 5 ms, planned ahead, that can be cut short at any tick and then
// ends standing still.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "common/robot/robot_model.h"

namespace periplus::motion {

struct Command {
  int support = 2;    // 0 left foot, 1 right foot, 2 both
  Eigen::VectorXd q;  // configuration: base (as planned), then the joints
};

class Trajectory {
 public:
  virtual ~Trajectory() = default;
  // Commands in order; command 0 is the first one that moves. May be empty.
  const std::vector<Command>& commands() const { return commands_; }
  // Share of the way done, 0..1, and a phrase for a person, once `executed` commands are.
  virtual double fraction(std::size_t executed) const = 0;
  virtual std::string describe(std::size_t executed) const = 0;
  // Replaces what follows the first `executed` commands by the shortest end that stands still on both feet.
  virtual void halt(std::size_t executed) = 0;

 protected:
  std::vector<Command> commands_;
};

// Share of a way at share u of its time (both clamped to 0..1), at rest with no acceleration at either end (Flash & Hogan 1985).
double minimum_jerk(double u);

struct MotionLimits {
  double period = 0.005;         // of the commands [s]
  double speed_share = 0.95;     // of a joint's greatest speed that may be used
  double sole_tolerance = 1e-6;  // what inverse kinematics may leave at a sole [m], [rad]
  double com_tolerance = 5e-3;   // and at the centre of mass, at joint limits [m]
};

// Greatest ratio of a joint's speed to its limit between consecutive configurations from..to of `commands` (the first
// one against `before`); `joint` names it.
double greatest_speed_ratio(const robot::RobotModel& model, const Eigen::VectorXd& before,
                            const std::vector<Command>& commands, std::size_t from, double period, std::string& joint);

}  // namespace periplus::motion
