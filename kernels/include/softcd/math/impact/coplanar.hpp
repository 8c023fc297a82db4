#pragma once

#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/math/cubic.hpp"
#include "softcd/math/impact/advancement.hpp"

namespace softcd::detail {

/// Returns the first touch while the points are coplanar or nearly so: |cubic| <= bound. A tangential root has no
/// change of sign. It is still found, at the end of two monotone intervals, where the value is within the bound.
template <ContactKind kKind, class T>
SOFTCD_HD Touch<T> first_coplanar_touch(const Motion<T>& motion, const Cubic<T>& cubic, T bound) {
  const Splits<T> splits = monotone_splits(cubic);
  T begin = T(0);
  T end = splits.first;
  for (int piece = 0; piece < 3; ++piece) {
    const T at_begin = cubic(begin);
    const T at_end = cubic(end);
    const bool is_clear = (at_begin > bound && at_end > bound) || (at_begin < -bound && at_end < -bound);
    if (begin < end && !is_clear) {
      const T first = last_clear(cubic, bound, begin, end, secant_root(begin, end, at_begin, at_end));
      // The values go from bound to -bound with a similar slope.
      const auto find_last = [&] {
        return last_clear(cubic, bound, end, begin, first + T(2.25) * bound / magnitude(cubic.slope(first)));
      };
      const Touch<T> touch = first_touch<kKind>(motion, first, find_last);
      if (touch.is_hit) {
        return touch;
      }
    }
    begin = end;
    end = piece == 0 ? splits.second : T(1);
  }
  return touch_nowhere<T>();
}

}  // namespace softcd::detail
