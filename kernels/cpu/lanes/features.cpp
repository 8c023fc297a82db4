#include "lanes/features.hpp"

#include <algorithm>
#include <array>

#include "lanes/targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lanes/features.cpp"  // NOLINT(readability-identifier-naming): Highway wants it
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/vectors-inl.hpp"

// Compiled once for each kind of processor, in a namespace of its own.
HWY_BEFORE_NAMESPACE();
namespace softcd::cpu::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

template <ContactKind kKind, bool kSwept>
std::uint64_t keep(const FeatureTest<kKind, kSwept>& test, const FeatureCandidate* candidates, std::uint32_t count) {
  return generic::candidates_to_keep(test, candidates, count);
}

#else

/// The vertices of as many candidates as registers have lanes.
struct Points {
  Vector p[4];

  HWY_INLINE Points(const Vec3f* x, const FeatureCandidate* candidates)
      : p{load_vertex(x, candidates, 0), load_vertex(x, candidates, 1), load_vertex(x, candidates, 2),
          load_vertex(x, candidates, 3)} {}

 private:
  static HWY_INLINE Vector load_vertex(const Vec3f* x, const FeatureCandidate* candidates, int vertex) {
    return load([&](std::size_t i) -> const Vec3f& { return x[candidates[i].vertices.v[vertex]]; });
  }
};

/// The candidates whose feature a, or b, ends before the other begins.
struct Gaps {
  Mask below, above;
};

template <ContactKind kKind, int kAxis>
HWY_INLINE Gaps gaps(const Points& points, Float distance) {
  constexpr int kSplit = kKind == ContactKind::vertex_triangle ? 1 : 2;
  Float a_lo = project<kAxis>(points.p[0]);
  Float a_hi = a_lo;
  for (int i = 1; i < kSplit; ++i) {
    const Float at = project<kAxis>(points.p[i]);
    a_lo = smaller(a_lo, at);
    a_hi = larger(a_hi, at);
  }
  Float b_lo = project<kAxis>(points.p[kSplit]);
  Float b_hi = b_lo;
  for (int i = kSplit + 1; i < 4; ++i) {
    const Float at = project<kAxis>(points.p[i]);
    b_lo = smaller(b_lo, at);
    b_hi = larger(b_hi, at);
  }
  return {hn::Lt(outward_up(hn::Add(a_hi, distance)), b_lo), hn::Lt(outward_up(hn::Add(b_hi, distance)), a_lo)};
}

/// Returns the candidates whose features are apart along an axis: swept, at both times, else at t1.
template <ContactKind kKind, bool kSwept, int kAxis>
HWY_INLINE Mask apart_on_axis(const Points& t0, const Points& t1, Float distance) {
  const Gaps end = gaps<kKind, kAxis>(t1, distance);
  if constexpr (!kSwept) return hn::Or(end.below, end.above);
  const Gaps begin = gaps<kKind, kAxis>(t0, distance);
  return hn::Or(hn::And(end.below, begin.below), hn::And(end.above, begin.above));
}

template <ContactKind kKind, bool kSwept>
HWY_INLINE Mask apart_on_straight_axes(const Points& t0, const Points& t1, Float distance) {
  return hn::Or(
      hn::Or(apart_on_axis<kKind, kSwept, 0>(t0, t1, distance), apart_on_axis<kKind, kSwept, 1>(t0, t1, distance)),
      apart_on_axis<kKind, kSwept, 2>(t0, t1, distance));
}

struct RelativePair {
  Vector a, b, c;
};

template <ContactKind kKind>
HWY_INLINE RelativePair relative_pair(const Points& x) {
  if constexpr (kKind == ContactKind::vertex_triangle) return {x.p[0] - x.p[1], x.p[2] - x.p[1], x.p[3] - x.p[1]};
  return {x.p[0] - x.p[2], x.p[1] - x.p[0], x.p[3] - x.p[2]};
}

/// The sizes of the features, for the tests of planes.
struct Sizes {
  Float a, b, c;

  HWY_INLINE Float volume() const { return hn::Mul(hn::Mul(a, b), c); }
  HWY_INLINE Float reach(Float margin) const {
    return hn::Add(margin, hn::Mul(all(detail::kDistanceError<float>), hn::Add(hn::Add(a, b), c)));
  }
  HWY_INLINE Mask has_volume() const {
    return hn::Ge(smaller(volume(), hn::Mul(b, c)), all(detail::smallest_product<float>()));
  }
  HWY_INLINE Float extent() const { return larger(larger(a, b), c); }
};

HWY_INLINE Sizes sizes(const RelativePair& pair) {
  return {max_norm(pair.a), max_norm(pair.b), max_norm(pair.c)};
}
HWY_INLINE Sizes larger(const Sizes& s, const Sizes& t) {
  return {larger(s.a, t.a), larger(s.b, t.b), larger(s.c, t.c)};
}

