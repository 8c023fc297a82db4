#include "cell_sets.hpp"
#include "enumeration.hpp"
#include "lower_neighbour.hpp"
#include "softcd/grid/control_bits.hpp"
#include "softcd/stages/virtual_subdivision.hpp"

/// Split triangles, whose cells are any set: those of their children.
namespace softcd::test {
namespace {

constexpr CellBox kBoxesOfTwelve[] = {{3, 2, 2}, {2, 3, 2}, {2, 2, 3}};

/// Returns all sets of cells of a box, each as a split triangle with these cells registers them.
std::vector<ControlledCells> split_triangles_in(const CellBox& box) {
  CellScene scene;
  MarkedCells marked(0, box.corner, box.width, box.height, box.depth);
  std::vector<ControlledCells> triangles;
  for (std::uint32_t set = 0; set < box.set_count(); ++set) {
    marked.mark_set(box, set);
    triangles.emplace_back(box, marked.register_all(scene, {}));
  }
  return triangles;
}

// Statement 8. Two split triangles that share cells are tested at least once, and each time flagged: for all sets of
// cells of both, in boxes of 12 cells.
TEST(SplitTriangles, that_share_cells_are_tested_and_flagged) {
  Enumeration pairs(std::uint64_t{3} * 4096 * 4096);
  for (const CellBox& box : kBoxesOfTwelve) {
    const std::vector<ControlledCells> triangles = split_triangles_in(box);
    for (std::uint32_t a = 0; a < box.set_count(); ++a) {
      ASSERT_EQ(triangles[a].set, a);
      for (std::uint32_t b = 0; b < box.set_count(); ++b) {
        const Judgements judgements = judge(triangles[a], triangles[b]);
        ASSERT_EQ(judgements.executed > 0, (a & b) != 0U) << a << ' ' << b;
        ASSERT_EQ(judgements.flagged, judgements.executed) << a << ' ' << b;
      }
      pairs.add(box.set_count());
    }
  }
}

// Statement 9. A split triangle and an element that fits into 2 x 2 x 2 cells are tested exactly once and not flagged:
// for all sets of cells of both. Cells of the split triangle next to the element's are in the larger box.
TEST(SplitTriangles, are_tested_once_with_elements_that_fit_into_2_x_2_x_2_cells) {
  Enumeration pairs(std::uint64_t{3} * 2 * 256 * 4096);
  for (const CellBox& box : kBoxesOfTwelve) {
    const std::vector<ControlledCells> triangles = split_triangles_in(box);
    for (int at = 0; at < 2; ++at) {
      const Cell corner = {box.width == 3 ? at : 0, box.height == 3 ? at : 0, box.depth == 3 ? at : 0};
      const CellBox eight = {2, 2, 2, corner};
      for (std::uint32_t set = 0; set < eight.set_count(); ++set) {
        std::uint32_t in_box = 0;
        for (std::uint32_t i = 0; i < eight.count(); ++i) in_box |= (set >> i & 1U) != 0U ? box.bit(eight.cell(i)) : 0U;
        ControlledCells small = triangles[in_box];
        for (std::uint32_t& bits : small.bits) {
          bits = ExactControl::pack(bits & ((1U << kMaskBits) - 1U), false, true);
        }
        for (const ControlledCells& triangle : triangles) {
          const Judgements judgements = judge(small, triangle);
          ASSERT_EQ(judgements.executed, (in_box & triangle.set) != 0U ? 1 : 0) << set << ' ' << triangle.set;
          ASSERT_EQ(judgements.flagged, 0);
          pairs.next();
        }
      }
    }
  }
}

// Whole elements say that they fit where they do, and split triangles never do: for elements of all sizes up to four
// cells, and for all diagonal bounds that leave these.
TEST(Entries, say_that_they_fit_into_2_x_2_x_2_cells_only_if_they_do) {
  Enumeration sizes(4 * 4 * 4);
  CellScene scene;
  for (int i = 0; i < 64; ++i) {
    const Cell far = {i % 4, i / 4 % 4, i / 16};
    IntegerDop box{};
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      box.lo[axis] = -10;
      box.hi[axis] = 10;
    }
    const int ends[3] = {far.x, far.y, far.z};
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = 0;
      box.hi[axis] = ends[axis];
    }
    const std::vector<KeyedEntry> entries = scene.register_whole(0, box, {});
    ASSERT_EQ(entries.size(), static_cast<std::size_t>((far.x + 1) * (far.y + 1) * (far.z + 1)));
    for (const KeyedEntry& entry : entries) {
      ASSERT_EQ((entry.entry.bits >> 14) & 1U, far.x < 2 && far.y < 2 && far.z < 2 ? 1U : 0U) << i;
      ASSERT_EQ((entry.entry.bits >> 13) & 1U, 0U);
    }
    sizes.next();
  }
}

/// Marks the cells around `cell` by bits, those of its mask and then itself. Returns false if one is outside.
bool mark_around(MarkedCells& marked, Cell cell, std::uint32_t around) {
  const SplitBox& box = marked.box();
  for (int bit = 0; bit < static_cast<int>(kMaskBits); ++bit) {
    if (((around >> bit) & 1U) == 0U) continue;
    const Cell c = lower_neighbour(cell, bit);
    if (c.x < 0 || c.x >= box.width || c.y < 0 || c.y >= box.height || c.z < 0 || c.z >= box.depth) return false;
    marked.mark(c);
  }
  return true;
}

