#pragma once

#include <cstdint>

#include "softcd/grid/boxed_entry.hpp"
#include "softcd/stages/cell_assignment.hpp"

namespace softcd {

/// Returns the first position whose key is not less than `key`, a key of the block that ends at `from`. Gallops
/// backwards, so that it costs the logarithm of the distance.
SOFTCD_HD inline std::uint32_t gallop_back(const std::uint32_t* keys, std::uint32_t from, std::uint32_t key) {
  std::uint32_t step = 1;
  while (step <= from && !(keys[from - step] < key)) step *= 2;
  const std::uint32_t begin = step <= from ? from - step : 0;
  return static_cast<std::uint32_t>(lower_bound_index(keys, begin, from - step / 2, key));
}

/// Returns a rank: an entry has to be tested with entries before it in its cell whose rank is lower.
template <class Control>
SOFTCD_HD std::uint32_t partner_ranks(const SceneView& scene, std::uint32_t rank) {
  if (scene.self_collision) return 8U - Control::lowest_partner_k(7U - rank);
  return scene.body_count <= 8U ? rank : rank + 1U;
}

/// Returns a triangle's BoxedBounds along an axis.
template <bool kSwept>
SOFTCD_HD EndVolumes::Axis boxed_bounds(const Kdop18* volumes, const EndVolumes* end_volumes, int axis,
                                        std::uint32_t t) {
  if constexpr (kSwept) return end_volumes[t].axes[axis];
  const Kdop18& volume = volumes[t];
  return {volume.lo[axis], volume.hi[axis], volume.lo[3 + axis], volume.hi[3 + axis]};
}

/// Prepares each sorted entry for its tests. Stores its triangle's boxes beside it. Finds where its cell begins, and
/// how many entries before it in the cell may have to be tested with it. Swept, triangles count where they are at both
/// ends of the step, else by `volumes`.
template <class Control, bool kSwept>
struct PrepareEntry {
  SceneView scene;
  const Kdop18* volumes;
  const EndVolumes* end_volumes;  ///< null unless swept
  const GridParameters* grid;
  const std::uint32_t* keys;
  const Entry* entries;
  BoxedEntry* boxed_entries;
  std::uint32_t* partner_begin;
  std::uint32_t* partner_count;

  template <class Cells>
  SOFTCD_HD void operator()(std::uint32_t j, Cells& cells) const {
    const std::uint32_t key = keys[j];
    const std::uint32_t cell = key & ~7U;
    const std::uint32_t begin = gallop_back(keys, j, cell);
    if (begin == j) cells.push(j);
    const std::uint32_t ranks = partner_ranks<Control>(scene, key_rank(key));
    const std::uint32_t end =
        ranks > key_rank(key)
            ? j
            : static_cast<std::uint32_t>(lower_bound_index<std::uint32_t>(keys, begin, j, cell + ranks));
    write(j, key, entries[j], begin, end - begin);
  }

  /// Stores what the tests of an entry need at its place.
  SOFTCD_HD void write(std::uint32_t place, std::uint32_t key, Entry entry, std::uint32_t first_partner,
                       std::uint32_t partners) const {
    BoxedBounds bounds;
    for (int axis = 0; axis < 3; ++axis) {
      bounds[axis] = boxed_bounds<kSwept>(volumes, end_volumes, axis, entry.root);
    }
    const std::uint32_t offset = scene.has_batches ? scene.cell_offset(scene.element_body(entry.root)) : 0U;
    const std::uint32_t own_cell = moved_cell(key_cell(key), opposite_cell(offset));
    boxed_entries[place] = boxed<kSwept, Control>(bounds, own_cell, grid->inverse_cell_size, entry);
    partner_begin[place] = first_partner;
    partner_count[place] = partners;
  }
};

}  // namespace softcd
