#include "softcd/stages/kept_pairs.hpp"

#include <vector>

#include "enumeration.hpp"
#include "softcd/math/end_volumes.hpp"
#include "softcd/math/kdop.hpp"

/// Pairs of triangles that were kept serve a detection as long as neither triangle has left its kept volume.
namespace softcd::test {
namespace {

struct Interval {
  float lo, hi;
};

/// Returns all intervals between so many places. What volumes compare is the order of bounds, so that intervals with
/// eight bounds between eight places stand for all numbers.
std::vector<Interval> intervals_between(int places) {
  std::vector<Interval> intervals;
  for (int lo = 0; lo < places; ++lo) {
    for (int hi = lo; hi < places; ++hi) intervals.push_back({static_cast<float>(lo), static_cast<float>(hi)});
  }
  return intervals;
}

/// A volume with this interval along `axis`, and [0, 7] along all others.
Kdop18 volume_along(int axis, Interval interval) {
  Kdop18 volume{};
  for (int other = 0; other < kKdopAxes; ++other) {
    volume.lo[other] = other == axis ? interval.lo : 0.0F;
    volume.hi[other] = other == axis ? interval.hi : 7.0F;
  }
  return volume;
}

constexpr bool is_within(Interval inner, Interval outer) {
  return outer.lo <= inner.lo && inner.hi <= outer.hi;
}
constexpr bool meet(Interval a, Interval b) {
  return a.lo <= b.hi && b.lo <= a.hi;
}

struct Counted {
  std::uint32_t count = 0;
  void push(std::uint32_t /*triangle*/) { ++count; }
};

/// Whether FindEscaped reports a triangle with this volume.
bool escapes(const Kdop18& volume, const Kdop18& kept) {
  Counted active, escaped;
  TriangleShape shape{};
  FindEscaped{&volume, &kept, &shape}(0, active, escaped);
  EXPECT_EQ(active.count, 1U);
  EXPECT_EQ((shape.flags & kEscapedTriangle) != 0U, escaped.count > 0);
  return escaped.count > 0;
}

// Statement 23. A triangle is reported if and only if it is not within its kept volume: for all orders of four bounds
// along each axis.
TEST(KeptPairs, have_escaped_triangles_reported) {
  const std::vector<Interval> all = intervals_between(8);
  Enumeration volumes(std::uint64_t{kKdopAxes} * 36 * 36);
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    for (const Interval now : all) {
      for (const Interval kept : all) {
        ASSERT_EQ(escapes(volume_along(axis, now), volume_along(axis, kept)), !is_within(now, kept)) << axis;
        volumes.next();
      }
    }
  }
}

// Statement 24. If two volumes overlap and neither triangle has escaped, their kept volumes overlap: for all orders of
// the eight bounds along each axis. It is about two triangles alone, so that it also serves pairs of triangles that did
// not escape when others did.
TEST(KeptPairs, have_all_pairs_of_triangles_that_did_not_escape) {
  const std::vector<Interval> all = intervals_between(8);
  Enumeration volumes(std::uint64_t{kKdopAxes} * 36 * 36 * 36 * 36);
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    for (const Interval kept_a : all) {
      for (const Interval now_a : all) {
        const Kdop18 kept_volume_a = volume_along(axis, kept_a), volume_a = volume_along(axis, now_a);
        volumes.add(36 * 36);
        if (escapes(volume_a, kept_volume_a)) continue;
        for (const Interval kept_b : all) {
          for (const Interval now_b : all) {
            const Kdop18 kept_volume_b = volume_along(axis, kept_b), volume_b = volume_along(axis, now_b);
            if (escapes(volume_b, kept_volume_b) || !overlap(volume_a, volume_b)) continue;
            ASSERT_TRUE(overlap(kept_volume_a, kept_volume_b)) << axis;
          }
        }
      }
    }
  }
}

// Statement 25. Volumes overlap if and only if their intervals meet along all nine axes: along each axis one is below,
// touches, or is above the other.
TEST(Volumes, overlap_if_all_intervals_meet) {
  constexpr Interval kPlaces[3] = {{0, 1}, {2, 4}, {5, 6}};
  constexpr Interval kOther = {1.5F, 2.0F};
  Enumeration volumes(19683);
  for (int i = 0; i < 19683; ++i) {
    Kdop18 a{}, b{};
    bool all_meet = true;
    for (int axis = 0, rest = i; axis < kKdopAxes; ++axis, rest /= 3) {
      const Interval place = kPlaces[rest % 3];
      a.lo[axis] = place.lo;
      a.hi[axis] = place.hi;
      b.lo[axis] = kOther.lo;
      b.hi[axis] = kOther.hi;
      all_meet &= meet(place, kOther);
    }
    ASSERT_EQ(overlap(a, b), all_meet) << i;
    ASSERT_EQ(overlap(b, a), all_meet) << i;
    ASSERT_EQ(generic::overlap(a, b), all_meet) << i;
    volumes.next();
  }
}

// Statement 26. If the volumes over a step do not overlap, the volumes at its ends are apart throughout. So TestKept,
// which compares the former first, leaves out no pair that a search finds. For all orders of eight bounds along each
// axis.
TEST(KeptPairs, are_not_left_out_because_swept_volumes_are_apart) {
  const std::vector<Interval> all = intervals_between(8);
  Enumeration volumes(std::uint64_t{kKdopAxes} * 36 * 36 * 36 * 36);
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    for (const Interval a0 : all) {
      for (const Interval a1 : all) {
        const Kdop18 a_t0 = volume_along(axis, a0), a_t1 = volume_along(axis, a1);
        const Kdop18 swept_a = merged(a_t0, a_t1);
        const EndVolumes ends_a = end_volumes(a_t0, a_t1);
        for (const Interval b0 : all) {
          for (const Interval b1 : all) {
            const Kdop18 b_t0 = volume_along(axis, b0), b_t1 = volume_along(axis, b1);
            const bool are_apart = certainly_apart_throughout(ends_a, end_volumes(b_t0, b_t1));
            const bool overlap_swept = overlap(swept_a, merged(b_t0, b_t1));
            const bool expected = (a0.hi < b0.lo && a1.hi < b1.lo) || (b0.hi < a0.lo && b1.hi < a1.lo);
            if (are_apart != expected || (!overlap_swept && !are_apart)) FAIL() << axis;
          }
        }
        volumes.add(36 * 36);
      }
    }
  }
}

}  // namespace
}  // namespace softcd::test
