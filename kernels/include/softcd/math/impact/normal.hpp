#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/impact/advancement.hpp"

namespace softcd::detail {

/// The error, relative to the lengths from which a vector was computed, above which its direction means nothing.
template <class T>
constexpr T kDirectionError = T(64) * epsilon<T>();

/// Returns a direction perpendicular to a, or any direction when a is zero.
template <class T>
SOFTCD_HD Vec3<T> any_perpendicular(Vec3<T> a) {
  const Vec3<T> axis = magnitude(a.x) <= magnitude(a.y) ? Vec3<T>{T(1), T(0), T(0)} : Vec3<T>{T(0), T(1), T(0)};
  return max_norm(a) > T(0) ? cross(a, axis) : axis;
}

/// Returns the direction of the normal of features that touch. Takes the first of these that exists:
/// - the direction in which the features were apart before;
/// - the plane's normal towards a's side at t0; the sign of `side` is a's side of b x c at t0, 0 when unknown;
/// - the plane's normal against the relative motion;
/// - the direction against the relative motion;
/// - any direction.
template <class T>
SOFTCD_HD Vec3<T> normal_of_touch(const Motion<T>& motion, const Touch<T>& touch, T side) {
  if (max_norm(touch.approach) > T(0)) {
    return touch.approach;
  }
  const RelativePair<T> now = motion.at(touch.time);
  const Vec3<T> plane = cross(now.b, now.c);
  const T length = norm(plane);
  const bool is_plane = length > kDirectionError<T> * (norm(now.b) * norm(now.c));
  const Vec3<T> velocity = (motion.t1.a - motion.t0.a) - touch.nearest.x * (motion.t1.b - motion.t0.b) -
                           touch.nearest.y * (motion.t1.c - motion.t0.c);
  const T speed = norm(velocity);
  const T across = dot(plane, velocity);
  if (is_plane && side != T(0)) {
    return side < T(0) ? -plane : plane;
  }
  if (is_plane && magnitude(across) > kDirectionError<T> * (length * speed)) {
    return across > T(0) ? -plane : plane;
  }
  if (speed > motion.tolerance) {
    return -velocity;
  }
  return is_plane ? plane : any_perpendicular(max_norm(now.b) > T(0) ? now.b : now.c);
}

}  // namespace softcd::detail
