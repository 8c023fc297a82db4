#pragma once

#include <cstdint>

#include "softcd/core/bits.hpp"
#include "softcd/math/end_volumes.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/pair_tests.hpp"

/// Patches: up to kPatchSize neighbouring triangles that take part in the broad phase as one. A patch whose triangles
/// are far apart, or too large for the cells, is *loose*: its triangles take part one by one.
namespace softcd {

/// A patch is loose if its half diagonal is more than so many mean radii of its triangles. Eight triangles of a strip
/// have 3, of a compact patch 2. A triangle that is much larger than the others makes their patch loose.
constexpr float kLargestPatch = 4.0F;

/// The lower bounds of a patch's triangles, then the upper ones. Each axis of a Kdop18 has the values of all triangles
/// side by side; swept, those at t0, then those at t1. Bounds without a triangle are empty, and own nothing.
template <bool kSwept>
struct alignas(16) PatchBounds {
  static constexpr int kEnds = kSwept ? 2 : 1;

  float lo[kKdopAxes][kEnds][kPatchSize];
  float hi[kKdopAxes][kEnds][kPatchSize];
  std::uint32_t v[3][kPatchSize];  ///< the triangles' vertices
  std::uint32_t vertex_owners;     ///< bits: triangles that own vertices that are wanted
  std::uint32_t edge_owners;       ///< the same of edges

  /// Sets whether the triangle owns any of its `features`, bits of wanted_features().
  SOFTCD_HD void set_owned(std::uint32_t i, std::uint32_t features) {
    vertex_owners = (vertex_owners & ~(1U << i)) | std::uint32_t{(features & 7U) != 0U} << i;
    edge_owners = (edge_owners & ~(1U << i)) | std::uint32_t{(features & 56U) != 0U} << i;
  }
  /// Returns bits: the triangles of which, or the one in the row of `other`, owns a feature that could touch the other.
  SOFTCD_HD std::uint32_t owners_with(const PatchBounds& other, std::uint32_t row) const {
    constexpr std::uint32_t kAll = (1U << kPatchSize) - 1U;
    if ((other.vertex_owners >> row & 1U) != 0U) return kAll;
    return vertex_owners | ((other.edge_owners >> row & 1U) != 0U ? edge_owners : 0U);
  }

  SOFTCD_HD void set(std::uint32_t i, const Triangle& triangle) {
    for (int corner = 0; corner < 3; ++corner) v[corner][i] = triangle.v[corner];
  }
  SOFTCD_HD void set(std::uint32_t i, const Kdop18& volume) {
    static_assert(!kSwept);
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      lo[axis][0][i] = volume.lo[axis];
      hi[axis][0][i] = volume.hi[axis];
    }
  }
  SOFTCD_HD void set(std::uint32_t i, const EndVolumes& ends) {
    static_assert(kSwept);
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      const EndVolumes::Axis on = ends.axes[axis];
      lo[axis][0][i] = on.t0_lo;
      hi[axis][0][i] = on.t0_hi;
      lo[axis][kEnds - 1][i] = on.t1_lo;
      hi[axis][kEnds - 1][i] = on.t1_hi;
    }
  }
};

/// The least values of `kRows` rows, or the greatest ones.
template <int kRows>
struct RowBounds {
  float of[kRows];
};

namespace generic {
/// Lays the volumes of four triangles side by side, at the patch's triangles from `first` on.
template <bool kSwept, class Volume>
SOFTCD_HD void lay_four(PatchBounds<kSwept>& patch, std::uint32_t first, const Volume* const (&volumes)[4]) {
  for (std::uint32_t i = 0; i < 4; ++i) patch.set(first + i, *volumes[i]);
}

template <bool kGreatest, int kRows>
SOFTCD_HD RowBounds<kRows> bounds_of_rows(const float* rows) {
  RowBounds<kRows> bounds;
  for (int row = 0; row < kRows; ++row) {
    const float* const values = rows + kPatchSize * static_cast<std::uint32_t>(row);
    bounds.of[row] = values[0];
    for (std::uint32_t i = 1; i < kPatchSize; ++i) {
      bounds.of[row] = kGreatest ? larger(bounds.of[row], values[i]) : smaller(bounds.of[row], values[i]);
    }
  }
  return bounds;
}
}  // namespace generic

