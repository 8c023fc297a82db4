#include "softcd/stages/shared_pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

/// The cells of a whole triangle, or of a split one with some share of the cells around it marked.
class SomeCells {
 public:
  SomeCells(Random& random, Vec3d lo, Vec3d hi, bool is_split) : volume_(empty_kdop()) {
    extend(volume_, vec3_cast<float>(lo));
    extend(volume_, vec3_cast<float>(hi));
    if (!is_split) return;
    split_ = 0;
    const IntegerDop cells = integer_dop(volume_, 1.0F);
    box_ = {cells.lo[0],
            cells.lo[1],
            cells.lo[2],
            cells.hi[0] - cells.lo[0] + 1,
            cells.hi[1] - cells.lo[1] + 1,
            cells.hi[2] - cells.lo[2] + 1};
    words_.resize(box_.words());
    for (int z = 0; z < box_.depth; ++z) {
      for (int y = 0; y < box_.height; ++y) {
        const auto row = static_cast<std::uint32_t>(z * box_.height + y) * box_.words_per_row();
        for (std::uint32_t x = 0; x < static_cast<std::uint32_t>(box_.width); ++x) {
          if (random.chance(0.02)) words_[row + x / 32U] |= 1U << (x % 32U);
        }
      }
    }
  }

  TriangleCells cells() { return {volume_, 1.0F, split_, {&box_, &offset_, words_.data(), words_.size()}}; }
  bool has(Cell c) const {
    if (split_ == kNoIndex) return integer_dop(volume_, 1.0F).contains(c);
    const int x = c.x - box_.x, y = c.y - box_.y, z = c.z - box_.z;
    if (x < 0 || x >= box_.width || y < 0 || y >= box_.height || z < 0 || z >= box_.depth) return false;
    const auto row = static_cast<std::uint32_t>(z * box_.height + y) * box_.words_per_row();
    return ((words_[row + static_cast<std::uint32_t>(x) / 32U] >> (x % 32)) & 1U) != 0U;
  }

 private:
  Kdop18 volume_;
  std::uint32_t split_ = kNoIndex;
  SplitBox box_{};
  std::uint64_t offset_ = 0;
  std::vector<std::uint32_t> words_;
};

std::optional<Cell> first_by_trial(const SomeCells& a, const SomeCells& b) {
  for (int z = -2; z <= 6; ++z) {
    for (int y = -2; y <= 6; ++y) {
      for (int x = -2; x <= 120; ++x) {
        if (a.has({x, y, z}) && b.has({x, y, z})) return Cell{x, y, z};
      }
    }
  }
  return {};
}

// Rows of cells that lie in several words of bits, and begin anywhere in one.
TEST(FirstCommonCell, is_found_across_words_of_bits) {
  Random random(1);
  int found = 0;
  const auto some = [&random] {
    const Vec3d lo = {random.uniform(0, 40), random.uniform(0, 2), random.uniform(0, 2)};
    return SomeCells(random, lo, lo + Vec3d{random.uniform(30, 70), 2, 2}, random.chance(0.7));
  };
  for (int i = 0; i < 1000; ++i) {
    SomeCells a = some();
    SomeCells b = some();
    const std::optional<Cell> expected = first_by_trial(a, b);
    Cell cell{};
    ASSERT_EQ(first_common_cell(a.cells(), b.cells(), cell), expected.has_value()) << i;
    if (!expected) continue;
    ++found;
    ASSERT_TRUE(cell.x == expected->x && cell.y == expected->y && cell.z == expected->z) << i;
  }
  EXPECT_GT(found, 300);
}

}  // namespace
}  // namespace softcd::test
