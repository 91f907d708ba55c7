// Reachability by constants: a table over the height of the left eye and the pitch of the optical axis, the two that decide how far a
// standing humanoid has to crouch, stretch or bend. Written by hand, or filled by whoever tried which views its body reaches.
#pragma once

#include <memory>
#include <vector>

#include "services/nbv_planner/situation.h"

namespace periplus::nbv {

class ReachabilityTable final : public Reachability {
 public:
  // Of heights[i] [m] and pitches[j] [rad, positive down]: shares[i * pitches.size() + j], 0..1; linear between these, beyond them
  // as at the nearest. Throws Error(bad_input | bad_size | not_finite): axes that are empty or do not rise, shares that are none, or too few.
  ReachabilityTable(std::vector<double> heights, std::vector<double> pitches, std::vector<double> shares);

  double of(const Pose& X_WC) const override;

 private:
  std::vector<double> heights_, pitches_, shares_;
};

}  // namespace periplus::nbv
