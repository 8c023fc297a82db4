#pragma once

#include <cstdint>

#include "softcd/grid/control_bits.hpp"
#include "softcd/math/simd.hpp"
#include "softcd/stages/cell_assignment.hpp"

namespace softcd {

/// A sorted entry and the box of its triangle, all that most of its tests read, in two rows of four.
struct alignas(16) BoxedEntry {
  Vec3f lo;
  std::uint32_t root;
  Vec3f hi;
  std::uint32_t bits;

  SOFTCD_HD constexpr Entry entry() const { return {root, bits}; }
};

SOFTCD_HD inline BoxedEntry boxed(const Box& box, Entry entry) {
  return {box.lo, entry.root, box.hi, entry.bits};
}

namespace generic {
SOFTCD_HD inline bool boxes_overlap(const BoxedEntry& a, const BoxedEntry& b) {
  return overlap(Box{a.lo, a.hi}, Box{b.lo, b.hi});
}
}  // namespace generic

SOFTCD_HD inline bool boxes_overlap(const BoxedEntry& a, const BoxedEntry& b) {
#ifdef SOFTCD_SSE2
  const __m128 a_begins_first = _mm_cmple_ps(_mm_load_ps(&a.lo.x), _mm_load_ps(&b.hi.x));
  const __m128 b_begins_first = _mm_cmple_ps(_mm_load_ps(&b.lo.x), _mm_load_ps(&a.hi.x));
  return (_mm_movemask_ps(_mm_and_ps(a_begins_first, b_begins_first)) & 7) == 7;
#else
  return generic::boxes_overlap(a, b);
#endif
}

/// First position whose key is not less than `key`, for a key of the block that ends at `from`: gallops backwards, so
/// it costs the logarithm of the distance.
SOFTCD_HD inline std::uint32_t gallop_back(const std::uint32_t* keys, std::uint32_t from, std::uint32_t key) {
  std::uint32_t step = 1;
  while (step <= from && !(keys[from - step] < key)) step *= 2;
  const std::uint32_t begin = step <= from ? from - step : 0;
  return static_cast<std::uint32_t>(lower_bound_index(keys, begin, from - step / 2, key));
}

/// An entry has to be tested with those before it in its cell whose rank is below this.
template <class Control>
SOFTCD_HD std::uint32_t partner_ranks(const SceneView& scene, std::uint32_t rank) {
  if (scene.self_collision) return 8U - Control::lowest_partner_k(7U - rank);
  return scene.body_count <= 8U ? rank : rank + 1U;
}

/// Prepares each sorted entry for its tests: lays its triangle's box beside it, and finds where its cell begins and how
/// many entries before it in the cell it may have to be tested with.
template <class Control>
struct PrepareEntry {
  SceneView scene;
  const Kdop18* volumes;
  const std::uint32_t* keys;
  const Entry* entries;
  BoxedEntry* boxed_entries;
  std::uint32_t* partner_begin;
  std::uint32_t* partner_count;

  template <class Cells>
  SOFTCD_HD void operator()(std::uint32_t j, Cells& cells) const {
    const Entry entry = entries[j];
    boxed_entries[j] = boxed(box_of(volumes[entry.root]), entry);

    const std::uint32_t key = keys[j];
    const std::uint32_t cell = key & ~7U;
    const std::uint32_t begin = gallop_back(keys, j, cell);
    if (begin == j) cells.push(j);
    const std::uint32_t ranks = partner_ranks<Control>(scene, key_rank(key));
    const std::uint32_t end =
        ranks > key_rank(key)
            ? j
            : static_cast<std::uint32_t>(lower_bound_index<std::uint32_t>(keys, begin, j, cell + ranks));
    partner_begin[j] = begin;
    partner_count[j] = end - begin;
  }
};

}  // namespace softcd
