// A model to export, and numbers out of what was exported.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "common/object_model/testing/sphere_views.h"

namespace periplus::object_model::testing {

// Four ideal views of a sphere, its box turned about the vertical.
inline ObjectModel model_of(const Sphere& sphere, double yaw = 0) {
  ObjectBox box = box_around(sphere);
  box.X_WB.linear() = rotation_from_yaw_pitch_roll(yaw, 0, 0);
  ObjectModel model("ball", box, 0.02, {});
  for (int n = 0; n < 4; ++n) model.integrate(ideal_view(sphere, n, 4), {}, {});
  return model;
}

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  EXPECT_LE(at + sizeof value, bytes.size());
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace periplus::object_model::testing
