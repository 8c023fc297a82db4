#include "lanes/stars.hpp"

#include "lanes/targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lanes/stars.cpp"  // NOLINT(readability-identifier-naming): Highway wants it
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/vectors-inl.hpp"

// Compiled once for each kind of processor, in a namespace of its own.
HWY_BEFORE_NAMESPACE();
namespace softcd::cpu::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

void test_stars(const TestStar& test, std::uint32_t begin, std::uint32_t end) {
  for (std::uint32_t i = begin; i < end; ++i) test(i);
}

#else

constexpr std::size_t kMostOfRing = kMostTrianglesOfStar + 1;

/// The rings of as many stars as registers have lanes, at one end of the step, relative to the centres. A star of fewer
/// triangles than others repeats its centre.
struct Rings {
  Vector of[kMostOfRing];
};

HWY_INLINE Vector ring_vertex(const VertexStar* stars, const Vec3f* x, const Vector& centre, std::size_t i) {
  const auto index = [&](std::size_t lane) {
    const std::uint32_t v = stars[lane].ring[i];
    return v == kNoIndex ? stars[lane].centre : v;
  };
  return load([&](std::size_t lane) -> const Vec3f& { return x[index(lane)]; }) - centre;
}

HWY_INLINE Rings rings_of(const VertexStar* stars, const Vec3f* x) {
  static_assert(kMostOfRing == 9);
  const Vector centre = load([&](std::size_t lane) -> const Vec3f& { return x[stars[lane].centre]; });
  const auto at = [&](std::size_t i) { return ring_vertex(stars, x, centre, i); };
  return {{at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8)}};
}

/// Does the same as detail::QuadraticBounds.
struct QuadraticBounds {
  Float b0, b1, b2;

  HWY_INLINE Float lowest() const { return smaller(smaller(b0, b1), b2); }
  HWY_INLINE Float highest() const { return larger(larger(b0, b1), b2); }
};

template <bool kSwept>
HWY_INLINE QuadraticBounds area_along(const Vector& n, const Vector& a_t0, const Vector& a_t1, const Vector& b_t0,
                                      const Vector& b_t1) {
  const Float at_t1 = dot(n, cross(a_t1, b_t1));
  if constexpr (!kSwept) return {at_t1, at_t1, at_t1};
  return {dot(n, cross(a_t0, b_t0)), hn::Mul(all(0.5F), dot(n, cross(a_t0, b_t1) + cross(a_t1, b_t0))), at_t1};
}

HWY_INLINE Float dot_along(const Vector& n, const Vector& a, const Vector& b) {
  return hn::Sub(dot(a, b), hn::Mul(dot(n, a), dot(n, b)));
}
template <bool kSwept>
HWY_INLINE QuadraticBounds dots_along(const Vector& n, const Vector& a_t0, const Vector& a_t1, const Vector& b_t0,
                                      const Vector& b_t1) {
  const Float at_t1 = dot_along(n, a_t1, b_t1);
  if constexpr (!kSwept) return {at_t1, at_t1, at_t1};
  return {dot_along(n, a_t0, b_t0), hn::Mul(all(0.5F), hn::Add(dot_along(n, a_t0, b_t1), dot_along(n, a_t1, b_t0))),
          at_t1};
}

/// The shapes of as many stars as registers have lanes.
struct Shapes {
  Float triangle_count;
  Mask is_closed;
  Mask is_none;
  Float distance;
};

HWY_INLINE Shapes shapes_of(const TestStar& test, const VertexStar* stars) {
  const Floats floats;
  alignas(64) float counts[kLanes];
  alignas(64) float closed[kLanes];
  alignas(64) float distances[kLanes];
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const VertexStar& star = stars[lane];
    std::size_t count = 0;
    while (count < kMostOfRing && star.ring[count] != kNoIndex) ++count;
    counts[lane] = static_cast<float>(count);
    closed[lane] = count > 0 && star.ring[count - 1] == star.ring[0] ? 1.0F : 0.0F;
    distances[lane] = test.distance_of(star);
  }
  const Float zero = hn::Zero(floats);
  const Float count = hn::Load(floats, counts);
  return {hn::Sub(count, all(1.0F)), hn::Gt(hn::Load(floats, closed), zero), hn::Eq(count, zero),
          hn::Load(floats, distances)};
}

