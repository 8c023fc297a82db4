#pragma once

#include <cstdint>

#include "softcd/core/bits.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/clear_word.hpp"

/// The cells of split triangles. Each cell around such a triangle is a bit, which its children set. Each set bit
/// becomes an entry, whose mask (control_bits.hpp) is read off the rows around.
namespace softcd {

/// Cells x to x + width - 1 and so on. Their bits lie along x in words, low bits first, row after row along y, layer
/// after layer along z.
struct SplitBox {
  int x, y, z;
  int width, height, depth;  ///< at most kMaxSpan

  SOFTCD_HD constexpr std::uint32_t words_per_row() const { return (static_cast<std::uint32_t>(width) + 31U) / 32U; }
  SOFTCD_HD constexpr std::uint32_t words() const {
    return words_per_row() * static_cast<std::uint32_t>(height) * static_cast<std::uint32_t>(depth);
  }
};

/// The bits of all split triangles, each one's at its offset. Bits that do not fit are not there: the detection is
/// repeated.
struct SplitBits {
  const SplitBox* boxes;
  const std::uint64_t* offsets;
  std::uint32_t* words;
  std::uint64_t capacity;

  SOFTCD_HD bool has(std::uint32_t split) const { return offsets[split] + boxes[split].words() <= capacity; }
  SOFTCD_HD std::uint32_t* of(std::uint32_t split) const { return words + offsets[split]; }
};

struct BoundSplit {
  const Kdop18* volumes;
  const SplitRoot* splits;
  const GridParameters* grid;
  SplitBox* boxes;
  std::uint32_t* word_counts;

  SOFTCD_HD void operator()(std::uint32_t split) const {
    const IntegerDop cells = integer_dop(volumes[splits[split].root], grid->inverse_cell_size);
    boxes[split] = {cells.lo[0],
                    cells.lo[1],
                    cells.lo[2],
                    cells.hi[0] - cells.lo[0] + 1,
                    cells.hi[1] - cells.lo[1] + 1,
                    cells.hi[2] - cells.lo[2] + 1};
    word_counts[split] = boxes[split].words();
  }
};

/// Sets bits. Children overlap, so that most bits are set already.
SOFTCD_HD inline void mark_bits(std::uint32_t* word, std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  if ((*word & bits) != bits) atomicOr(word, bits);
#else
  if ((__atomic_load_n(word, __ATOMIC_RELAXED) & bits) != bits) __atomic_fetch_or(word, bits, __ATOMIC_RELAXED);
#endif
}

/// Marks the cells of one child. Skips cells outside the triangle's own box, which come from roundings: no point of the
/// triangle lies there.
struct MarkChild {
  SceneView scene;
  const TriangleShape* shapes;
  const SplitRoot* splits;
  const GridParameters* grid;
  SplitBits bits;

  SOFTCD_HD void operator()(std::uint32_t split, std::uint32_t child) const {
    if (!bits.has(split)) return;
    const SplitRoot root = splits[split];
    const SplitBox box = bits.boxes[split];
    const TriangleMotion motion = load_triangle(scene, root.root);
    const Kdop18 volume = child_volume(motion, static_cast<int>(root.level), child, shapes[root.root].growth);
    const IntegerDop cells = integer_dop(volume, grid->inverse_cell_size);
    for (int z = larger(cells.lo[2], box.z); z <= smaller(cells.hi[2], box.z + box.depth - 1); ++z) {
      const CellInterval column = cells.column(z);
      for (int y = larger(column.lo, box.y); y <= smaller(column.hi, box.y + box.height - 1); ++y) {
        const CellInterval row = cells.row(y, z);
        const auto index = static_cast<std::uint32_t>((z - box.z) * box.height + (y - box.y));
        mark_row(bits.of(split) + index * box.words_per_row(), larger(row.lo - box.x, 0),
                 smaller(row.hi - box.x, box.width - 1));
      }
    }
  }

