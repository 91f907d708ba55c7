#include "services/motion_controller/trajectory.h"

#include <algorithm>
#include <cmath>

namespace periplus::motion {

double minimum_jerk(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (10 - 15 * u + 6 * u * u);
}

double greatest_speed_ratio(const robot::RobotModel& model, const Eigen::VectorXd& before,
                            const std::vector<Command>& commands, std::size_t from, double period, std::string& joint) {
  double greatest = 0;
  for (std::size_t k = from; k < commands.size(); ++k) {
    const Eigen::VectorXd& a = k == 0 ? before : commands[k - 1].q;
    for (std::size_t j = 0; j < model.joints().size(); ++j) {
      const auto i = static_cast<Eigen::Index>(6 + j);
      const double ratio = std::abs(commands[k].q(i) - a(i)) / period / model.joints()[j].max_speed;
      if (ratio > greatest) {
        greatest = ratio;
        joint = model.joints()[j].name;
      }
    }
  }
  return greatest;
}

}  // namespace periplus::motion