#ifdef SOFTCD_SSE2
inline void lay_four(PatchBounds<true>& patch, std::uint32_t first, const EndVolumes* const (&volumes)[4]) {
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    __m128 ends[4];
    for (int i = 0; i < 4; ++i) ends[i] = _mm_load_ps(&volumes[i]->axes[axis].t0_lo);
    _MM_TRANSPOSE4_PS(ends[0], ends[1], ends[2], ends[3]);
    float* const rows[4] = {patch.lo[axis][0], patch.hi[axis][0], patch.lo[axis][1], patch.hi[axis][1]};
    for (int end = 0; end < 4; ++end) _mm_store_ps(rows[end] + first, ends[end]);
  }
}

inline void lay_four(PatchBounds<false>& patch, std::uint32_t first, const Kdop18* const (&volumes)[4]) {
  const auto lay_axes = [&](float(&bounds)[kKdopAxes][1][kPatchSize], const float(Kdop18::*side)[kKdopAxes], int axis) {
    __m128 axes[4];
    for (int i = 0; i < 4; ++i) axes[i] = _mm_loadu_ps((volumes[i]->*side) + axis);
    _MM_TRANSPOSE4_PS(axes[0], axes[1], axes[2], axes[3]);
    for (int k = 0; k < 4; ++k) _mm_store_ps(bounds[axis + k][0] + first, axes[k]);
  };
  // The last four axes overlap those before.
  for (const int axis : {0, 4, 5}) {
    lay_axes(patch.lo, &Kdop18::lo, axis);
    lay_axes(patch.hi, &Kdop18::hi, axis);
  }
}

template <bool kGreatest, int kRows>
RowBounds<kRows> bounds_of_rows(const float* rows) {
  const auto of_two = [](__m128 a, __m128 b) { return kGreatest ? _mm_max_ps(a, b) : _mm_min_ps(a, b); };
  RowBounds<kRows> bounds;
  for (int next = 0; next < kRows; next += 4) {
    const int row = smaller(next, kRows - 4);  // the last four rows overlap those before
    __m128 four[4];
    for (int i = 0; i < 4; ++i) {
      const float* const values = rows + kPatchSize * static_cast<std::uint32_t>(row + i);
      four[i] = of_two(_mm_load_ps(values), _mm_load_ps(values + 4));
    }
    _MM_TRANSPOSE4_PS(four[0], four[1], four[2], four[3]);
    _mm_storeu_ps(bounds.of + row, of_two(of_two(four[0], four[1]), of_two(four[2], four[3])));
  }
  return bounds;
}
#else
template <bool kSwept, class Volume>
SOFTCD_HD void lay_four(PatchBounds<kSwept>& patch, std::uint32_t first, const Volume* const (&volumes)[4]) {
  generic::lay_four(patch, first, volumes);
}
template <bool kGreatest, int kRows>
SOFTCD_HD RowBounds<kRows> bounds_of_rows(const float* rows) {
  return generic::bounds_of_rows<kGreatest, kRows>(rows);
}
#endif

/// Lays the bounds of a patch's triangles side by side, and bounds the patch by them. The volumes of patches are behind
/// those of all triangles; a loose patch has an empty one. Swept, triangles count where they are at both ends of the
/// step.
template <bool kSwept>
struct BoundPatch {
  SceneView scene;
  Kdop18* volumes;
  EndVolumes* end_volumes;  ///< null unless swept
  TriangleShape* shapes;
  PatchBounds<kSwept>* bounds;

