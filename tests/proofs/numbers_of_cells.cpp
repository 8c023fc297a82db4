#include "cell_sets.hpp"
#include "enumeration.hpp"
#include "softcd/grid/cell_index.hpp"

namespace softcd::test {
namespace {

// Statement 13. Two elements that share a cell have equal numbers for equal cells only: no two cells that are at most
// twice kMaxSpan apart along each axis have the same number.
TEST(NumbersOfCells, differ_within_two_elements_that_share_a_cell) {
  constexpr int kFarthest = 2 * (kMaxSpan - 1);
  constexpr std::uint64_t kSide = 2 * kFarthest + 1;
  Enumeration differences(kSide * kSide * kSide);
  for (int z = -kFarthest; z <= kFarthest; ++z) {
    for (int y = -kFarthest; y <= kFarthest; ++y) {
      for (int x = -kFarthest; x <= kFarthest; ++x) {
        const bool is_origin = x == 0 && y == 0 && z == 0;
        if ((cell_index({x, y, z}) == 0U) != is_origin) FAIL() << x << ' ' << y << ' ' << z;
      }
      differences.add(kSide);
    }
  }
}

// Statement 14. A cell is found again from its number and a cell that is at most kMaxSpan away along each axis. The
// number of a sum is the sum of numbers, so that the place of the near cell changes nothing.
TEST(NumbersOfCells, give_the_cell_near_another_one) {
  constexpr std::uint64_t kSide = 2 * kMaxSpan + 1;
  Enumeration cells(kSide * kSide * kSide);
  const Cell near = {-1048570, 77, 1048575};
  for (int z = -kMaxSpan; z <= kMaxSpan; ++z) {
    for (int y = -kMaxSpan; y <= kMaxSpan; ++y) {
      for (int x = -kMaxSpan; x <= kMaxSpan; ++x) {
        const Cell cell = {near.x + x, near.y + y, near.z + z};
        const Cell found = cell_near(cell_index(cell), near);
        if (found.x != cell.x || found.y != cell.y || found.z != cell.z) FAIL() << x << ' ' << y << ' ' << z;
      }
      cells.add(kSide);
    }
  }
}

}  // namespace
}  // namespace softcd::test
