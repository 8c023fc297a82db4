#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd::detail {

/// The tolerance of distances, relative to the sum A + B + C of the sizes that they are made of.
template <class T>
constexpr T kDistanceError = T(32) * epsilon<T>();

/// The share of the margin by which a hit may exceed the margin. Margins are sums of floats, and steps converge to this
/// in 5 instead of 7.
template <class T>
constexpr T kMarginTolerance = T(0x1p-20);

/// The data of a query that its stages share.
template <class T>
struct Motion {
  RelativePair<T> t0, t1;
  T margin;
  T tolerance;

  SOFTCD_HD RelativePair<T> at(T t) const {
    return {interpolate(t0.a, t1.a, t), interpolate(t0.b, t1.b, t), interpolate(t0.c, t1.c, t)};
  }
  SOFTCD_HD T reach() const { return margin + tolerance; }
};

}  // namespace softcd::detail