  SOFTCD_HD void operator()(std::uint32_t patch) const {
    const std::uint32_t element = scene.patch_element(patch);
    lay(element, bounds[patch]);
    float mean_radius = 0.0F;
    TriangleShape shape = shape_of(element, mean_radius);
    Kdop18 ends[kEnds];
    bound(bounds[patch], ends);
    const Kdop18 volume = kSwept ? merged(ends[0], ends[kEnds - 1]) : ends[0];
    shape.radius = is_empty(volume) ? 0.0F : radius_of(ends, shape.growth);
    const bool is_loose = !(shape.radius <= kLargestPatch * mean_radius);
    if (is_loose) shape.flags |= kLoosePatch;
    volumes[element] = is_loose ? empty_kdop() : volume;
    if constexpr (kSwept) end_volumes[element] = softcd::end_volumes(ends[0], ends[kEnds - 1]);
    shapes[element] = shape;
  }

 private:
  static constexpr int kEnds = PatchBounds<kSwept>::kEnds;
  using Volume = std::conditional_t<kSwept, EndVolumes, Kdop18>;

  SOFTCD_HD const Volume* volume_of(std::uint32_t t) const {
    if constexpr (kSwept) {
      return end_volumes + t;
    } else {
      return volumes + t;
    }
  }

  SOFTCD_HD void lay(std::uint32_t element, PatchBounds<kSwept>& patch) const {
    const Kdop18 empty = empty_kdop();
    const EndVolumes empty_ends = softcd::end_volumes(empty, empty);
    const Volume* nothing = nullptr;
    if constexpr (kSwept) {
      nothing = &empty_ends;
    } else {
      nothing = &empty;
    }
    patch.vertex_owners = patch.edge_owners = 0U;
    for (std::uint32_t first = 0; first < kPatchSize; first += 4) {
      const Volume* four[4];
      for (std::uint32_t k = 0; k < 4; ++k) {
        const std::uint32_t t = scene.element_triangle(element, first + k);
        patch.set_owned(first + k, t == kNoIndex ? 0U : wanted_features(shapes[t].flags));
        patch.set(first + k, t == kNoIndex ? Triangle{{kNoIndex, kNoIndex, kNoIndex}} : scene.triangles[t]);
        four[k] = t == kNoIndex ? nothing : volume_of(t);
      }
      lay_four(patch, first, four);
    }
  }

  /// Returns all but the radius, and sets the mean radius of the triangles.
  SOFTCD_HD TriangleShape shape_of(std::uint32_t element, float& mean_radius) const {
    TriangleShape shape{0.0F, 0.0F, 0U, 0.0F};
    float sum = 0.0F;
    for (std::uint32_t i = 0; i < kPatchSize; ++i) {
      const std::uint32_t t = scene.element_triangle(element, i);
      if (t == kNoIndex) break;
      const TriangleShape its = shapes[t];
      sum += its.radius;
      mean_radius = sum / static_cast<float>(i + 1);
      shape.growth = larger(shape.growth, its.growth);
      shape.rounding = larger(shape.rounding, its.rounding);
      shape.flags |= its.flags & ~kBigTriangle;
    }
    return shape;
  }

  static SOFTCD_HD void bound(const PatchBounds<kSwept>& patch, Kdop18 (&ends)[kEnds]) {
    constexpr int kRows = kKdopAxes * kEnds;
    const RowBounds<kRows> lo = bounds_of_rows<false, kRows>(&patch.lo[0][0][0]);
    const RowBounds<kRows> hi = bounds_of_rows<true, kRows>(&patch.hi[0][0][0]);
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      for (int end = 0; end < kEnds; ++end) {
        ends[end].lo[axis] = lo.of[kEnds * axis + end];
        ends[end].hi[axis] = hi.of[kEnds * axis + end];
      }
    }
  }

  /// Returns the larger of the half diagonals at both ends of the step, without the margin.
  static SOFTCD_HD float radius_of(const Kdop18 (&ends)[kEnds], float growth) {
    constexpr float kBoxCorner = 1.73205081F;
    float radius = 0.0F;
    for (const Kdop18& end : ends) radius = larger(radius, half_diagonal(end));
    return larger(radius - kBoxCorner * growth, 0.0F);
  }
};

/// Measures as MeasureTriangle does: the elements that take part, and the radii of all triangles.
struct MeasurePatch {
  enum Histogram : int { triangle_radius = MeasureTriangle::kHistograms };
  static constexpr int kHistograms = MeasureTriangle::kHistograms + 1;

