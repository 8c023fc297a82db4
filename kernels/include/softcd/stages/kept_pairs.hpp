#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/math/kdop.hpp"
#include "softcd/stages/pair_tests.hpp"

/// Pairs of triangles that an earlier detection kept, for a detection whose volumes lie within the kept ones.
namespace softcd {

/// Counts the triangles that take part, and those of them that are not within their kept volumes.
struct FindEscaped {
  const Kdop18* volumes;
  const Kdop18* kept_volumes;

  template <class Active, class Escaped>
  SOFTCD_HD void operator()(std::uint32_t t, Active& active, Escaped& escaped) const {
    const Kdop18& volume = volumes[t];
    if (is_empty(volume)) return;
    active.push(t);
    if (!contains(kept_volumes[t], volume)) escaped.push(t);
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

/// Tests a kept pair as a detection tests two triangles that meet in a cell.
template <bool kSwept>
struct TestKept {
  PairTest<kSwept> test;
  const std::uint64_t* kept;

  template <class Pairs>
  SOFTCD_HD void operator()(std::uint32_t i, Pairs& pairs) const {
    const auto t = static_cast<std::uint32_t>(kept[i] >> 32);
    const auto u = static_cast<std::uint32_t>(kept[i]);
    if (!overlap(test.volumes[t], test.volumes[u])) return;
    const Entry a = test.entry_of(t);
    const Entry b = test.entry_of(u);
    if (!test.classes_may_touch(test.touchable_classes(a), b) || !test.own_features(a, b)) return;
    if (test.may_touch(a, b)) pairs.push(kept[i]);
  }
};

}  // namespace softcd
