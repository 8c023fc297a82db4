#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Three components, tightly packed: an array of Vec3<float> is 12 bytes an element.
template <class T>
struct Vec3 {
  /// The components.
  ///@{
  T x, y, z;
  ///@}

  /// Returns component 0, 1 or 2.
  SOFTCD_HD constexpr T operator[](int axis) const { return axis == 0 ? x : (axis == 1 ? y : z); }
};

/// A vector of floats.
using Vec3f = Vec3<float>;
/// A vector of doubles.
using Vec3d = Vec3<double>;

/// Returns the sum.
template <class T>
SOFTCD_HD constexpr Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

/// Returns the difference.
template <class T>
SOFTCD_HD constexpr Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

/// Returns the opposite vector.
template <class T>
SOFTCD_HD constexpr Vec3<T> operator-(Vec3<T> a) {
  return {-a.x, -a.y, -a.z};
}

/// Returns s times a.
template <class T>
SOFTCD_HD constexpr Vec3<T> operator*(T s, Vec3<T> a) {
  return {s * a.x, s * a.y, s * a.z};
}

template <class T>
SOFTCD_HD constexpr bool operator==(Vec3<T> a, Vec3<T> b) {
  return a.x == b.x && a.y == b.y && a.z == b.z;
}

/// Returns the scalar product.
template <class T>
SOFTCD_HD constexpr T dot(Vec3<T> a, Vec3<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Returns the vector product.
template <class T>
SOFTCD_HD constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Returns the square of the length.
template <class T>
SOFTCD_HD constexpr T squared_norm(Vec3<T> a) {
  return dot(a, a);
}

/// Returns the point a + t (b - a); exact at t = 0.
template <class T>
SOFTCD_HD constexpr Vec3<T> lerp(Vec3<T> a, Vec3<T> b, T t) {
  return a + t * (b - a);
}

/// Converts each component to another scalar type.
template <class To, class From>
SOFTCD_HD constexpr Vec3<To> vec3_cast(Vec3<From> a) {
  return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
