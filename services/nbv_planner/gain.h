// Gains of the literature, as others choose their views: how much a view promises by the rays of its image through the grid.
//
//   G(v) = sum over rays r of sum over the voxels x of r of I(x)
//
// I after S. Isler, R. Sabzevari, J. Delmerico, D. Scaramuzza, "An information gain formulation for active volumetric 3D
// reconstruction", ICRA 2016 (section III), compared in J. Delmerico, S. Isler, R. Sabzevari, D. Scaramuzza, "A comparison of
// volumetric information gain metrics for active 3D object reconstruction", Autonomous Robots 42, 2018 (section 3). A ray
// goes through empty and unknown voxels, and ends in known surface, in the known environment or beyond the grid. With
// Po(x) the probability that x is occupied, H = -Po ln Po - (1 - Po) ln(1 - Po) and the visibility
// Pv(x_n) = prod_{i<n} (1 - Po(x_i)):
//
//   occlusion_aware    I = Pv H
//   unobserved         I = Pv H where x is unknown, else 0
//   rear_side          I = 1 where x is unknown and next to the known surface behind it on its ray, else 0
//   rear_side_entropy  I = Pv H where x is in the run of unknown voxels before a known one seen from behind, and on that one, else 0
//   proximity_count    I = d_max - d(x) where x is unknown and its distance to the nearest known voxel d(x) < d_max [voxels]
//   average_entropy    sum of H over the voxels of all rays that meet known surface, by their number (S. Kriegel, C. Rink,
//                      T. Bodenmueller, M. Suppa, "Efficient next-best-scan planning for autonomous 3D surface reconstruction of
//                      unknown objects", Journal of Real-Time Image Processing 10, 2015)
//   area_factor        f(share of rays that meet known surface first; 0.2) + f(share that meet an occlusion plane first,
//                      unknown next to empty; 0.8), f 1 at its desired share and 0 at shares 0 and 1, cubic between
//                      (J. I. Vasquez-Gomez, L. E. Sucar, R. Murrieta-Cid, E. Lopez-Damian, "Volumetric next-best-view planning
//                      for 3D object reconstruction with positioning error", Int. J. of Advanced Robotic Systems 11, 2014)
//
// The probabilities are those that OctoMap's clamping leaves. The authors' own program multiplies Pv by Po in place of
// 1 - Po; here stands the formula of the paper. In their map what lies outside the object's box is unknown too; here it is
// known to be free, and adds nothing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "services/nbv_planner/situation.h"

namespace periplus::nbv {

struct GainSettings {
  int pixel_step = 8;                    // a ray through every so many pixels of each row and column
  double p_unknown = 0.5, p_known = 0.97, p_empty = 0.12;
  double proximity_reach = 10;           // d_max [voxels]
  double desired_known = 0.2, desired_occlusion = 0.8;  // of area_factor
};

// Immutable: may be shared between threads.
class InformationGain {
 public:
  virtual ~InformationGain() = default;
  virtual const char* name() const = 0;
  // Of a left-eye pose; more is better. With two eyes the rays leave from between them, through what both images contain at the
  // distance of the grid's middle. Solids of the scene end a ray (scene::CollisionWorld::first_hit).
  // Throws Error(not_finite) for a pose that is not finite.
  virtual double evaluate(const Pose& X_WC) const = 0;
};

// Those above, in their order.
const std::vector<std::string>& information_gain_names();
// `situation` is kept by reference. Throws Error(bad_input) for a name or setting that is none, naming those that are.
std::unique_ptr<InformationGain> make_information_gain(const std::string& name, const Situation& situation,
                                                       const GainSettings& settings = {});

}  // namespace periplus::nbv
