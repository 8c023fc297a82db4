#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "softcd/grid/uniform_grid.hpp"
#include "softcd/stages/bounding_volumes.hpp"
#include "softcd/stages/cell_assignment.hpp"
#include "softcd/stages/split_cells.hpp"

namespace softcd::test {

/// The order of cells in which neighbours are "lower".
constexpr bool is_lower(Cell a, Cell b) {
  return a.z != b.z ? a.z < b.z : (a.y != b.y ? a.y < b.y : a.x < b.x);
}

/// The value of one of the nine forms of an integer DOP, written here once more.
constexpr int form_of(Cell c, int axis) {
  const int forms[kKdopAxes] = {c.x, c.y, c.z, c.x + c.y, c.x + c.z, c.y + c.z, c.x - c.y, c.x - c.z, c.y - c.z};
  return forms[axis];
}

/// Returns the smallest integer DOP that contains both cells.
inline IntegerDop hull_of(Cell a, Cell b) {
  IntegerDop hull{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    hull.lo[axis] = std::min(form_of(a, axis), form_of(b, axis));
    hull.hi[axis] = std::max(form_of(a, axis), form_of(b, axis));
  }
  return hull;
}

inline bool is_member(const IntegerDop& dop, Cell c) {
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    if (form_of(c, axis) < dop.lo[axis] || form_of(c, axis) > dop.hi[axis]) return false;
  }
  return true;
}

/// Returns a volume that integer_dop() turns into these cells, for cells of size 1.
inline Kdop18 volume_of(const IntegerDop& cells) {
  Kdop18 volume{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    volume.lo[axis] = static_cast<float>(cells.lo[axis] + (axis >= 3 && axis < 6 ? 1 : 0)) + 0.5F;
    volume.hi[axis] = static_cast<float>(cells.hi[axis] - (axis >= 6 ? 1 : 0)) + 0.5F;
  }
  return volume;
}

/// A small box of cells, in the order of the rule. A set of its cells is a word with bit i for cell i.
struct CellBox {
  int width, height, depth;
  Cell corner{0, 0, 0};

  constexpr std::uint32_t count() const { return static_cast<std::uint32_t>(width * height * depth); }
  constexpr std::uint32_t set_count() const { return 1U << count(); }
  constexpr Cell cell(std::uint32_t i) const {
    const int n = static_cast<int>(i);
    return {corner.x + n % width, corner.y + n / width % height, corner.z + n / width / height};
  }
  /// Returns the cell's bit, 0 for a cell outside.
  constexpr std::uint32_t bit(Cell c) const {
    const int x = c.x - corner.x, y = c.y - corner.y, z = c.z - corner.z;
    if (x < 0 || x >= width || y < 0 || y >= height || z < 0 || z >= depth) return 0;
    return 1U << ((z * height + y) * width + x);
  }
};

/// The entries that a stage appends. A stage appends as many as it announces.
class EntrySink {
 public:
  class Room {
   public:
    Room(std::vector<KeyedEntry>& items, std::uint32_t count) : items_(items), left_(count) {}
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;
    ~Room() { EXPECT_EQ(left_, 0U) << "not as many entries as announced"; }

    void put(const KeyedEntry& entry) {
      --left_;
      items_.push_back(entry);
    }

   private:
    std::vector<KeyedEntry>& items_;
    std::uint32_t left_;
  };
  std::vector<KeyedEntry> items;

  Room allocate(std::uint32_t count) { return Room(items, count); }
};

/// A scene of one body without positions, and a grid of cells of size 1, for stages that read nothing else.
class CellScene {
 public:
  explicit CellScene(std::uint32_t element_count = 4, std::uint32_t offset = 0)
      : bodies_(element_count, 0), volumes_(element_count), shapes_(element_count) {
    body_.cell_offset = offset;
    view_.triangle_body = bodies_.data();
    view_.bodies = &body_;
    view_.triangle_count = element_count;
    view_.body_count = 1;
    view_.self_collision = true;
    view_.has_batches = offset != 0;
    view_.class_may_touch[0] = 1;
    grid_.active_triangles = grid_.active_elements = 1U << 30;
    grid_.cell_size = grid_.inverse_cell_size = 1.0F;
  }

