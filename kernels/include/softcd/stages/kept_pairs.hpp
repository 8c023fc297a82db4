#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/math/kdop.hpp"
#include "softcd/stages/pair_tests.hpp"

/// Pairs of triangles that an earlier detection kept, for a detection of which most volumes lie within the kept ones.
/// Other triangles have escaped. A pair of volumes that overlap is found by exactly one of two stages:
/// - by TestKept if neither triangle has escaped. Their kept volumes then overlap, too, so that the pair was kept;
/// - by LookUpEscaped if one has, or both have. It compares each escaped triangle with all others.
namespace softcd {

/// The most escaped triangles that are looked up. For more, a new search takes no longer.
constexpr std::uint32_t kMostEscaped = 512;
/// Escaped triangles that are skipped at once if the volume around them is apart from another triangle's.
constexpr std::uint32_t kEscapedGroup = 16;

/// Counts the triangles that take part. Lists and flags those of them that are not within their kept volumes.
struct FindEscaped {
  const Kdop18* volumes;
  const Kdop18* kept_volumes;
  TriangleShape* shapes;

  template <class Active, class Escaped>
  SOFTCD_HD void operator()(std::uint32_t t, Active& active, Escaped& escaped) const {
    const Kdop18& volume = volumes[t];
    if (is_empty(volume)) return;
    active.push(t);
    if (!contains(kept_volumes[t], volume)) {
      shapes[t].flags |= kEscapedTriangle;
      escaped.push(t);
    }
  }
};

/// Returns how far a triangle is from leaving its kept volume; less than 0 once it has. 0 if one of the two volumes is
/// empty.
struct MeasureHeadroom {
  const Kdop18* volumes;
  const Kdop18* kept_volumes;

  SOFTCD_HD float operator()(std::uint32_t t) const {
    constexpr float kDiagonalUnit = 0.707106769F;
    const Kdop18& volume = volumes[t];
    const Kdop18& kept = kept_volumes[t];
    if (is_empty(volume) || is_empty(kept)) return 0.0F;
    float least = FLT_MAX;
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      const float room = smaller(volume.lo[axis] - kept.lo[axis], kept.hi[axis] - volume.hi[axis]);
      least = smaller(least, axis < 3 ? room : kDiagonalUnit * room);
    }
    return least;
  }
};

/// Keeps a triangle's volume, grown by `slack`, if it has one.
struct KeepVolume {
  const Kdop18* volumes;
  Kdop18* kept_volumes;
  float slack;

  SOFTCD_HD void operator()(std::uint32_t t) const {
    Kdop18 volume = volumes[t];
    inflate(volume, slack);
    kept_volumes[t] = volume;
  }
};

/// Tests a pair of triangles as a detection tests two that meet in a cell. Kept pairs share no vertex, because pairs
/// are kept only where neighbours are listed.
template <bool kMayShareVertex, bool kSwept>
SOFTCD_HD bool may_touch_outside_cells(const PairTest<kSwept>& test, std::uint32_t t, std::uint32_t u) {
  if (!overlap(test.volumes[t], test.volumes[u])) return false;
  if constexpr (!kMayShareVertex && !kSwept) {
    if (!test.meet_within_volumes(t, u)) return false;
  }
  const Entry a = test.entry_of(t);
  const Entry b = test.entry_of(u);
  if (!test.classes_may_touch(test.touchable_classes(a), b) || !test.own_features(a, b)) return false;
  if constexpr (kMayShareVertex) return test.may_touch(a, b);
  if (!test.bodies_may_touch(a, b)) return false;
  if constexpr (kSwept) return test.may_meet(t, u);
  return true;
}

/// Tests a kept pair. Leaves out pairs of triangles that have one of the flags `left_out`, if any.
template <bool kSwept>
struct TestKept {
  PairTest<kSwept> test;
  const std::uint64_t* kept;
  std::uint32_t left_out;

  template <class Pairs>
  SOFTCD_HD void operator()(std::uint32_t i, Pairs& pairs) const {
    const auto t = static_cast<std::uint32_t>(kept[i] >> 32);
    const auto u = static_cast<std::uint32_t>(kept[i]);
    if (left_out != 0U && ((test.shapes[t].flags | test.shapes[u].flags) & left_out) != 0U) return;
    if (may_touch_outside_cells<false>(test, t, u)) pairs.push(kept[i]);
  }
};

/// The triangles that have escaped, at most kMostEscaped.
struct EscapedTriangles {
  const std::uint32_t* triangles;
  const std::uint64_t* count;
};

/// A group of escaped triangles, bounded as one.
struct EscapedGroup {
  Kdop18 volume;          ///< around all of them
  std::uint32_t classes;  ///< bits of their bodies' classes
};

/// Bounds a group of escaped triangles.
struct BoundEscaped {
  EscapedTriangles escaped;
  const std::uint32_t* triangle_body;
  const Kdop18* volumes;
  EscapedGroup* groups;

  SOFTCD_HD void operator()(std::uint32_t group) const {
    EscapedGroup bounds{empty_kdop(), 0U};
    for (std::uint32_t i = group * kEscapedGroup; i < (group + 1) * kEscapedGroup && i < *escaped.count; ++i) {
      const std::uint32_t t = escaped.triangles[i];
      bounds.volume = merged(bounds.volume, volumes[t]);
      bounds.classes |= 1U << (triangle_body[t] % kBodyClasses);
    }
    groups[group] = bounds;
  }
};

/// Finds the pairs of a triangle with escaped ones. Two that have both escaped find their pair from the higher one.
template <bool kSwept>
struct LookUpEscaped {
  PairTest<kSwept> test;
  EscapedTriangles escaped;
  const EscapedGroup* groups;

  template <class Pairs>
  SOFTCD_HD void operator()(std::uint32_t t, Pairs& pairs) const {
    const Kdop18& volume = test.volumes[t];
    if (is_empty(volume)) return;
    const bool has_escaped = (test.shapes[t].flags & kEscapedTriangle) != 0U;
    const std::uint32_t touchable = test.touchable_classes(test.entry_of(t));
    for (std::uint32_t i = 0; i < *escaped.count; ++i) {
      if (i % kEscapedGroup == 0 && !may_have_partners(groups[i / kEscapedGroup], touchable, volume)) {
        i += kEscapedGroup - 1;
        continue;
      }
      const std::uint32_t u = escaped.triangles[i];
      if (u == t || (has_escaped && t < u)) continue;
      if (may_touch_outside_cells<true>(test, smaller(t, u), larger(t, u))) pairs.push(pair_key(t, u));
    }
  }

 private:
  static SOFTCD_HD bool may_have_partners(const EscapedGroup& group, std::uint32_t touchable, const Kdop18& volume) {
    return (group.classes & touchable) != 0U && overlap(group.volume, volume);
  }
};

}  // namespace softcd
