#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/grid/control_bits.hpp"
#include "softcd/grid/partition.hpp"
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

/// Entries as a structure of arrays, so that only keys and values of the sort move.
struct EntryTarget {
  using Value = KeyedEntry;
  std::uint32_t* keys;
  Entry* entries;
  SOFTCD_HD void store(std::uint64_t i, const KeyedEntry& value) const {
    keys[i] = value.key;
    entries[i] = value.entry;
  }
};

/// A triangle that children represent in the grid.
struct SplitRoot {
  std::uint32_t root;
  std::uint32_t level;  ///< number of 1-to-4 splits

  SOFTCD_HD constexpr std::uint32_t child_count() const { return 1U << (2 * level); }
};

/// Returns the rank of an entry in its cell. If some body collides with itself, it is 7 - K, so that K descends.
/// Otherwise it is the body modulo 8: entries of one body lie together, and are not tested with each other.
SOFTCD_HD inline std::uint32_t entry_rank(const SceneView& scene, std::uint32_t body, std::uint32_t k) {
  return scene.self_collision ? 7U - k : body & 7U;
}

/// Calls visit(cell) for every cell of an integer DOP.
template <class Visit>
SOFTCD_HD void for_each_cell(const IntegerDop& cells, Visit visit) {
  for (int z = cells.lo[2]; z <= cells.hi[2]; ++z) {
    const CellInterval column = cells.column(z);
    for (int y = column.lo; y <= column.hi; ++y) {
      const CellInterval row = cells.row(y, z);
      for (int x = row.lo; x <= row.hi; ++x) visit(Cell{x, y, z});
    }
  }
}

/// The placement of a triangle or a patch. The triangles of a `loose` patch are registered one by one.
enum class Placement : std::uint32_t { nowhere, whole, split, big, loose };

/// A triangle or a patch about to be registered.
struct Registration {
  Placement placement;
  std::uint32_t element;
  std::uint32_t body;
  std::uint32_t bits;   ///< whole: of its entries, with an empty mask
  std::uint32_t level;  ///< split: number of 1-to-4 splits
  std::uint32_t cell_offset;
  IntegerDop cells;  ///< whole

  /// A `whole` element is registered row by row (fixed y and z).
  SOFTCD_HD std::uint32_t part_count() const {
    if (placement != Placement::whole) return placement == Placement::nowhere ? 0U : 1U;
    return static_cast<std::uint32_t>((cells.hi[1] - cells.lo[1] + 1) * (cells.hi[2] - cells.lo[2] + 1));
  }
};

/// Registers triangles and patches in the cells of their volumes.
struct CellRegistrar {
  SceneView scene;
  const Kdop18* volumes;
  TriangleShape* shapes;
  const GridParameters* grid;
  Partition partition;

  /// Returns the registration of an element in all cells of its volume, or `big` if these are too many. The volume is
  /// not empty.
  SOFTCD_HD Registration whole(std::uint32_t element, const Kdop18& volume, const TriangleShape& shape) const {
    Registration work{};
    work.element = element;
    work.placement = Placement::big;
    if (!within_grid(volume, grid->inverse_cell_size)) return work;
    work.cells = integer_dop(volume, grid->inverse_cell_size);
    const int span = work.cells.span();
    if (span > kMaxSpan) return work;
    work.body = scene.element_body(element);
    work.cell_offset = scene.cell_offset(work.body);
    work.bits = entry_bits(ExactControl::pack(0, false, span <= 2), work.body, wanted_features(shape.flags));
    if (span > kFewCellsAcross && !pay_off(whole_cells(volume, shape))) return work;
    work.placement = partition.is_whole() || may_have(work) ? Placement::whole : Placement::nowhere;
    return work;
  }

  /// Returns the size of a cell less the element's margin, at least half a cell.
  SOFTCD_HD float size_limit(const TriangleShape& shape) const {
    return larger(grid->cell_size - shape.growth, 0.5F * grid->cell_size);
  }

  /// Whether so many cells cost less than tests against all other elements.
  SOFTCD_HD bool pay_off(float cells) const {
    return kTestsPerCell * cells < static_cast<float>(grid->active_elements);
  }

