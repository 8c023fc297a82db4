#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/grid/control_bits.hpp"
#include "softcd/grid/uniform_grid.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/grid_parameters.hpp"
#include "softcd/stages/virtual_subdivision.hpp"

namespace softcd {

/// An entry with its sort key.
struct KeyedEntry {
  std::uint32_t key;
  Entry entry;
};

/// A triangle that is represented in the grid by children: 4^level in space, times 2^halvings in time (`paper` only).
struct SplitRoot {
  std::uint32_t root;
  std::uint16_t level;
  std::uint16_t halvings;

  SOFTCD_HD constexpr std::uint32_t child_count() const { return 1U << (2 * level + halvings); }
};

/// A cell that a child of `root` is registered in: root:32 | cell:27 from high to low. Several children may give the
/// same.
struct SplitCell {
  std::uint64_t key;
  std::uint32_t child;  ///< `paper`: child | 2^31 where its centre lies in another cell, so that less is better
};

constexpr std::uint32_t kPhantomChild = 0x80000000U;

SOFTCD_HD constexpr std::uint64_t split_key(std::uint32_t root, std::uint32_t cell) {
  return (static_cast<std::uint64_t>(root) << (3 * kCellBits)) | cell;
}
SOFTCD_HD constexpr std::uint32_t split_key_cell(std::uint64_t key) {
  return static_cast<std::uint32_t>(key & ((1ULL << (3 * kCellBits)) - 1ULL));
}
SOFTCD_HD constexpr std::uint32_t split_key_root(std::uint64_t key) {
  return static_cast<std::uint32_t>(key >> (3 * kCellBits));
}

/// Calls visit(x, y, z, row, below) for every cell of an integer DOP; `below` as lower_neighbour_mask wants it.
template <class Visit>
SOFTCD_HD void for_each_cell(const IntegerDop& cells, Visit visit) {
  for (int z = cells.lo[2]; z <= cells.hi[2]; ++z) {
    const CellInterval column = cells.column(z);
    for (int y = column.lo; y <= column.hi; ++y) {
      const CellInterval row = cells.row(y, z);
      if (row.empty()) continue;
      const CellInterval below[4] = {cells.row(y - 1, z - 1), cells.row(y, z - 1), cells.row(y + 1, z - 1),
                                     cells.row(y - 1, z)};
      for (int x = row.lo; x <= row.hi; ++x) visit(Cell{x, y, z}, row, below);
    }
  }
}

/// Number of cells of an integer DOP.
SOFTCD_HD inline std::uint32_t cell_count(const IntegerDop& cells) {
  std::uint32_t count = 0;
  for (int z = cells.lo[2]; z <= cells.hi[2]; ++z) {
    const CellInterval column = cells.column(z);
    for (int y = column.lo; y <= column.hi; ++y) {
      const CellInterval row = cells.row(y, z);
      if (!row.empty()) count += static_cast<std::uint32_t>(row.hi - row.lo + 1);
    }
  }
  return count;
}

/// `exact` and `uniform`: registers a triangle in the cells of its own volume when it is small enough, else puts it on
/// the list of triangles to split, or, where that would take too many cells, on the list of those tested against all.
struct RegisterTriangle {
  SceneView scene;
  const Kdop18* volumes;
  TriangleShape* shapes;
  const GridParameters* grid;
  bool subdivision;