HWY_INLINE Mask cannot_reach(Float height, const Vector& plane, Float reach) {
  const Float reachable = hn::Mul(hn::Mul(reach, reach), dot(plane, plane));
  return hn::And(hn::Gt(height, hn::Zero(Floats())), hn::Gt(hn::Mul(height, height), reachable));
}

/// Does the same as detail::is_certainly_apart.
HWY_INLINE Mask certainly_apart(const RelativePair& pair, const Sizes& size, Float margin) {
  const Vector plane = cross(pair.b, pair.c);
  const Float error = hn::Mul(all(detail::kCoefficientError<float>), size.volume());
  const Float height = hn::Sub(hn::Abs(dot(pair.a, plane)), error);
  return hn::And(size.has_volume(), cannot_reach(height, plane, size.reach(margin)));
}

/// Does the same as certainly_outside_slab, for pairs whose scale is 1.
HWY_INLINE Mask certainly_outside_slab(const RelativePair& pair, const Sizes& size, Float margin) {
  const Float zero = hn::Zero(Floats());
  const Vector normal = cross(pair.b, pair.c);
  const Float product = hn::Mul(size.b, size.c);
  const Float error = hn::Mul(all(kSlabCrossError), product);
  const Float twice_area = hn::Sub(norm(normal), error);
  const Float slack = hn::Mul(margin, hn::Sqrt(hn::Div(all(2.0F), twice_area)));
  const Float rounding = hn::Mul(all(kSlabDifferenceError), size.extent());
  const auto is_outside_along = [&](Float a, Float b, Float c, Float normal_along) {
    const Float low = smaller(zero, smaller(b, c));
    const Float high = larger(zero, larger(b, c));
    const Float along_normal = hn::Mul(margin, hn::Div(hn::Add(hn::Abs(normal_along), error), twice_area));
    const Float width = hn::Add(hn::Mul(slack, hn::Sub(high, low)), along_normal);
    const Float beyond = hn::Add(hn::Mul(all(1.0001F), width), rounding);
    return hn::Or(hn::Gt(hn::Sub(a, high), beyond), hn::Gt(hn::Sub(low, a), beyond));
  };
  const Mask is_outside = hn::Or(hn::Or(is_outside_along(pair.a.x, pair.b.x, pair.c.x, normal.x),
                                        is_outside_along(pair.a.y, pair.b.y, pair.c.y, normal.y)),
                                 is_outside_along(pair.a.z, pair.b.z, pair.c.z, normal.z));
  const Mask has_area = hn::And(hn::Gt(twice_area, zero), hn::Ge(product, all(detail::smallest_product<float>())));
  return hn::And(has_area, is_outside);
}

/// Returns whether everything between `lowest` and `highest` is further than `bound` to one side of 0.
HWY_INLINE Mask is_beyond(Float lowest, Float highest, Float bound) {
  return hn::Or(hn::Gt(lowest, bound), hn::Lt(highest, hn::Neg(bound)));
}

/// Does the same as detail::make_query. Returns its is_apart_throughout if the accuracy is conservative, else its
/// is_apart_when_coplanar().
HWY_INLINE Mask certainly_apart_in_motion(const RelativePair& t0, const RelativePair& t1, const Sizes& size,
                                          Float margin, bool is_conservative) {
  const Float reach = size.reach(margin);
  const Float error = hn::Mul(all(detail::kCoefficientError<float>), size.volume());
  const Vector plane_t0 = cross(t0.b, t0.c);
  const Vector plane_t1 = cross(t1.b, t1.c);
  const Vector plane_mixed = cross(t0.b, t1.c) + cross(t1.b, t0.c);
  const Float b0 = dot(t0.a, plane_t0);
  const Float b1 = hn::Add(dot(t1.a, plane_t0), dot(t0.a, plane_mixed));
  const Float b2 = hn::Add(dot(t1.a, plane_mixed), dot(t0.a, plane_t1));
  const Float b3 = dot(t1.a, plane_t1);
  const Float third = all(1.0F / 3.0F);
  const Float lowest = smaller(smaller(b0, b3), hn::Mul(third, smaller(b1, b2)));
  const Float highest = larger(larger(b0, b3), hn::Mul(third, larger(b1, b2)));
  if (is_conservative) {
    const Float longest = larger(larger(norm(plane_t0), hn::Mul(all(0.5F), norm(plane_mixed))), norm(plane_t1));
    const Float length = hn::Mul(all(1.0F + detail::kLengthError<float>), hn::Mul(reach, longest));
    return hn::And(
        size.has_volume(),
        is_beyond(lowest, highest, hn::Add(hn::Mul(all(detail::kHeightError<float>), size.volume()), length)));
  }
  const Mask cannot_reach_t0 = cannot_reach(hn::Sub(hn::Abs(b0), error), plane_t0, reach);
  const Mask cannot_reach_t1 = cannot_reach(hn::Sub(hn::Abs(b3), error), plane_t1, reach);
  return hn::And(hn::And(size.has_volume(), is_beyond(lowest, highest, error)),
                 hn::And(cannot_reach_t0, cannot_reach_t1));
}