  const SceneView& view() const { return view_; }
  SceneView& view() { return view_; }
  const GridParameters& grid() const { return grid_; }
  std::vector<Kdop18>& volumes() { return volumes_; }
  std::vector<TriangleShape>& shapes() { return shapes_; }

  /// Registers the cells of an element as a whole, by the product's stages.
  std::vector<KeyedEntry> register_whole(std::uint32_t element, const IntegerDop& cells, const Partition& partition) {
    volumes_[element] = volume_of(cells);
    const CellRegistrar registrar{view_, volumes_.data(), shapes_.data(), &grid_, partition};
    const Registration work = registrar.whole(element, volumes_[element], shapes_[element]);
    EntrySink sink;
    for (std::uint32_t part = 0; part < work.part_count(); ++part) registrar.register_row(work, part, sink);
    return std::move(sink.items);
  }

 private:
  SceneBody body_{};
  SceneView view_;
  GridParameters grid_{};
  std::vector<std::uint32_t> bodies_;
  std::vector<Kdop18> volumes_;
  std::vector<TriangleShape> shapes_;
};

/// The marked cells of a split triangle, which the product's stage turns into entries.
class MarkedCells {
 public:
  MarkedCells(std::uint32_t element, Cell corner, int width, int height, int depth)
      : split_{element, 1}, box_{corner.x, corner.y, corner.z, width, height, depth}, words_(box_.words()) {}

  void clear() { std::fill(words_.begin(), words_.end(), 0U); }
  void mark(Cell c) { word_of(c) |= 1U << ((c.x - box_.x) % 32); }
  bool has(Cell c) { return ((word_of(c) >> ((c.x - box_.x) % 32)) & 1U) != 0U; }
  void mark_set(const CellBox& box, std::uint32_t set) {
    clear();
    for (std::uint32_t i = 0; i < box.count(); ++i) {
      if (((set >> i) & 1U) != 0U) mark(box.cell(i));
    }
  }

  const SplitBox& box() const { return box_; }
  const SplitRoot& split() const { return split_; }
  SplitBits bits() { return {&box_, &offset_, words_.data(), words_.size()}; }

  /// Registers the words from `first` on, in this box as one split triangle.
  std::vector<KeyedEntry> register_all(CellScene& scene, const Partition& partition) {
    EntrySink sink;
    const RegisterMarkedCells stage{scene.view(), scene.shapes().data(), &split_, bits(), partition};
    for (std::uint32_t word = 0; word < box_.words(); ++word) stage(0, word, sink);
    return std::move(sink.items);
  }

 private:
  std::uint32_t& word_of(Cell c) {
    const auto row = static_cast<std::uint32_t>((c.z - box_.z) * box_.height + (c.y - box_.y));
    return words_[row * box_.words_per_row() + static_cast<std::uint32_t>(c.x - box_.x) / 32U];
  }

  SplitRoot split_;
  SplitBox box_;
  std::uint64_t offset_ = 0;
  std::vector<std::uint32_t> words_;
};

/// The control bits of an element in the cells of a small box, by cell.
struct ControlledCells {
  std::uint32_t set = 0;
  std::uint32_t bits[32] = {};

  /// `offset` is the body's cell offset.
  ControlledCells(const CellBox& box, const std::vector<KeyedEntry>& entries, std::uint32_t offset = 0) {
    for (std::uint32_t i = 0; i < box.count(); ++i) {
      const std::uint32_t number = moved_cell(cell_index(box.cell(i)), offset);
      for (const KeyedEntry& entry : entries) {
        if (key_cell(entry.key) != number) continue;
        set |= 1U << i;
        bits[i] = entry.entry.bits;
      }
    }
  }
};

/// The judgements about two elements in their common cells.
struct Judgements {
  int executed = 0;
  int flagged = 0;
};

inline Judgements judge(const ControlledCells& a, const ControlledCells& b) {
  Judgements judgements;
  for (std::uint32_t common = a.set & b.set; common != 0U; common &= common - 1U) {
    const int i = lowest_bit(common);
    const Verdict verdict = ExactControl::judge(0, {0, a.bits[i]}, {1, b.bits[i]});
    judgements.executed += verdict != Verdict::skip ? 1 : 0;
    judgements.flagged += verdict == Verdict::execute_and_flag ? 1 : 0;
  }
  return judgements;
}

}  // namespace softcd::test