  template <class Entries>
  SOFTCD_HD void register_row(const Registration& work, std::uint32_t part, Entries& entries) const {
    const IntegerDop& cells = work.cells;
    const int rows_in_layer = cells.hi[1] - cells.lo[1] + 1;
    const int z = cells.lo[2] + static_cast<int>(part) / rows_in_layer;
    const int y = cells.lo[1] + static_cast<int>(part) % rows_in_layer;
    if (cells.row(y, z).empty()) return;
    const CellRow row(cells, y, z);
    auto room = entries.allocate(own_cells(work, row.cells, y, z));
    for (int x = row.cells.lo; x <= row.cells.hi; ++x) {
      const std::uint32_t cell = moved_cell(cell_index({x, y, z}), work.cell_offset);
      if (!partition.has(cell)) continue;
      const std::uint32_t mask = row.mask(x);
      const std::uint32_t rank = entry_rank(scene, work.body, missing_face_neighbours(mask));
      room.put(KeyedEntry{entry_key(cell, rank), {work.element, work.bits | ExactControl::pack(mask, false, false)}});
    }
  }

 private:
  SOFTCD_HD float whole_cells(const Kdop18& volume, const TriangleShape& shape) const {
    return estimated_cells(cell_extent(volume, shape.growth), grid->inverse_cell_size);
  }

  SOFTCD_HD bool may_have(const Registration& work) const {
    const auto& [lo, hi] = work.cells;
    return partition.may_have({lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}, work.cell_offset);
  }

  SOFTCD_HD std::uint32_t own_cells(const Registration& work, CellInterval row, int y, int z) const {
    if (partition.is_whole()) return static_cast<std::uint32_t>(row.hi - row.lo + 1);
    std::uint32_t count = 0;
    for (int x = row.lo; x <= row.hi; ++x) {
      count += partition.has(moved_cell(cell_index({x, y, z}), work.cell_offset)) ? 1U : 0U;
    }
    return count;
  }
};

/// Registers a triangle in the cells of its own volume if it is small enough. Otherwise puts it on the list of
/// triangles to split. If that takes too many cells, puts it on the list of those tested against all.
struct RegisterTriangle {
  using Item = Registration;

  CellRegistrar registrar;
  bool subdivision;
  const std::uint32_t* triangles = nullptr;  ///< those to be registered; null: all, by their indices

  SOFTCD_HD Registration load_item(std::uint32_t i) const {
    const std::uint32_t t = triangles == nullptr ? i : triangles[i];
    const Kdop18 volume = registrar.volumes[t];
    if (is_empty(volume)) return {};
    const TriangleShape shape = registrar.shapes[t];
    const int level = subdivision ? split_level(shape.radius, registrar.size_limit(shape)) : 0;
    Registration work = registrar.whole(t, volume, shape);
    if (level == 0) return work;
    const bool fits = within_grid(volume, registrar.grid->inverse_cell_size) && work.cells.span() <= kMaxSpan;
    const bool is_split = level <= kMaxLevel && fits && registrar.pay_off(split_cells(shape));
    work.placement = is_split ? Placement::split : Placement::big;
    work.level = static_cast<std::uint32_t>(level);
    return work;
  }

  template <class Entries, class Splits, class Bigs>
  SOFTCD_HD void operator()(const Registration& work, std::uint32_t part, Entries& entries, Splits& splits,
                            Bigs& bigs) const {
    if (work.placement == Placement::whole) {
      registrar.register_row(work, part, entries);
    } else if (work.placement == Placement::split) {
      splits.push(SplitRoot{work.element, work.level});
    } else {
      registrar.shapes[work.element].flags |= kBigTriangle;
      bigs.push(work.element);
    }
  }

 private:
  /// Estimates the number of cells of a split triangle. They are those of a disc of its size, half filled, as thick as
  /// its margin on both sides. It also meets cells in part.
  SOFTCD_HD float split_cells(const TriangleShape& shape) const {
    const float inverse_size = registrar.grid->inverse_cell_size;
    const float across = 2.0F * inverse_size * (shape.radius + shape.growth);
    return 0.5F * across * across * (2.0F * inverse_size * shape.growth + 2.0F);
  }
};

/// Counts the children of each split triangle.
template <class Split>
struct CountChildren {
  const Split* splits;
  std::uint32_t* child_counts;

  SOFTCD_HD void operator()(std::uint32_t split) const { child_counts[split] = splits[split].child_count(); }
};

/// Returns the first position in sorted `keys` whose key is not less than `key`.
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

}  // namespace softcd