/// The differences of the vertices of two features, as softcd::detail::Differences.
template <ContactKind kKind, bool kSwept>
struct Differences {
  static constexpr int kCount = detail::Differences<kKind, kSwept>::kCount;

  Vector at[kCount];
};

template <ContactKind kKind, bool kSwept>
HWY_INLINE Differences<kKind, kSwept> differences_of(const RelativePair& t0, const RelativePair& t1) {
  constexpr bool kIsEdgeEdge = kKind == ContactKind::edge_edge;
  const Vector end_t0 = t0.a + t0.b;
  const Vector end_t1 = t1.a + t1.b;
  if constexpr (kIsEdgeEdge && kSwept) {
    return {{t1.a, t1.a - t1.c, end_t1, end_t1 - t1.c, t0.a, t0.a - t0.c, end_t0, end_t0 - t0.c}};
  } else if constexpr (kIsEdgeEdge) {
    return {{t1.a, t1.a - t1.c, end_t1, end_t1 - t1.c}};
  } else if constexpr (kSwept) {
    return {{t1.a, t1.a - t1.c, t1.a - t1.b, t0.a, t0.a - t0.c, t0.a - t0.b}};
  } else {
    return {{t1.a, t1.a - t1.c, t1.a - t1.b}};
  }
}

/// Does the same as softcd::certainly_apart_in_a_direction, for pairs whose scale is 1, in the lanes that are
/// `undecided`.
template <ContactKind kKind, bool kSwept>
HWY_INLINE Mask certainly_apart_in_a_direction(const RelativePair& t0, const RelativePair& t1, const Sizes& size,
                                               Float margin, Mask undecided) {
  const Floats floats;
  const Float total = hn::Add(hn::Add(size.a, size.b), size.c);
  const Float distance = hn::Add(margin, hn::Mul(all(detail::kSeparationError), total));
  const Float shortest = larger(margin, all(detail::kShortestDirection));
  const Differences<kKind, kSwept> differences = differences_of<kKind, kSwept>(t0, t1);
  Vector n = differences.at[0];
  for (int i = 1; i < differences.kCount; ++i) n = n + differences.at[i];
  n = all(1.0F / static_cast<float>(differences.kCount)) * n;
  Mask is_apart = hn::AndNot(undecided, undecided);
  for (int change = 0;; ++change) {
    const Float length = norm(n);
    undecided = hn::And(undecided, hn::Gt(length, shortest));
    Vector lowest = differences.at[0];
    Float least = dot(n, lowest);
    for (int i = 1; i < differences.kCount; ++i) {
      const Float along = dot(n, differences.at[i]);
      lowest = chosen(hn::Lt(along, least), differences.at[i], lowest);
      least = smaller(along, least);
    }
    const Mask is_beyond = hn::And(undecided, hn::Gt(least, hn::Mul(distance, length)));
    is_apart = hn::Or(is_apart, is_beyond);
    undecided = hn::AndNot(is_beyond, undecided);
    if (change == detail::kMostDirections<kSwept> || hn::AllFalse(floats, undecided)) return is_apart;
    const Vector towards = lowest - n;
    const Float share = hn::Div(hn::Neg(dot(n, towards)), dot(towards, towards));
    n = n + smaller(share, all(1.0F)) * towards;
  }
}

/// Returns one member of as many candidates as registers have lanes.
HWY_INLINE Float members(float FeatureReach::*member, const FeatureCandidate* candidates) {
  alignas(64) float values[kLanes];
  for (std::size_t i = 0; i < kLanes; ++i) values[i] = candidates[i].reach.*member;
  return hn::Load(Floats(), values);
}

