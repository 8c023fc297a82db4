#pragma once

#include <cfloat>
#include <cstdint>

#include "softcd/grid/boxed_entry.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/cell_ranges.hpp"

/// A sweep along one axis, which replaces the grid if triangles are few. A triangle has one entry. Its partners are the
/// entries behind it that begin before it ends.
namespace softcd {

/// The parameters of a sweep, which are chosen and read in the backend's memory.
struct Sweep {
  bool is_possible;
  int axis;
  float begin;              ///< of the first triangle along the axis
  float keys_per_unit;      ///< along the axis
  float inverse_cell_size;  ///< of the cells that boxes are counted in
  std::uint32_t cell;       ///< that they are counted from
};

/// Keys need 2 of the sort's passes.
constexpr int kSweepKeyBits = 16;
/// Cells along the longest side of all triangles' box: half of those that a BoxedEntry reaches to either side.
constexpr float kSweepCells = 60.0F;
/// A triangle that is larger than this many mean ones needs the grid, which may split it.
constexpr float kLargestOfSweep = 0.5F * kWholeSize * kExactCellSizeFactor;
/// Tests per triangle beyond which the grid costs less. On one core 16 tests of a sweep took about 10 ns, and a
/// triangle's entries in the grid 400 ns.
constexpr std::uint64_t kMostSweepTests = 384;

/// Bounds and sums of all triangles' volumes.
struct SweptBox {
  float lo[3] = {FLT_MAX, FLT_MAX, FLT_MAX};
  float hi[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
  float widths[3] = {0.0F, 0.0F, 0.0F};  ///< added up
  float radii = 0.0F;                    ///< added up
  float largest_radius = 0.0F;
  std::uint32_t count = 0;

  SOFTCD_HD void extend(const Kdop18& volume, const TriangleShape& shape) {
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = smaller(lo[axis], volume.lo[axis]);
      hi[axis] = larger(hi[axis], volume.hi[axis]);
      widths[axis] += volume.hi[axis] - volume.lo[axis];
    }
    radii += shape.radius + shape.growth;
    largest_radius = larger(largest_radius, shape.radius);
    ++count;
  }

  SOFTCD_HD float extent(int axis) const { return hi[axis] - lo[axis]; }

  /// Returns the axis along which a triangle begins before the fewest others end.
  SOFTCD_HD int best_axis() const {
    int best = 0;
    for (int axis = 1; axis < 3; ++axis) {
      if (widths[axis] * extent(best) < widths[best] * extent(axis)) best = axis;
    }
    return best;
  }
};

/// Chooses the axis and the scales of a sweep, in the calling team's leader alone.
struct ChooseSweep {
  const Kdop18* volumes;
  const TriangleShape* shapes;
  Count triangles;
  Sweep* sweep;
  GridParameters* grid;  ///< gets the statistics of triangles; it has no cells

  template <class Team>
  SOFTCD_HD void operator()(Team& team) const {
    if (!team.is_leader()) return;
    SweptBox box;
    for (std::uint32_t t = 0; t < triangles.get(); ++t) {
      if (!is_empty(volumes[t])) box.extend(volumes[t], shapes[t]);
    }
    const float mean = box.count > 0 ? box.radii / static_cast<float>(box.count) : 0.0F;
    *grid = {0.0F, 0.0F, mean, box.count, box.count};
    *sweep = sweep_through(box);
    sweep->is_possible &= box.largest_radius <= kLargestOfSweep * mean;
  }

 private:
  static SOFTCD_HD Sweep sweep_through(const SweptBox& box) {
    if (box.count == 0) return {};
    const int axis = box.best_axis();
    float furthest = 0.0F;
    float longest = 0.0F;
    for (int i = 0; i < 3; ++i) {
      furthest = larger(furthest, larger(magnitude(box.lo[i]), magnitude(box.hi[i])));
      longest = larger(longest, box.extent(i));
    }
    const GridParameters cells =
        grid_of_size(larger(longest / kSweepCells, 8.0F * furthest / kGridExtent), 0.0F, 0U, 0U);
    const Vec3f middle = {0.5F * (box.lo[0] + box.hi[0]), 0.5F * (box.lo[1] + box.hi[1]),
                          0.5F * (box.lo[2] + box.hi[2])};
    const float keys = static_cast<float>((1 << kSweepKeyBits) - 1) / box.extent(axis);
    const bool is_possible = furthest < 1.0e37F && keys > 0.0F && keys < 1.0e37F;
    if (!is_possible) return {};
    return {
        true, axis, box.lo[axis], keys, cells.inverse_cell_size, cell_index(cell_of(middle, cells.inverse_cell_size))};
  }
};

/// Returns a key that ascends with the coordinate along the sweep's axis.
SOFTCD_HD inline std::uint32_t sweep_key(const Sweep& sweep, float coordinate) {
  constexpr float kLast = static_cast<float>((1 << kSweepKeyBits) - 1);
  return static_cast<std::uint32_t>(smaller((coordinate - sweep.begin) * sweep.keys_per_unit, kLast));
}

/// Appends the entry of a triangle that takes part.
struct RegisterForSweep {
  SceneView scene;
  const Kdop18* volumes;
  const TriangleShape* shapes;
  const Sweep* sweep;

  template <class Entries>
  SOFTCD_HD void operator()(std::uint32_t t, Entries& entries) const {
    const Kdop18& volume = volumes[t];
    if (is_empty(volume)) return;
    const std::uint32_t body = scene.triangle_body[t];
    const std::uint32_t bits = entry_bits(mask_of(body), body, wanted_features(shapes[t].flags));
    entries.push({sweep_key(*sweep, volume.lo[sweep->axis]), {t, bits}});
  }

 private:
  /// Returns a body's own bit unless it collides with itself. ExactControl skips entries with a common bit.
  SOFTCD_HD std::uint32_t mask_of(std::uint32_t body) const {
    const std::uint32_t own_class = body % kBodyClasses;
    const bool may_touch_itself = ((scene.class_may_touch[own_class] >> own_class) & 1U) != 0U;
    return body < kMaskBits && !may_touch_itself ? 1U << body : 0U;
  }
};

/// Prepares each sorted entry for its tests, like PrepareEntry.
template <bool kSwept>
struct PrepareSweptEntry {
  const Kdop18* volumes;
  const EndVolumes* end_volumes;  ///< null unless swept
  const Sweep* sweep;
  Count entry_count;
  const std::uint32_t* keys;
  const Entry* entries;
  BoxedEntry* boxed_entries;
  std::uint32_t* partner_begin;
  std::uint32_t* partner_count;

  SOFTCD_HD void operator()(std::uint32_t j) const {
    const Entry entry = entries[j];
    BoxedBounds bounds;
    for (int axis = 0; axis < 3; ++axis) {
      bounds[axis] = boxed_bounds<kSwept>(volumes, end_volumes, axis, entry.root);
    }
    boxed_entries[j] = boxed<kSwept>(bounds, sweep->cell, sweep->inverse_cell_size, entry);
    const std::uint32_t last_key = sweep_key(*sweep, volumes[entry.root].hi[sweep->axis]);
    const std::uint64_t end = lower_bound_index<std::uint32_t>(keys, j + 1, entry_count.get(), last_key + 1);
    partner_begin[j] = j + 1;
    partner_count[j] = static_cast<std::uint32_t>(end) - (j + 1);
  }
};

}  // namespace softcd
