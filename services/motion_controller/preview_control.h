// Preview control of the zero-moment point of a cart-table model: S. Kajita et al., "Biped walking pattern generation
// by using preview control of zero-moment point", ICRA 2003. One axis on the floor at a time. In its incremental form
// (each period adds to the jerk), so that a reference that changes while the robot walks is followed without a jump.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace periplus::motion {

struct PreviewSettings {
  double period = 0.005;      // [s]
  double preview = 1.6;       // how far the reference is seen ahead [s]
  double error_weight = 1.0;  // Qe
  double jerk_weight = 1e-6;  // R
};

// State of one axis.
struct PreviewState {
  Eigen::Vector3d com{0, 0, 0};       // position [m], speed [m/s], acceleration [m/s2]
  Eigen::Vector3d last_com{0, 0, 0};  // the same one period before
  double jerk = 0;                    // that led here [m/s3]

  static PreviewState at_rest(double position) { return {{position, 0, 0}, {position, 0, 0}, 0}; }
};

class PreviewControl {
 public:
  // Throws Error(bad_input) unless the height and all settings are positive.
  PreviewControl(double com_height, const PreviewSettings& settings = {});

  // ZMP of the model, p - z/g a [m].
  double zmp(const PreviewState& state) const;
  // The state one period later. reference[0] is this tick's ZMP reference, the next ones follow; beyond its end the
  // last one is held. Must not be empty.
  void advance(PreviewState& state, std::span<const double> reference) const;

 private:
  double period_, height_over_g_;
  double error_gain_ = 0;
  Eigen::RowVector3d state_gain_;
  std::vector<double> preview_gain_;
};

}  // namespace periplus::motion
