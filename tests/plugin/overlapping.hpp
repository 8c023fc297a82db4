#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

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

/// Points p with dot(normal, p) <= offset.
struct HalfSpace {
  Vec3d normal;
  double offset;
};

/// Returns whether a part of the triangle remains after cutting off everything outside of the solid, grown by `growth`.
inline bool has_part_in(const PlacedTriangle& triangle, const std::vector<HalfSpace>& solid, double growth) {
  std::vector<LongVec3> polygon;
  for (const Vec3d& x : triangle.x) polygon.push_back(vec3_cast<long double>(x));
  for (const HalfSpace& side : solid) {
    std::vector<LongVec3> kept;
    const auto depth = [&](const LongVec3& p) {
      return static_cast<long double>(side.offset) + growth - dot(vec3_cast<long double>(side.normal), p);
    };
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const LongVec3& p = polygon[i];
      const LongVec3& q = polygon[(i + 1) % polygon.size()];
      if (depth(p) >= 0) kept.push_back(p);
      if ((depth(p) >= 0) != (depth(q) >= 0)) kept.push_back(lerp(p, q, depth(p) / (depth(p) - depth(q))));
    }
    polygon = kept;
  }
  return !polygon.empty();
}

/// The relation of a shape and a triangle, up to rounding.
enum class Verdict { overlapping, apart, unsure };

/// Returns the verdict on a triangle and a solid that is known to `slack`.
inline Verdict verdict_on(const PlacedTriangle& triangle, const std::vector<HalfSpace>& solid, double slack) {
  if (has_part_in(triangle, solid, -slack)) return Verdict::overlapping;
  return has_part_in(triangle, solid, slack) ? Verdict::unsure : Verdict::apart;
}
/// Returns the verdict on shapes at the distance `gap`, or, where it is negative, at that depth.
inline Verdict verdict_on(double gap, double slack) {
  if (gap < -slack) return Verdict::overlapping;
  return gap > slack ? Verdict::apart : Verdict::unsure;
}

/// Returns the queries of shapes.
template <class Shape>
const std::vector<Shape>& queries_of(const std::vector<Shape>& shapes) {
  return shapes;
}

/// Asks a probe in every odd scene about shapes that `make(random, extent, triangles)` makes. Expects for each shape
/// and each triangle the result of `judge(shape, triangle, extent)`. Returns how many certainly overlap.
template <class Make, class Judge>
std::size_t compare_overlaps(std::uint64_t seed, const Make& make, const Judge& judge) {
  std::size_t certain = 0;
  for (NamedScene& named : odd_scenes()) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const std::vector<PlacedTriangle> triangles = placed_triangles(probed);
    Random random(seed);
    const auto shapes = make(random, extent, triangles);
    const AnswerLists<TriangleOverlap> found = probed.probe.overlaps(queries_of(shapes));
    EXPECT_EQ(found.size(), shapes.size());
    for (std::size_t i = 0; i < shapes.size() && !testing::Test::HasFailure(); ++i) {
      expect_in_order(found[i]);
      std::size_t count = 0;
      for (const PlacedTriangle& t : triangles) {
        const bool is_found = has(found[i], t);
        const Verdict verdict = judge(shapes[i], t, extent);
        if (is_found) ++count;
        if (verdict == Verdict::overlapping) ++certain;
        EXPECT_TRUE(verdict == Verdict::unsure || is_found == (verdict == Verdict::overlapping))
            << "shape " << i << ", body " << t.body.value << ", triangle " << t.index;
      }
      EXPECT_EQ(found[i].size(), count) << "shape " << i;
    }
  }
  return certain;
}

}  // namespace softcd::test