/// Returns bits of as many candidates as registers have lanes.
template <ContactKind kKind, bool kSwept>
HWY_INLINE std::uint64_t keep_register(const FeatureTest<kKind, kSwept>& test, const FeatureCandidate* candidates) {
  const Floats floats;
  const Float margin = members(&FeatureReach::distance, candidates);
  const Mask has_margin = hn::Gt(margin, hn::Zero(floats));
  const Points t1(test.scene.x_t1, candidates);
  const Points t0 = kSwept ? Points(test.scene.x_t0, candidates) : t1;
  Mask is_apart = apart_on_straight_axes<kKind, kSwept>(t0, t1, hn::IfThenElseZero(has_margin, margin));
  if (hn::AllTrue(floats, is_apart)) return 0;
  const RelativePair pair_t1 = relative_pair<kKind>(t1);
  const RelativePair pair_t0 = kSwept ? relative_pair<kKind>(t0) : pair_t1;
  const Sizes size = kSwept ? larger(sizes(pair_t0), sizes(pair_t1)) : sizes(pair_t1);
  if (!are_ordinary(size.extent())) return kept_one_by_one(test, candidates, bits_of(hn::Not(is_apart)));
  if constexpr (kSwept) {
    is_apart = hn::Or(is_apart, certainly_apart_in_motion(pair_t0, pair_t1, size, margin, test.scene.is_conservative));
  } else {
    const bool is_of_slabs = kKind == ContactKind::vertex_triangle && test.scene.has_certain_slabs();
    const Float height = is_of_slabs ? members(&FeatureReach::margin, candidates) : margin;
    is_apart = hn::Or(is_apart, certainly_apart(pair_t1, size, height));
    if (is_of_slabs && !hn::AllTrue(floats, is_apart)) {
      is_apart = hn::Or(is_apart, certainly_outside_slab(pair_t1, size, height));
    }
  }
  is_apart = hn::Or(is_apart,
                    certainly_apart_in_a_direction<kKind, kSwept>(pair_t0, pair_t1, size, margin, hn::Not(is_apart)));
  return bits_of(hn::Not(is_apart));
}

template <ContactKind kKind, bool kSwept>
std::uint64_t keep(const FeatureTest<kKind, kSwept>& test, const FeatureCandidate* candidates, std::uint32_t count) {
  std::uint64_t bits = 0;
  std::uint32_t i = 0;
  for (; i + kLanes <= count; i += kLanes) bits |= keep_register(test, candidates + i) << i;
  if (i == count) return bits;
  // The remaining lanes have the last candidate.
  std::array<FeatureCandidate, kLanes> padded;
  padded.fill(candidates[count - 1]);
  std::copy(candidates + i, candidates + count, padded.begin());
  const std::uint64_t last = keep_register(test, padded.data()) & ((1ULL << (count - i)) - 1U);
  return bits | (last << i);
}

#endif

using VertexTriangleTest = FeatureTest<ContactKind::vertex_triangle, false>;
using VertexTriangleSweep = FeatureTest<ContactKind::vertex_triangle, true>;
using EdgeEdgeTest = FeatureTest<ContactKind::edge_edge, false>;
using EdgeEdgeSweep = FeatureTest<ContactKind::edge_edge, true>;

std::uint64_t keep_vertex_triangle(const VertexTriangleTest& test, const FeatureCandidate* candidates,
                                   std::uint32_t count) {
  return keep(test, candidates, count);
}
std::uint64_t keep_vertex_triangle_swept(const VertexTriangleSweep& test, const FeatureCandidate* candidates,
                                         std::uint32_t count) {
  return keep(test, candidates, count);
}
std::uint64_t keep_edge_edge(const EdgeEdgeTest& test, const FeatureCandidate* candidates, std::uint32_t count) {
  return keep(test, candidates, count);
}
std::uint64_t keep_edge_edge_swept(const EdgeEdgeSweep& test, const FeatureCandidate* candidates, std::uint32_t count) {
  return keep(test, candidates, count);
}

}  // namespace softcd::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace softcd::cpu {

HWY_EXPORT(keep_vertex_triangle);
HWY_EXPORT(keep_vertex_triangle_swept);
HWY_EXPORT(keep_edge_edge);
HWY_EXPORT(keep_edge_edge_swept);

template <>
std::uint64_t candidates_to_keep(const FeatureTest<ContactKind::vertex_triangle, false>& test,
                                 const FeatureCandidate* candidates, std::uint32_t count) {
  return HWY_DYNAMIC_DISPATCH(keep_vertex_triangle)(test, candidates, count);
}
template <>
std::uint64_t candidates_to_keep(const FeatureTest<ContactKind::vertex_triangle, true>& test,
                                 const FeatureCandidate* candidates, std::uint32_t count) {
  return HWY_DYNAMIC_DISPATCH(keep_vertex_triangle_swept)(test, candidates, count);
}
template <>
std::uint64_t candidates_to_keep(const FeatureTest<ContactKind::edge_edge, false>& test,
                                 const FeatureCandidate* candidates, std::uint32_t count) {
  return HWY_DYNAMIC_DISPATCH(keep_edge_edge)(test, candidates, count);
}
template <>
std::uint64_t candidates_to_keep(const FeatureTest<ContactKind::edge_edge, true>& test,
                                 const FeatureCandidate* candidates, std::uint32_t count) {
  return HWY_DYNAMIC_DISPATCH(keep_edge_edge_swept)(test, candidates, count);
}

}  // namespace softcd::cpu
#endif