  SceneView scene;
  MeasureTriangle measure;

  template <class Counter>
  SOFTCD_HD void operator()(std::uint32_t patch, Counter& counter) const {
    const std::uint32_t element = scene.patch_element(patch);
    const bool is_loose = (measure.shapes[element].flags & kLoosePatch) != 0U;
    measure(element, counter);
    for (std::uint32_t i = 0; i < kPatchSize; ++i) {
      const std::uint32_t t = scene.element_triangle(element, i);
      if (t == kNoIndex || is_empty(measure.volumes[t])) continue;
      counter.count(triangle_radius, size_bin(measure.shapes[t].radius + measure.shapes[t].growth));
      if (is_loose) measure(t, counter);
    }
  }
};

/// Registers a patch in the cells of its volume. If it is loose or too large, appends its triangles to `loose` instead.
/// A patch whose triangles may touch each other is a pair with itself.
struct RegisterPatch {
  using Item = Registration;

  CellRegistrar registrar;

  SOFTCD_HD Registration load_item(std::uint32_t patch) const {
    const std::uint32_t element = registrar.scene.patch_element(patch);
    const Kdop18 volume = registrar.volumes[element];
    const TriangleShape shape = registrar.shapes[element];
    Registration work{};
    work.element = element;
    if ((shape.flags & kLoosePatch) != 0U) {
      work.placement = Placement::loose;
    } else if (!is_empty(volume)) {
      work = registrar.whole(element, volume, shape);
      const bool is_too_large = !(shape.radius <= kWholeSize * registrar.size_limit(shape));
      if (is_too_large || work.placement == Placement::big) work.placement = Placement::loose;
    }
    return work;
  }

  template <class Entries, class Loose, class PatchPairs>
  SOFTCD_HD void operator()(const Registration& work, std::uint32_t part, Entries& entries, Loose& loose,
                            PatchPairs& patch_pairs) const {
    const SceneView& scene = registrar.scene;
    if (work.placement == Placement::loose) {
      registrar.shapes[work.element].flags |= kLoosePatch;
      for (std::uint32_t i = 0; i < kPatchSize; ++i) {
        const std::uint32_t t = scene.element_triangle(work.element, i);
        if (t != kNoIndex && !is_empty(registrar.volumes[t])) loose.push(t);
      }
      return;
    }
    if (part == 0 && is_its_rank(work) && may_touch_itself(work.body)) {
      patch_pairs.push(pair_key(work.element, work.element));
    }
    registrar.register_row(work, part, entries);
  }

 private:
  SOFTCD_HD bool may_touch_itself(std::uint32_t body) const {
    const std::uint32_t its_class = body % kBodyClasses;
    return ((registrar.scene.class_may_touch[its_class] >> its_class) & 1U) != 0U &&
           (registrar.scene.body_count <= kBodyClasses || registrar.scene.bodies_may_touch(body, body));
  }

  /// Whether the rank has the cell at the lower corner of the patch's cells: one of several ranks does.
  SOFTCD_HD bool is_its_rank(const Registration& work) const {
    const int(&lo)[kKdopAxes] = work.cells.lo;
    return registrar.partition.has(moved_cell(cell_index({lo[0], lo[1], lo[2]}), work.cell_offset));
  }
};

/// Two patches, or a triangle and a patch, or a patch and itself, that may touch.
struct PatchWork {
  std::uint32_t a, b;
  bool has_two_patches;    ///< `a` is a patch, too
  bool leaves_neighbours;  ///< omits pairs that share a vertex: their features are listed

  SOFTCD_HD std::uint32_t part_count() const { return has_two_patches ? kPatchSize * kPatchSize : kPatchSize; }
};

/// Two triangles whose volumes meet. If they share no vertex, swept ones also meet on their paths, see move_past().
struct MeetingTriangles {
  std::uint32_t a, b;
  bool may_share_vertex;
};