// Statement 10. The mask of a marked cell has its lower neighbours that are marked, for all sets of these. The widths
// are those at which words of 32 bits begin and end. Each place along x is tried, in the first and later rows and
// layers.
TEST(MarkedCells, have_the_masks_of_their_lower_neighbours) {
  CellScene scene;
  std::uint64_t count = 0;
  for (const int width : {1, 2, 3, 31, 32, 33, 34, 63, 64, 65, 66, 96, 97, 127, 128}) {
    for (const auto& [height, y] : {std::pair(1, 0), std::pair(2, 0), std::pair(2, 1), std::pair(3, 1)}) {
      for (const int depth : {1, 2}) {
        MarkedCells marked(0, {0, 0, 0}, width, height, depth);
        for (int x = 0; x < width; ++x) {
          const Cell cell = {x, y, depth - 1};
          const std::uint32_t word =
              static_cast<std::uint32_t>(((depth - 1) * height + y)) * marked.box().words_per_row() +
              static_cast<std::uint32_t>(x) / 32U;
          for (std::uint32_t around = 0; around < (1U << kMaskBits); ++around) {
            marked.clear();
            if (!mark_around(marked, cell, around)) continue;
            marked.mark(cell);
            EntrySink sink;
            RegisterMarkedCells{scene.view(), scene.shapes().data(), &marked.split(), marked.bits(), {}}(0, word, sink);
            const KeyedEntry& entry = sink.items.back();
            ASSERT_EQ(key_cell(entry.key), cell_index(cell));
            ASSERT_EQ(entry.entry.bits & ((1U << kMaskBits) - 1U), around) << width << ' ' << x << ' ' << y;
            ASSERT_EQ((entry.entry.bits >> kMaskBits) & 3U, 1U) << "it is split and does not fit";
            ASSERT_EQ(7U - key_rank(entry.key), missing_face_neighbours(around));
            ++count;
          }
        }
      }
    }
  }
  Enumeration places(7653684);
  places.add(count);
}

// Statement 11. A child marks the cells of its volume that are in the triangle's box: for each run of cells along x in
// a box of the greatest width.
TEST(MarkChild, marks_each_run_of_cells) {
  Enumeration runs(kMaxSpan * (kMaxSpan + 1) / 2);
  CellScene scene;
  const Triangle corners = {{0, 1, 1}};
  Vec3f x[2] = {};
  scene.view().triangles = &corners;
  scene.view().x_t1 = x;
  MarkedCells marked(0, {0, 0, 0}, kMaxSpan, 2, 2);
  const SplitRoot split = {0, 0};
  for (int first = 0; first < kMaxSpan; ++first) {
    for (int last = first; last < kMaxSpan; ++last) {
      x[0] = {static_cast<float>(first) + 0.5F, 0.5F, 0.5F};
      x[1] = {static_cast<float>(last) + 0.5F, 0.5F, 0.5F};
      marked.clear();
      MarkChild{scene.view(), scene.shapes().data(), &split, &scene.grid(), marked.bits()}(0, 0);
      const IntegerDop cells = integer_dop(child_volume(load_triangle(scene.view(), 0), 0, 0, 0.0F), 1.0F);
      for (int i = 0; i < 4 * kMaxSpan; ++i) {
        const Cell cell = {i % kMaxSpan, i / kMaxSpan % 2, i / kMaxSpan / 2};
        ASSERT_EQ(marked.has(cell), is_member(cells, cell)) << first << " to " << last << ": " << cell.x;
      }
      runs.next();
    }
  }
}

// Statement 12. Children cover their triangle, each part once: in steps of 2^-level along two sides, they are the small
// triangles between neighbouring lattice points, upright and inverted.
TEST(Children, cover_their_triangle) {
  std::uint64_t expected = 0;
  for (int level = 0; level <= kMaxLevel; ++level) expected += std::uint64_t{1} << (2 * level);
  Enumeration children(expected);
  for (int level = 0; level <= kMaxLevel; ++level) {
    const int rows = 1 << level;
    std::vector<int> upright(std::size_t{1} << (2 * level), 0);
    std::vector<int> inverted = upright;
    for (std::uint32_t child = 0; child < (SplitRoot{0, static_cast<std::uint32_t>(level)}).child_count(); ++child) {
      const ChildWeights weights = child_weights(level, child);
      int row[3], along[3];
      for (int corner = 0; corner < 3; ++corner) {
        const float scaled[2] = {weights.row[corner] * static_cast<float>(rows),
                                 weights.along[corner] * static_cast<float>(rows)};
        row[corner] = static_cast<int>(scaled[0]);
        along[corner] = static_cast<int>(scaled[1]);
        ASSERT_TRUE(static_cast<float>(row[corner]) == scaled[0] && static_cast<float>(along[corner]) == scaled[1]);
        ASSERT_TRUE(0 <= along[corner] && along[corner] <= row[corner] && row[corner] <= rows) << level << ' ' << child;
      }
      // Corners in order, upright: (r, a), (r + 1, a), (r + 1, a + 1); inverted: (r, a), (r, a + 1), (r + 1, a + 1).
      const bool is_upright = row[1] == row[0] + 1 && along[1] == along[0];
      const bool is_inverted = row[1] == row[0] && along[1] == along[0] + 1;
      ASSERT_TRUE(is_upright || is_inverted) << level << ' ' << child;
      ASSERT_TRUE(row[2] == row[0] + 1 && along[2] == along[0] + 1) << level << ' ' << child;
      const std::size_t place = (static_cast<std::size_t>(row[0]) << level) + static_cast<std::size_t>(along[0]);
      ASSERT_LT(place, upright.size());
      ASSERT_EQ(++(is_upright ? upright : inverted)[place], 1) << level << ' ' << child << " is there twice";
      children.next();
    }
  }
}

}  // namespace
}  // namespace softcd::test
