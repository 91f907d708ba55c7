// A task's result as a list of numbers, so that another process may have made it: bit for bit the same when read back.
// A type says once what it consists of:
//
//   struct Sample { Pose X_WC; int voxels; };
//   template <class Fields> void visit_fields(Fields& fields, Sample& s) { fields(s.X_WC, s.voxels); }
//
// Known already: double, float, bool, enumerations, integers, poses, Eigen vectors of fixed size, std::vector, std::optional.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "common/core/error.h"
#include "common/geometry/pose.h"

namespace periplus::nbv {

using Numbers = std::vector<double>;

// Appends to a list.
class NumberWriter {
 public:
  explicit NumberWriter(Numbers& to) : to_(to) {}

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }

 private:
  void put(double v) { to_.push_back(v); }
  template <class T>
  void one(T& v) {
    if constexpr (std::is_floating_point_v<T>) {
      put(v);
    } else if constexpr (std::is_enum_v<T>) {
      put(static_cast<double>(static_cast<std::int32_t>(v)));
    } else if constexpr (std::is_integral_v<T> && sizeof(T) <= 4) {
      put(static_cast<double>(v));
    } else if constexpr (std::is_integral_v<T>) {  // a double holds 53 bits
      put(static_cast<double>(static_cast<std::uint64_t>(v) >> 32));
      put(static_cast<double>(static_cast<std::uint64_t>(v) & 0xffffffffu));
    } else {
      visit_fields(*this, v);
    }
  }
  void one(Pose& X) {
    for (int i = 0; i < 12; ++i) put(X.matrix()(i % 3, i / 3));
  }
  template <class T, int Rows>
  void one(Eigen::Matrix<T, Rows, 1>& v) {
    static_assert(Rows > 0);
    for (int i = 0; i < Rows; ++i) one(v[i]);
  }
  template <class T>
  void one(std::vector<T>& v) {
    put(static_cast<double>(v.size()));
    for (T& each : v) one(each);
  }
  template <class T>
  void one(std::optional<T>& v) {
    put(v ? 1 : 0);
    if (v) one(*v);
  }

  Numbers& to_;
};

// Reads in the same order. What it reads may come from another process: Error(bad_size) where numbers are missing,
// Error(bad_input) for a number that the field cannot hold.
class NumberReader {
 public:
  explicit NumberReader(std::span<const double> from) : from_(from) {}

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }
  // Throws Error(bad_size) unless all was read.
  void finish() const {
    require(at_ == from_.size(), ErrorCode::bad_size, "a task's result has more numbers than its fields");
  }

 private:
  double get() {
    require(at_ < from_.size(), ErrorCode::bad_size, "a task's result has fewer numbers than its fields");
    return from_[at_++];
  }
  std::uint64_t whole(double least, double most) {
    const double v = get();
    require(v >= least && v <= most && v == static_cast<double>(static_cast<std::int64_t>(v)), ErrorCode::bad_input,
            "a task's result holds a number that its field cannot");
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(v));
  }
  template <class T>
  void one(T& v) {
    if constexpr (std::is_floating_point_v<T>) {
      v = static_cast<T>(get());
    } else if constexpr (std::is_enum_v<T>) {
      v = static_cast<T>(whole(-2147483648.0, 2147483647.0));
    } else if constexpr (std::is_integral_v<T> && sizeof(T) <= 4) {
      v = static_cast<T>(whole(static_cast<double>(std::numeric_limits<T>::min()), static_cast<double>(std::numeric_limits<T>::max())));
    } else if constexpr (std::is_integral_v<T>) {
      const std::uint64_t high = whole(0, 4294967295.0);
      v = static_cast<T>(high << 32 | whole(0, 4294967295.0));
    } else {
      visit_fields(*this, v);
    }
  }
  void one(Pose& X) {
    X.setIdentity();
    for (int i = 0; i < 12; ++i) X.matrix()(i % 3, i / 3) = get();
  }
  template <class T, int Rows>
  void one(Eigen::Matrix<T, Rows, 1>& v) {
    static_assert(Rows > 0);
    for (int i = 0; i < Rows; ++i) one(v[i]);
  }
  template <class T>
  void one(std::vector<T>& v) {
    const std::size_t size = whole(0, 4294967295.0);
    require(size <= from_.size() - at_, ErrorCode::bad_size, "a task's result has fewer numbers than its list");
    v.resize(size);  // an element takes a number at least
    for (T& each : v) one(each);
  }
  template <class T>
  void one(std::optional<T>& v) {
    v.reset();
    if (whole(0, 1) != 0) one(v.emplace());
  }

  std::span<const double> from_;
  std::size_t at_ = 0;
};

template <class T>
void append_numbers(T& value, Numbers& to) {
  NumberWriter writer(to);
  writer(value);
}

template <class T>
T from_numbers(std::span<const double> from) {
  T value{};
  NumberReader reader(from);
  reader(value);
  reader.finish();
  return value;
}

}  // namespace periplus::nbv
