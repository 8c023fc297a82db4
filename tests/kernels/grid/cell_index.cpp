#include "softcd/grid/cell_index.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "random.hpp"
#include "softcd/grid/partition.hpp"

namespace softcd::test {
namespace {

Cell random_cell(Random& random, int extent) {
  const auto coordinate = [&] {
    return static_cast<int>(random.below(2U * static_cast<unsigned>(extent) + 1U)) - extent;
  };
  return {coordinate(), coordinate(), coordinate()};
}

Cell sum(Cell a, Cell b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

TEST(CellIndex, says_which_of_the_cells_around_another_it_is) {
  Random random(1);
  for (int i = 0; i < 200000; ++i) {
    const Cell cell = random_cell(random, 1 << 20);
    const Cell nearby = sum(cell, random_cell(random, kMaxSpan));
    const std::uint32_t index = cell_index(cell);
    ASSERT_LT(index, kCellCount);
    const Cell found = cell_near(index, nearby);
    ASSERT_EQ(found.x, cell.x);
    ASSERT_EQ(found.y, cell.y);
    ASSERT_EQ(found.z, cell.z);
  }
}

TEST(CellIndex, moves_with_the_cell) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const Cell cell = random_cell(random, 1 << 19);
    const Cell offset = random_cell(random, 1 << 19);
    const std::uint32_t moved = moved_cell(cell_index(cell), cell_index(offset));
    ASSERT_EQ(moved, cell_index(sum(cell, offset)));
    ASSERT_EQ(moved_cell(moved, opposite_cell(cell_index(offset))), cell_index(cell));
  }
}

TEST(CellIndex, differs_along_a_line) {
  constexpr int kCells = 4000;
  for (const Cell step : {Cell{1, 0, 0}, Cell{0, 1, 0}, Cell{0, 0, 1}, Cell{1, 1, 0}, Cell{1, 0, -1}, Cell{0, 1, -1},
                          Cell{1, 1, 1}, Cell{1, -1, 1}, Cell{7, -2, 0}}) {
    std::set<std::uint32_t> indices;
    for (int i = 0; i < kCells; ++i) indices.insert(cell_index({i * step.x, i * step.y, i * step.z}));
    EXPECT_EQ(indices.size(), kCells) << step.x << ' ' << step.y << ' ' << step.z;
  }
}

TEST(CellIndex, differs_in_a_wide_layer) {
  constexpr int kWidth = 2048;
  for (int normal = 0; normal < 3; ++normal) {
    std::vector<bool> is_taken(kCellCount);
    int shared = 0;
    for (int i = 0; i < kWidth; ++i) {
      for (int j = 0; j < kWidth; ++j) {
        const Cell cell = normal == 0 ? Cell{0, i, j} : (normal == 1 ? Cell{i, 0, j} : Cell{i, j, 0});
        const std::uint32_t index = cell_index(cell);
        shared += is_taken[index] ? 1 : 0;
        is_taken[index] = true;
      }
    }
    EXPECT_EQ(shared, 0) << "normal to axis " << normal;
  }
}

TEST(Partition, may_have_the_cells_that_it_has) {
  Random random(3);
  int passed_over = 0;
  for (int i = 0; i < 20000; ++i) {
    Partition partition;
    partition.rank = {1, 3};
    partition.first_cell = random.below(kCellCount);
    partition.end_cell = partition.first_cell + random.below(kCellCount - partition.first_cell + 1U);
    const std::uint32_t offset = random.below(kCellCount);
    const Cell lo = random_cell(random, 3000);
    const Cell hi = sum(
        lo, {static_cast<int>(random.below(5)), static_cast<int>(random.below(5)), static_cast<int>(random.below(5))});
    bool has_some = false;
    for (int z = lo.z; z <= hi.z; ++z) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int x = lo.x; x <= hi.x; ++x) has_some |= partition.has(moved_cell(cell_index({x, y, z}), offset));
      }
    }
    const bool may_have = partition.may_have(lo, hi, offset);
    ASSERT_TRUE(may_have || !has_some) << i;
    passed_over += may_have ? 0 : 1;
  }
  EXPECT_GT(passed_over, 5000);
}

// Rows of cells whose numbers begin again at 0 are those of the first rank, too.
TEST(Partition, may_have_cells_beyond_the_last_number) {
  Partition partition;
  partition.rank = {0, 2};
  partition.end_cell = 3;
  for (std::uint32_t before_last = 0; before_last < 6; ++before_last) {
    const std::uint32_t offset = kCellCount - 1U - before_last;
    EXPECT_EQ(partition.may_have({0, 0, 0}, {4, 0, 0}, offset), before_last < 4) << before_last;
  }
}

}  // namespace
}  // namespace softcd::test
