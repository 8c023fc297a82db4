#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

#include "probing.hpp"

namespace softcd::test {

inline bool has(Span<const TriangleOverlap> overlaps, const PlacedTriangle& triangle) {
  return std::any_of(overlaps.begin(), overlaps.end(), [&](const TriangleOverlap& overlap) {
    return overlap.body == triangle.body && overlap.triangle == triangle.index;
  });
}

inline void expect_in_order(Span<const TriangleOverlap> overlaps) {
  for (std::size_t i = 1; i < overlaps.size(); ++i) {
    const TriangleOverlap& a = overlaps[i - 1];
    const TriangleOverlap& b = overlaps[i];
    ASSERT_TRUE(a.body < b.body || (a.body == b.body && a.triangle < b.triangle)) << "at " << i;
  }
}

}  // namespace softcd::test
