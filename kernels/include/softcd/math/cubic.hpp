#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd::detail {

/// A cubic over [0, 1] in Bernstein form: b0 s^3 + b1 s^2 t + b2 s t^2 + b3 t^3 with s = 1 - t; b1 and b2 include the
/// binomial factors 3. No term cancels another by construction. Its value is therefore accurate to a few roundings of
/// the largest coefficient, unlike the power form's.
template <class T>
struct Cubic {
  T b0, b1, b2, b3;

  SOFTCD_HD T operator()(T t) const {
    const T s = T(1) - t;
    const T tt = t * t;
    return ((b0 * s + b1 * t) * s + b2 * tt) * s + b3 * (tt * t);
  }

  SOFTCD_HD T slope(T t) const {
    const T s = T(1) - t;
    return ((b1 - T(3) * b0) * s + T(2) * (b2 - b1) * t) * s + (T(3) * b3 - b2) * (t * t);
  }
};

/// Two times in ascending order that split [0, 1] into intervals on which the cubic is monotone, up to a few roundings
/// of the largest coefficient. Missing splits are 1.
template <class T>
struct Splits {
  T first, second;
};

/// Finds the roots of the derivative d0 s^2 + 2 d1 s t + d2 t^2. With r = t / s they solve d2 r^2 + 2 d1 r + d0 = 0. z
/// has the sign of -d1 and is a sum of two terms of one sign, so neither root suffers from cancellation.
template <class T>
SOFTCD_HD Splits<T> monotone_splits(const Cubic<T>& cubic) {
  const T d0 = cubic.b1 - T(3) * cubic.b0;
  const T d1 = cubic.b2 - cubic.b1;
  const T d2 = T(3) * cubic.b3 - cubic.b2;
  const T discriminant = d1 * d1 - d0 * d2;
  Splits<T> splits{T(1), T(1)};
  if (discriminant > T(0)) {
    const T root = square_root(discriminant);
    const T z = d1 > T(0) ? -d1 - root : root - d1;
    const T p = z * d2 > T(0) ? z / (z + d2) : T(1);
    const T q = z * d0 > T(0) ? d0 / (z + d0) : T(1);
    splits = {smaller(p, q), larger(p, q)};
  }
  return splits;
}

/// Finds the end of the stretch from `from` on which a monotone cubic keeps its sign and stays above `bound` in
/// magnitude. Returns a point in that stretch, close to its end or to `to`; returns `from` itself when the stretch is
/// empty.
///
/// Newton's iteration runs from `guess` towards the value 9/8 bound, and halves the bracket when it does not converge.
/// It stops when the value is within 5/4 bound. When the iterations run out, the result is valid, but nearer to `from`
/// than necessary.
template <class T>
SOFTCD_HD T last_clear(const Cubic<T>& cubic, T bound, T from, T to, T guess) {
  constexpr int kMaxIterations = 40;
  const T at_from = cubic(from);
  const T sign = at_from < T(0) ? T(-1) : T(1);
  if (!(sign * at_from > bound)) return from;
  T clear = from;
  T blocked = to;
  T t = (guess > from && guess < to) || (guess < from && guess > to) ? guess : from;
  T last_step = magnitude(to - from);
  T step_before = last_step;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const T excess = sign * cubic(t) - bound;
    (excess > T(0) ? clear : blocked) = t;
    if (excess > T(0) && excess <= T(0.25) * bound) {
      break;
    }
    T next = t - (excess - T(0.125) * bound) / (sign * cubic.slope(t));
    const bool is_bracketed = (next > clear && next < blocked) || (next < clear && next > blocked);
    const bool is_converging = magnitude(next - t) <= T(0.5) * step_before;
    if (!is_bracketed || !is_converging) {
      next = T(0.5) * (clear + blocked);
    }
    step_before = last_step;
    last_step = magnitude(next - t);
    if (next == clear || next == blocked) {
      break;
    }
    t = next;
  }
  return clear;
}

/// Returns the root of the straight line from (begin, at_begin) to (end, at_end), whose end values have different
/// signs.
template <class T>
SOFTCD_HD T secant_root(T begin, T end, T at_begin, T at_end) {
  return begin + (end - begin) * (at_begin / (at_begin - at_end));
}

/// Returns the first root in [0, 1] of g0 s^2 + 2 g1 s t + g2 t^2, s = 1 - t, which is positive at 0. Returns 1 only
/// when there is certainly no root, and NaN when a coefficient is NaN.
template <class T>
SOFTCD_HD T first_root(T g0, T g1, T g2) {
  const T discriminant = g1 * g1 - g0 * g2;
  if ((g1 >= T(0) && g2 >= T(0)) || discriminant < T(0)) {
    return T(1);
  }
  const T root = square_root(discriminant);
  return g1 < T(0) ? g0 / (g0 + (root - g1)) : (g1 + root) / ((g1 + root) - g2);
}

}  // namespace softcd::detail