 private:
  static SOFTCD_HD void mark_row(std::uint32_t* row, int first, int last) {
    for (int begin = first; begin <= last;) {
      const int end = smaller(begin | 31, last);
      const std::uint32_t run = 0xFFFFFFFFU >> (31 - (end - begin));
      mark_bits(row + begin / 32, run << (begin & 31));
      begin = end + 1;
    }
  }
};

/// Turns word k of a split triangle's bits into entries. A triangle that is split is far too large for 2 x 2 x 2 cells.
struct RegisterMarkedCells {
  SceneView scene;
  const TriangleShape* shapes;
  const SplitRoot* splits;
  SplitBits bits;
  Partition partition;

  template <class Entries>
  SOFTCD_HD void operator()(std::uint32_t split, std::uint32_t k, Entries& entries) const {
    if (!bits.has(split)) return;
    const std::uint32_t marked = bits.of(split)[k];
    if (marked == 0U) return;
    const SplitBox box = bits.boxes[split];
    const auto word = static_cast<int>(k % box.words_per_row());
    const auto row = static_cast<int>(k / box.words_per_row());
    const int y = row % box.height;
    const int z = row / box.height;
    const std::uint64_t rows[4] = {around(split, box, word, y - 1, z - 1), around(split, box, word, y, z - 1),
                                   around(split, box, word, y + 1, z - 1), around(split, box, word, y - 1, z)};
    const std::uint64_t own = around(split, box, word, y, z);

    const std::uint32_t root = splits[split].root;
    const std::uint32_t body = scene.triangle_body[root];
    const std::uint32_t features = wanted_features(shapes[root].flags);
    const std::uint32_t offset = scene.cell_offset(body);
    const std::uint32_t registered = own_bits(marked, {box.x + 32 * word, box.y + y, box.z + z}, offset);
    auto room = entries.allocate(count_bits(registered));
    for (int bit = 0; bit < 32; ++bit) {
      if (((registered >> bit) & 1U) == 0U) continue;
      std::uint32_t mask = static_cast<std::uint32_t>((own >> bit) & 1U) << 12;
      for (int r = 0; r < 4; ++r) mask |= static_cast<std::uint32_t>((rows[r] >> bit) & 7U) << (3 * r);
      const std::uint32_t rank = entry_rank(scene, body, missing_face_neighbours(mask));
      const Cell cell = {box.x + 32 * word + bit, box.y + y, box.z + z};
      room.put(KeyedEntry{entry_key(moved_cell(cell_index(cell), offset), rank),
                          {root, entry_bits(ExactControl::pack(mask, true, false), body, features)}});
    }
  }

 private:
  /// Returns the bits of a row of cells from `first` on that are the rank's.
  SOFTCD_HD std::uint32_t own_bits(std::uint32_t marked, Cell first, std::uint32_t offset) const {
    if (partition.is_whole()) return marked;
    for (int bit = 0; bit < 32; ++bit) {
      const std::uint32_t cell = cell_index({first.x + bit, first.y, first.z});
      if (!partition.has(moved_cell(cell, offset))) marked &= ~(1U << bit);
    }
    return marked;
  }
  /// Returns bits 0 to 33: the cells from the one before the word to the one after it.
  SOFTCD_HD std::uint64_t around(std::uint32_t split, const SplitBox& box, int word, int y, int z) const {
    if (y < 0 || z < 0 || y >= box.height) return 0;
    const auto per_row = static_cast<int>(box.words_per_row());
    const std::uint32_t* row = bits.of(split) + static_cast<std::uint32_t>((z * box.height + y) * per_row);
    const std::uint64_t before = word > 0 ? row[word - 1] >> 31 : 0U;
    const std::uint64_t after = word + 1 < per_row ? row[word + 1] & 1U : 0U;
    return before | static_cast<std::uint64_t>(row[word]) << 1 | after << 33;
  }
};

}  // namespace softcd
