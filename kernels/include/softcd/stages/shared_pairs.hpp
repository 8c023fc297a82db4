#pragma once

#include <cstdint>

#include "softcd/core/bits.hpp"
#include "softcd/core/count.hpp"
#include "softcd/grid/partition.hpp"
#include "softcd/mesh/triangle_edges.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/pair_tests.hpp"
#include "softcd/stages/split_cells.hpp"

/// Several ranks find pairs of split triangles in several cells, as one detection finds them several times. The rank
/// that has the first common cell keeps a pair. Each rank finds that out alone, as it knows the cells of all children.
namespace softcd {

struct ForgetSplit {
  std::uint32_t* split_of;

  SOFTCD_HD void operator()(std::uint32_t triangle) const { split_of[triangle] = kNoIndex; }
};

/// split_of[t] is the number of triangle t among the split ones.
struct NumberSplit {
  const SplitRoot* splits;
  std::uint32_t* split_of;

  SOFTCD_HD void operator()(std::uint32_t split) const { split_of[splits[split].root] = split; }
};

/// The cells that a triangle is registered in, whole or split, row by row.
class TriangleCells {
 public:
  SOFTCD_HD TriangleCells(const Kdop18& volume, float inverse_cell_size, std::uint32_t split, const SplitBits& bits)
      : cells_(integer_dop(volume, inverse_cell_size)),
        box_(split == kNoIndex ? SplitBox{} : bits.boxes[split]),
        words_(split == kNoIndex ? nullptr : bits.of(split)) {}

  SOFTCD_HD int lo(int axis) const { return cells_.lo[axis]; }
  SOFTCD_HD int hi(int axis) const { return cells_.hi[axis]; }

  /// Returns bits: bit i says whether the triangle is in cell (x + i, y, z), which is within its box for i = 0.
  SOFTCD_HD std::uint32_t bits_from(int x, int y, int z) const {
    if (words_ == nullptr) return bits_of(cells_.row(y, z), x);
    const auto row = static_cast<std::uint32_t>((z - box_.z) * box_.height + (y - box_.y));
    const std::uint32_t* word = words_ + row * box_.words_per_row() + static_cast<std::uint32_t>(x - box_.x) / 32U;
    const std::uint32_t shift = static_cast<std::uint32_t>(x - box_.x) & 31U;
    const bool has_next = static_cast<std::uint32_t>(x - box_.x) / 32U + 1U < box_.words_per_row();
    return shift == 0U ? *word : (*word >> shift) | (has_next ? word[1] << (32U - shift) : 0U);
  }

 private:
  static SOFTCD_HD std::uint32_t bits_of(CellInterval row, int x) {
    const int first = larger(row.lo - x, 0);
    const int last = smaller(row.hi - x, 31);
    return last < first ? 0U : (0xFFFFFFFFU >> (31 - (last - first))) << first;
  }

  IntegerDop cells_;
  SplitBox box_;
  const std::uint32_t* words_;  ///< null if the triangle is whole
};

/// Sets `cell` to the first common one, by z, then y, then x. Returns false if there is none.
SOFTCD_HD inline bool first_common_cell(const TriangleCells& a, const TriangleCells& b, Cell& cell) {
  const int begin = larger(a.lo(0), b.lo(0));
  const int end = smaller(a.hi(0), b.hi(0));
  for (int z = larger(a.lo(2), b.lo(2)); z <= smaller(a.hi(2), b.hi(2)); ++z) {
    for (int y = larger(a.lo(1), b.lo(1)); y <= smaller(a.hi(1), b.hi(1)); ++y) {
      for (int x = begin; x <= end; x += 32) {
        const std::uint32_t common = a.bits_from(x, y, z) & b.bits_from(x, y, z);
        if (common == 0U) continue;
        cell = {x + lowest_bit(common), y, z};
        return true;
      }
    }
  }
  return false;
}

/// Keeps the first of each run of equal pairs if it is the rank's.
struct KeepOwnFirst {
  const std::uint64_t* pairs;
  SceneView scene;
  Partition partition;
  const Kdop18* volumes;
  const GridParameters* grid;
  const std::uint32_t* split_of;
  SplitBits bits;

  template <class Pairs, class PatchPairs>
  SOFTCD_HD void operator()(std::uint32_t i, Pairs& kept, PatchPairs& kept_patches) const {
    if (i > 0 && pairs[i - 1] == pairs[i]) return;
    const auto a = static_cast<std::uint32_t>(pairs[i] >> 32);
    const auto b = static_cast<std::uint32_t>(pairs[i]);
    if (!have_room(a) || !have_room(b)) return;
    Cell cell{};
    // They met in a cell of this rank. If none were found, a pair too often would be better than a lost one.
    const bool is_found = first_common_cell(cells_of(a), cells_of(b), cell);
    const std::uint32_t offset = scene.cell_offset(scene.element_body(a));
    if (!is_found || partition.has(moved_cell(cell_index(cell), offset)))
      push_pair(scene, pairs[i], kept, kept_patches);
  }

 private:
  /// Whether the element's bits fit. If not, the detection is repeated.
  SOFTCD_HD bool have_room(std::uint32_t element) const {
    const std::uint32_t split = split_at(element);
    return split == kNoIndex || bits.has(split);
  }
  SOFTCD_HD TriangleCells cells_of(std::uint32_t element) const {
    return {volumes[element], grid->inverse_cell_size, split_at(element), bits};
  }
  /// Returns the element's number among split triangles. Patches are whole.
  SOFTCD_HD std::uint32_t split_at(std::uint32_t element) const {
    return scene.is_patch(element) ? kNoIndex : split_of[element];
  }
};

/// Samples the cells of the sorted entries' tests; see TestSamples.
struct SampleTests {
  const std::uint32_t* keys;
  const std::uint64_t* test_offsets;
  Count entries;
  const std::uint64_t* tests;
  std::uint32_t* cells;

  SOFTCD_HD void operator()(std::uint32_t i) const {
    const std::uint64_t count = entries.get();
    if (count == 0) return;
    const std::uint64_t wanted = *tests * i / kTestSamples;
    // The last entry whose tests begin there or before: entries without tests come first.
    const std::uint64_t after = lower_bound_index<std::uint64_t>(test_offsets, 0, count, wanted + 1);
    cells[i] = key_cell(keys[after - 1]);
  }
};

}  // namespace softcd