  template <class Entries, class Splits, class Bigs>
  SOFTCD_HD void operator()(std::uint32_t t, Entries& entries, Splits& splits, Bigs& bigs) const {
    const Kdop18& volume = volumes[t];
    if (is_empty(volume)) return;
    const float inverse_size = grid->inverse_cell_size;
    if (!within_reach(volume, inverse_size)) {
      list_big(t, bigs);
      return;
    }
    const IntegerDop cells = integer_dop(volume, inverse_size);
    const TriangleShape shape = shapes[t];
    const float limit = larger(grid->cell_size - shape.growth, 0.5F * grid->cell_size);
    const bool is_large = subdivision && shape.radius > kLeastSplit * limit;
    const int level = is_large ? subdivision_level(shape.radius, limit) : 0;
    if (level > kMaxLevel || cells.span() > kMaxSpan) {
      list_big(t, bigs);
    } else if (level > 0) {
      splits.push(SplitRoot{t, static_cast<std::uint16_t>(level), 0});
    } else {
      const Ownership ownership = scene.ownership[t];
      const std::uint32_t body = scene.triangle_body[t];
      const bool fits = cells.span() <= 2;
      const bool fast = (shape.flags & kFastTriangle) != 0U;
      auto room = entries.allocate(cell_count(cells));
      for_each_cell(cells, [&](Cell cell, CellInterval row, const CellInterval(&below)[4]) {
        const std::uint32_t mask = lower_neighbour_mask(cell.x, row, below);
        room.put(KeyedEntry{entry_key(cell_index(cell), missing_face_neighbours(mask)),
                            {t, entry_bits(ExactControl::pack(mask, false, fits), body, ownership, fast)}});
      });
    }
  }

 private:
  template <class Bigs>
  SOFTCD_HD void list_big(std::uint32_t t, Bigs& bigs) const {
    shapes[t].flags |= kBigTriangle;
    bigs.push(t);
  }
};

/// How many children stand for each split triangle.
struct CountChildren {
  const SplitRoot* splits;
  std::uint32_t* child_counts;

  SOFTCD_HD void operator()(std::uint32_t split) const { child_counts[split] = splits[split].child_count(); }
};

/// `exact`: the cells of one child of a split triangle.
struct RegisterChild {
  SceneView scene;
  const TriangleShape* shapes;
  const SplitRoot* splits;
  const GridParameters* grid;

  template <class Cells>
  SOFTCD_HD void operator()(std::uint32_t split, std::uint32_t child, Cells& cells) const {
    const SplitRoot root = splits[split];
    const TriangleMotion motion = load_triangle(scene, root.root);
    const Kdop18 volume = child_volume(motion, root.level, child, shapes[root.root].growth);
    for_each_cell(integer_dop(volume, grid->inverse_cell_size),
                  [&](Cell cell, CellInterval /*row*/, const CellInterval(&/*below*/)[4]) {
                    cells.push(SplitCell{split_key(root.root, cell_index(cell)), child});
                  });
  }
};

/// First position in sorted `keys` whose key is not less than `key`.
template <class Key>
SOFTCD_HD std::uint64_t lower_bound_index(const Key* keys, std::uint64_t begin, std::uint64_t end, Key key) {
  while (begin < end) {
    const std::uint64_t middle = begin + (end - begin) / 2;
    if (keys[middle] < key) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}

/// `exact`: turns the sorted cells of split triangles into entries, one per (cell, root), with masks found by search. A
/// triangle that is split is far too large for 2 x 2 x 2 cells.
struct RegisterSplitCell {
  SceneView scene;
  const TriangleShape* shapes;
  const std::uint64_t* keys;
  Count key_count;

  template <class Entries>
  SOFTCD_HD void operator()(std::uint32_t i, Entries& entries) const {
    const std::uint64_t key = keys[i];
    if (i > 0 && keys[i - 1] == key) return;
    const std::uint32_t root = split_key_root(key);
    const std::uint32_t index = split_key_cell(key);
    const Cell cell = {static_cast<int>(index & kCellMask), static_cast<int>((index >> kCellBits) & kCellMask),
                       static_cast<int>(index >> (2 * kCellBits))};
    const std::uint64_t count = key_count.get();
    std::uint32_t mask = 0;
    for (std::uint32_t bit = 0; bit < kMaskBits; ++bit) {
      const std::uint64_t wanted = split_key(root, cell_index(lower_neighbour(cell, static_cast<int>(bit))));
      const std::uint64_t found = lower_bound_index(keys, 0, count, wanted);
      if (found < count && keys[found] == wanted) mask |= 1U << bit;
    }
    const bool fast = (shapes[root].flags & kFastTriangle) != 0U;
    entries.push(KeyedEntry{entry_key(index, missing_face_neighbours(mask)),
                            {root, entry_bits(ExactControl::pack(mask, true, false), scene.triangle_body[root],
                                              scene.ownership[root], fast)}});
  }
};

}  // namespace softcd