/// Finds the pairs of triangles of a pair with a patch. Lanes decide which parts meet (cpu/lanes/patches.hpp). Part k
/// is the pair of triangle k / kPatchSize of `a` and triangle k % kPatchSize of `b`.
template <bool kSwept>
struct ExpandPatchPair {
  using Item = PatchWork;
  using Candidate = MeetingTriangles;
  using Bounds = PatchBounds<kSwept>;

  PairTest<kSwept> pair_test;
  const Bounds* bounds;
  const std::uint64_t* patch_pairs;

  SOFTCD_HD Item load_item(std::uint32_t i) const {
    const SceneView& scene = pair_test.scene;
    const auto a = static_cast<std::uint32_t>(patch_pairs[i] >> 32);
    const auto b = static_cast<std::uint32_t>(patch_pairs[i]);
    return {a, b, scene.is_patch(a), scene.self_collision && scene.bodies[scene.element_body(a)].lists_neighbours};
  }

  /// Sets `candidate` to the pair of a part.
  SOFTCD_HD void list(const Item& work, std::uint32_t part, Candidate& candidate) const {
    const SceneView& scene = pair_test.scene;
    candidate = {scene.element_triangle(work.a, part / kPatchSize), scene.element_triangle(work.b, part % kPatchSize),
                 scene.self_collision && !work.leaves_neighbours};
  }

  /// Appends a pair whose volumes meet, and that is not left out, if its features may touch.
  template <class Pairs>
  SOFTCD_HD void test_meeting(const Candidate& candidate, Pairs& pairs) const {
    if (may_touch(candidate)) pairs.push(pair_key(candidate.a, candidate.b));
  }
  SOFTCD_HD bool may_touch(const Candidate& candidate) const {
    if (candidate.may_share_vertex) return pair_test.meeting_triangles_may_touch(candidate.a, candidate.b);
    return kSwept || pair_test.meet_within_volumes(candidate.a, candidate.b);
  }
  SOFTCD_HD bool may_share_vertex(const Item& work) const {
    return pair_test.scene.self_collision && !work.leaves_neighbours;
  }

  SOFTCD_HD const Bounds& bounds_of(std::uint32_t patch_element) const {
    return bounds[patch_element - pair_test.scene.triangle_count];
  }
  /// Stores the bounds of a triangle as the first of a patch.
  SOFTCD_HD void load_first(std::uint32_t triangle, Bounds& one) const {
    one.set(0, pair_test.scene.triangles[triangle]);
    one.vertex_owners = one.edge_owners = 0U;
    one.set_owned(0, wanted_features(pair_test.shapes[triangle].flags));
    if constexpr (kSwept) {
      one.set(0, pair_test.end_volumes[triangle]);
    } else {
      one.set(0, pair_test.volumes[triangle]);
    }
  }

  /// Returns the bounds along an axis; at rest, the same for both ends.
  SOFTCD_HD EndVolumes::Axis bounds_on(int axis, std::uint32_t element) const {
    if constexpr (kSwept) return pair_test.end_volumes[element].axes[axis];
    const Kdop18& volume = pair_test.volumes[element];
    return {volume.lo[axis], volume.hi[axis], volume.lo[axis], volume.hi[axis]};
  }
};

/// Finds the pairs of triangles of a pair with a patch twice: all whose kept volumes overlap, to keep them, and those
/// of them that ExpandPatchPair<kSwept> would find, for the detection itself. Tests the latter while their volumes are
/// at hand. Pairs that share a vertex are neither, because pairs are kept only where neighbours are listed.
template <bool kSwept>
struct KeepPatchPair : ExpandPatchPair<false> {
  PairTest<kSwept> test;  ///< of the volumes of this detection

  template <class Kept, class Pairs>
  SOFTCD_HD void test_meeting(const Candidate& candidate, Kept& kept, Pairs& pairs) const {
    if (!this->may_touch(candidate)) return;
    const std::uint64_t pair = pair_key(candidate.a, candidate.b);
    kept.push(pair);
    if (test.may_meet(candidate.a, candidate.b)) pairs.push(pair);
  }
};

}  // namespace softcd
