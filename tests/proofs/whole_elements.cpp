#include "cell_sets.hpp"
#include "enumeration.hpp"
#include "lower_neighbour.hpp"
#include "softcd/grid/control_bits.hpp"

/// Whole triangles and patches, whose cells are an integer DOP.
namespace softcd::test {
namespace {

constexpr int kFarthest = kMaxSpan - 1;  ///< of two cells of an element, along an axis

/// Calls visit for every cell with coordinates from lo to hi.
template <class Visit>
void for_each_in_cube(int lo, int hi, Visit visit) {
  for (int z = lo; z <= hi; ++z) {
    for (int y = lo; y <= hi; ++y) {
      for (int x = lo; x <= hi; ++x) visit(Cell{x, y, z});
    }
  }
}

IntegerDop everywhere() {
  IntegerDop dop{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    dop.lo[axis] = -100;
    dop.hi[axis] = 100;
  }
  return dop;
}

// Statement 4. A row holds the cells whose nine forms are within the intervals, and a column all rows with such cells:
// for each two of the 18 bounds, whatever the two are, while the others do not matter.
TEST(IntegerDops, have_the_cells_within_nine_intervals) {
  constexpr int kBounds = 2 * kKdopAxes;
  Enumeration bounds(std::uint64_t{kBounds * (kBounds - 1) / 2} * 7 * 7 * 125);
  for (int first = 0; first < kBounds; ++first) {
    for (int second = first + 1; second < kBounds; ++second) {
      for_each_in_cube(-3, 3, [&](Cell values) {
        if (values.z != 0) return;
        IntegerDop dop = everywhere();
        (first % 2 == 0 ? dop.lo : dop.hi)[first / 2] = values.x;
        (second % 2 == 0 ? dop.lo : dop.hi)[second / 2] = values.y;
        for_each_in_cube(-2, 2, [&](Cell cell) {
          const bool is_in = is_member(dop, cell);
          ASSERT_EQ(dop.contains(cell), is_in) << first << ' ' << second << ' ' << values.x << ' ' << values.y;
          if (is_in) {
            ASSERT_TRUE(dop.column(cell.z).contains(cell.y)) << first << ' ' << second;
          }
          bounds.next();
        });
      });
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

// Statement 5. The mask of a cell in a row is that of the element's lower neighbours, however the four rows before it
// lie: each begins and ends at most two cells away, or is empty.
TEST(CellRow, has_the_mask_of_each_cell) {
  std::vector<CellInterval> intervals = {{0, -1}};
  for (int lo = -2; lo <= 2; ++lo) {
    for (int hi = lo; hi <= 2; ++hi) intervals.push_back({lo, hi});
  }
  const std::size_t n = intervals.size();
  Enumeration rows(n * n * n * n * n);
  CellRow row(everywhere(), 0, 0);
  for (std::size_t i = 0; i < n * n * n * n * n; ++i) {
    row.cells = intervals[i % n];
    for (std::size_t r = 0, rest = i / n; r < 4; ++r, rest /= n) row.below[r] = intervals[rest % n];
    const std::uint32_t mask = row.mask(0);
    for (int bit = 0; bit < static_cast<int>(kMaskBits); ++bit) {
      const Cell lower = lower_neighbour({0, 0, 0}, bit);
      const CellInterval& its = lower.z == -1 ? row.below[lower.y + 1] : (lower.y == -1 ? row.below[3] : row.cells);
      ASSERT_EQ((mask >> bit) & 1U, its.contains(lower.x) ? 1U : 0U) << i << ", bit " << bit;
    }
    rows.next();
  }
}

// Statement 6, once: of two cells of an element, the higher one has a lower neighbour in every integer DOP that
// contains both. So it has a common one in two elements that both contain the two cells. That holds for all two cells
// that an element of at most kMaxSpan cells has.
TEST(WholeElements, have_a_lower_neighbour_on_the_way_to_a_lower_common_cell) {
  constexpr std::uint64_t kSide = 2 * kFarthest + 1;
  Enumeration differences((kSide * kSide * kSide - 1) / 2);
  for_each_in_cube(-kFarthest, kFarthest, [&](Cell higher) {
    if (!is_lower({0, 0, 0}, higher)) return;
    const IntegerDop hull = hull_of({0, 0, 0}, higher);
    ASSERT_NE(CellRow(hull, higher.y, higher.z).mask(higher.x), 0U) << higher.x << ' ' << higher.y << ' ' << higher.z;
    differences.next();
  });
}

/// Returns all sets of a box's cells that are integer DOPs, without the empty one.
std::vector<std::pair<std::uint32_t, IntegerDop>> dops_in(const CellBox& box) {
  std::vector<std::pair<std::uint32_t, IntegerDop>> dops;
  for (std::uint32_t set = 1; set < box.set_count(); ++set) {
    const Cell first = box.cell(static_cast<std::uint32_t>(lowest_bit(set)));
    IntegerDop hull = hull_of(first, first);
    for (std::uint32_t i = 0; i < box.count(); ++i) {
      if (((set >> i) & 1U) == 0U) continue;
      for (int axis = 0; axis < kKdopAxes; ++axis) {
        hull.lo[axis] = std::min(hull.lo[axis], form_of(box.cell(i), axis));
        hull.hi[axis] = std::max(hull.hi[axis], form_of(box.cell(i), axis));
      }
    }
    std::uint32_t cells = 0;
    for (std::uint32_t i = 0; i < box.count(); ++i) cells |= is_member(hull, box.cell(i)) ? 1U << i : 0U;
    if (cells == set) dops.emplace_back(set, hull);
  }
  return dops;
}

// Statements 4 to 6 together: two whole elements that share cells are tested once and are not flagged, for all
// integer DOPs in a box of cells, as the stages register them.
TEST(WholeElements, that_share_cells_are_tested_exactly_once) {
  constexpr std::uint64_t kDops = 2809;
  Enumeration pairs(3 * kDops * kDops);
  for (const CellBox box : {CellBox{3, 3, 2}, CellBox{3, 2, 3}, CellBox{2, 3, 3}}) {
    CellScene scene;
    std::vector<ControlledCells> elements;
    for (const auto& [set, dop] : dops_in(box)) {
      elements.emplace_back(box, scene.register_whole(0, dop, {}));
      ASSERT_EQ(elements.back().set, set) << "the stages register other cells";
    }
    for (const ControlledCells& a : elements) {
      for (const ControlledCells& b : elements) {
        const Judgements judgements = judge(a, b);
        ASSERT_EQ(judgements.executed, (a.set & b.set) != 0U ? 1 : 0) << a.set << ' ' << b.set;
        ASSERT_EQ(judgements.flagged, 0) << a.set << ' ' << b.set;
        pairs.next();
      }
    }
  }
}

// Statement 7. The cell that a point falls into is among those of a volume that contains the point: for all points
// whose coordinates are multiples of an eighth of a cell. Roundings are not the matter here.
TEST(IntegerDops, have_the_cell_of_every_point_of_their_volume) {
  constexpr int kSteps = 16;
  constexpr std::uint64_t kSide = 2 * kSteps + 1;
  Enumeration points(kSide * kSide * kSide);
  for_each_in_cube(-kSteps, kSteps, [&](Cell step) {
    const Vec3f point = {0.125F * static_cast<float>(step.x), 0.125F * static_cast<float>(step.y),
                         0.125F * static_cast<float>(step.z)};
    Kdop18 volume = empty_kdop();
    extend(volume, point);
    const Cell cell = cell_of(point, 1.0F);
    ASSERT_TRUE(is_member(integer_dop(volume, 1.0F), cell)) << step.x << ' ' << step.y << ' ' << step.z;
    ASSERT_TRUE(is_member(generic::integer_dop(volume, 1.0F), cell)) << step.x << ' ' << step.y << ' ' << step.z;
    points.next();
  });
}

}  // namespace
}  // namespace softcd::test
