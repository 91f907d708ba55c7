// Orientation of a feature on the surface it lies on (thesis 5.1.2).
#pragma once

#include <Eigen/Core>

#include "common/object_model/perception.h"

namespace periplus::object_model {

// Unit vector in the world, at right angles to the feature's normal, that the left eye at X_WC sees along the feature's angle in the
// image; zero where the normal is unknown. It follows from what a feature has, and is not stored: with the view's pose it turns.
Eigen::Vector3d surface_direction(const Feature& feature, const Pinhole& camera, const Pose& X_WC);

}  // namespace periplus::object_model
