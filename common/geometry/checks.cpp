#include "common/geometry/checks.h"

#include <cmath>
#include <string>

#include "common/core/error.h"

namespace periplus {

// Called for each of many numbers, so no sentence is composed in vain.
double require_finite(double value, std::string_view what) {
  if (!std::isfinite(value)) throw_error(ErrorCode::not_finite, std::string(what) + " is not a finite number; send a finite one");
  return value;
}

void require_rigid(const Pose& X, std::string_view what) {
  require(is_finite(X), ErrorCode::not_finite, std::string(what) + " holds a number that is not finite");
  const Eigen::Matrix3d R = X.linear();
  require((R.transpose() * R).isApprox(Eigen::Matrix3d::Identity(), 1e-6) && R.determinant() > 0, ErrorCode::bad_input,
          std::string(what) + " is not a rotation and a translation");
}

}  // namespace periplus
