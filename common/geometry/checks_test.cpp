#include "common/geometry/checks.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/core/error.h"

namespace periplus {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

ErrorCode code_thrown_by(const std::function<void()>& run) {
  try {
    run();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("the thing"), std::string::npos) << error.what();
    return error.code();
  }
  return ErrorCode::ok;
}

TEST(Checks, FiniteNumbersPassAndOthersAreNamed) {
  EXPECT_EQ(require_finite(1.5, "the thing"), 1.5);
  EXPECT_EQ(code_thrown_by([] { require_finite(kInfinite, "the thing"); }), ErrorCode::not_finite);
  EXPECT_EQ(code_thrown_by([] { require_finite(kInfinite - kInfinite, "the thing"); }), ErrorCode::not_finite);
}

TEST(Checks, OnlyRotationAndTranslationIsRigid) {
  Pose X = look_at({1, 2, 3}, {0, 0, 1});
  EXPECT_EQ(code_thrown_by([&] { require_rigid(X, "the thing"); }), ErrorCode::ok);
  Pose mirrored = X;
  mirrored.linear().col(0) *= -1;
  EXPECT_EQ(code_thrown_by([&] { require_rigid(mirrored, "the thing"); }), ErrorCode::bad_input);
  Pose scaled = X;
  scaled.linear() *= 1.01;
  EXPECT_EQ(code_thrown_by([&] { require_rigid(scaled, "the thing"); }), ErrorCode::bad_input);
  X.translation().x() = kInfinite;
  EXPECT_EQ(code_thrown_by([&] { require_rigid(X, "the thing"); }), ErrorCode::not_finite);
}

}  // namespace
}  // namespace periplus