/// Does the same as is_certainly_spread() of softcd.
template <bool kSwept>
HWY_INLINE Mask are_certainly_spread(const Rings& t0, const Rings& t1, const Shapes& shapes) {
  const Floats floats;
  const Float zero = hn::Zero(floats);
  Vector normal = {zero, zero, zero};
  Float longest = dot(t1.of[0], t1.of[0]);
  if constexpr (kSwept) longest = larger(longest, dot(t0.of[0], t0.of[0]));
  const auto squared_norm = [](const Vector& a) { return dot(a, a); };
  // Triangles that a star does not have are without area, and not longer than others.
  for (std::size_t i = 0; i < kMostTrianglesOfStar; ++i) {
    normal = normal + cross(t1.of[i], t1.of[i + 1]);
    longest = larger(longest, larger(squared_norm(t1.of[i + 1]), squared_norm(t1.of[i + 1] - t1.of[i])));
    if constexpr (kSwept) {
      normal = normal + cross(t0.of[i], t0.of[i + 1]);
      longest = larger(longest, larger(squared_norm(t0.of[i + 1]), squared_norm(t0.of[i + 1] - t0.of[i])));
    }
  }
  longest = hn::Sqrt(longest);
  const Float length = norm(normal);
  const Mask is_ordinary =
      hn::And(hn::And(hn::Ge(longest, all(detail::kShortestEdge)), hn::Le(longest, all(detail::kLongestEdge))),
              hn::Ge(length, all(detail::kShortestNormal)));
  const Vector n = hn::Div(all(1.0F), length) * normal;
  const Vector first = t1.of[0] - dot(n, t1.of[0]) * n;
  Mask was_behind = hn::Gt(zero, zero);
  Float returns = zero;
  Float least = all(FLT_MAX);
  Vector last_t1 = t1.of[0];
  Vector last_t0 = t0.of[0];
  for (std::size_t i = 0; i < kMostTrianglesOfStar; ++i) {
    const Mask has_triangle = hn::Gt(shapes.triangle_count, all(static_cast<float>(i)));
    if (hn::AllFalse(floats, has_triangle)) break;
    const Float area = area_along<kSwept>(n, t0.of[i], t1.of[i], t0.of[i + 1], t1.of[i + 1]).lowest();
    least = hn::IfThenElse(has_triangle, smaller(least, area), least);
    const Mask is_behind = hn::AndNot(hn::Gt(dot(first, t1.of[i + 1]), zero), has_triangle);
    const Mask has_returned = hn::AndNot(is_behind, hn::And(was_behind, has_triangle));
    returns = hn::Add(returns, hn::IfThenElseZero(has_returned, all(1.0F)));
    was_behind = is_behind;
    last_t1 = chosen(has_triangle, t1.of[i + 1], last_t1);
    if constexpr (kSwept) last_t0 = chosen(has_triangle, t0.of[i + 1], last_t0);
  }
  const Float altitude =
      hn::Mul(all(detail::kAltitudeFactor), larger(shapes.distance, hn::Mul(all(detail::kLeastAltitude), longest)));
  const Mask is_thick = hn::And(is_ordinary, hn::Gt(least, hn::Mul(altitude, longest)));
  const Mask is_wide = hn::Le(dots_along<kSwept>(n, t0.of[0], t1.of[0], last_t0, last_t1).highest(), zero);
  const Mask is_narrow = hn::Gt(area_along<kSwept>(n, t0.of[0], t1.of[0], last_t0, last_t1).lowest(), zero);
  const Mask closed_turns_once = hn::And(shapes.is_closed, hn::Eq(returns, all(1.0F)));
  const Mask open_turns_less = hn::AndNot(shapes.is_closed, hn::And(hn::Eq(returns, zero), hn::Or(is_wide, is_narrow)));
  return hn::AndNot(shapes.is_none, hn::And(is_thick, hn::Or(closed_turns_once, open_turns_less)));
}

template <bool kSwept>
HWY_INLINE void test_register(const TestStar& test, const VertexStar* stars) {
  const Rings t1 = rings_of(stars, test.scene.x_t1);
  const Rings t0 = kSwept ? rings_of(stars, test.scene.x_t0) : t1;
  const Mask are_spread = are_certainly_spread<kSwept>(t0, t1, shapes_of(test, stars));
  alignas(64) float values[kLanes];
  hn::Store(hn::IfThenElseZero(are_spread, all(1.0F)), Floats(), values);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    test.spread.vertices[stars[lane].centre] = values[lane] > 0.0F ? 1 : 0;
  }
}

void test_stars(const TestStar& test, std::uint32_t begin, std::uint32_t end) {
  std::uint32_t i = begin;
  for (; i + kLanes <= end; i += kLanes) {
    if (test.scene.is_swept) {
      test_register<true>(test, test.stars + i);
    } else {
      test_register<false>(test, test.stars + i);
    }
  }
  for (; i < end; ++i) test(i);
}

#endif

}  // namespace softcd::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace softcd::cpu {

HWY_EXPORT(test_stars);

void for_range(const TestStar& test, std::uint32_t begin, std::uint32_t end) {
  HWY_DYNAMIC_DISPATCH(test_stars)(test, begin, end);
}

}  // namespace softcd::cpu
#endif
