#include "softcd/grid/control_bits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

#include "grid/random_cells.hpp"
#include "lower_neighbour.hpp"
#include "random.hpp"
#include "softcd/stages/cell_assignment.hpp"

namespace softcd::test {
namespace {

/// A cell by (z, y, x), the order in which neighbours are "lower".
using CellKey = std::tuple<int, int, int>;
CellKey key_of(Cell c) {
  return {c.z, c.y, c.x};
}

/// A set of cells with the mask of each.
using MaskedCells = std::map<CellKey, std::uint32_t>;

std::uint32_t mask_by_search(const MaskedCells& cells, Cell c) {
  std::uint32_t mask = 0;
  for (int bit = 0; bit < static_cast<int>(kMaskBits); ++bit) {
    if (cells.contains(key_of(lower_neighbour(c, bit)))) mask |= 1U << bit;
  }
  return mask;
}

MaskedCells masked_union(const std::vector<IntegerDop>& dops) {
  MaskedCells cells;
  for (const IntegerDop& dop : dops) {
    for_each_cell(dop, [&](Cell c) { cells[key_of(c)] = 0; });
  }
  for (auto& [key, mask] : cells) {
    const auto [z, y, x] = key;
    mask = mask_by_search(cells, {x, y, z});
  }
  return cells;
}

struct Meetings {
  int shared = 0;
  int executed = 0;
};

Meetings meet(const MaskedCells& a, const MaskedCells& b) {
  Meetings meetings;
  for (const auto& [key, mask] : a) {
    const auto other = b.find(key);
    if (other == b.end()) continue;
    ++meetings.shared;
    const Entry entry_a{0, ExactControl::pack(mask, false, false)};
    const Entry entry_b{1, ExactControl::pack(other->second, false, false)};
    if (ExactControl::judge(0, entry_a, entry_b) != Verdict::skip) ++meetings.executed;
  }
  return meetings;
}

bool fits_in_two(const MaskedCells& cells) {
  int low[3] = {1 << 20, 1 << 20, 1 << 20};
  int high[3] = {-(1 << 20), -(1 << 20), -(1 << 20)};
  for (const auto& [key, mask] : cells) {
    const int c[3] = {std::get<0>(key), std::get<1>(key), std::get<2>(key)};
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], c[axis]);
      high[axis] = std::max(high[axis], c[axis]);
    }
  }
  return high[0] - low[0] < 2 && high[1] - low[1] < 2 && high[2] - low[2] < 2;
}

TEST(ControlBits, lower_neighbours_are_thirteen_and_lower) {
  const Cell c{5, -3, 7};
  std::map<CellKey, int> seen;
  for (int bit = 0; bit < static_cast<int>(kMaskBits); ++bit) {
    const Cell n = lower_neighbour(c, bit);
    EXPECT_LT(key_of(n), key_of(c));
    EXPECT_LE(std::max({std::abs(n.x - c.x), std::abs(n.y - c.y), std::abs(n.z - c.z)}), 1);
    seen[key_of(n)] = bit;
  }
  EXPECT_EQ(seen.size(), kMaskBits);
}

TEST(ControlBits, mask_from_rows_is_the_mask_by_search) {
  Random random(1);
  for (int i = 0; i < 3000; ++i) {
    const IntegerDop dop = random_integer_dop(random, 4);
    const MaskedCells cells = masked_union({dop});
    for_each_cell(dop, [&](Cell c) { ASSERT_EQ(CellRow(dop, c.y, c.z).mask(c.x), cells.at(key_of(c))); });
  }
}

/// Returns the shared cells in which a pair of integer DOPs is tested, with the masks that RegisterTriangle computes.
/// It uses no containers, so that a million pairs take seconds.
Meetings meet(const IntegerDop& a, const IntegerDop& b) {
  Meetings meetings;
  for_each_cell(a, [&](Cell c) {
    if (!b.contains(c)) return;
    ++meetings.shared;
    std::uint32_t mask_b = 0;
    for (int bit = 0; bit < static_cast<int>(kMaskBits); ++bit) {
      if (b.contains(lower_neighbour(c, bit))) mask_b |= 1U << bit;
    }
    const Entry entry_a{0, ExactControl::pack(CellRow(a, c.y, c.z).mask(c.x), false, false)};
    const Entry entry_b{1, ExactControl::pack(mask_b, false, false)};
    if (ExactControl::judge(0, entry_a, entry_b) != Verdict::skip) ++meetings.executed;
  });
  return meetings;
}

TEST(ControlBits, a_million_pairs_of_whole_triangles_are_tested_once) {
  Random random(2);
  int meeting_pairs = 0;
  for (int i = 0; meeting_pairs < 1000000; ++i) {
    const IntegerDop a = random_integer_dop(random, 1 + i % 4);
    const IntegerDop b = random_integer_dop(random, 1 + i / 4 % 4);
    const Meetings meetings = meet(a, b);
    ASSERT_EQ(meetings.executed, meetings.shared > 0 ? 1 : 0) << "pair " << i;
    meeting_pairs += meetings.shared > 0 ? 1 : 0;
  }
}

/// Returns the cells along a random walk: a set that is far from convex.
MaskedCells random_walk(Random& random, int steps) {
  MaskedCells cells;
  Cell c{static_cast<int>(random.below(3)), static_cast<int>(random.below(3)), static_cast<int>(random.below(3))};
  for (int i = 0; i < steps; ++i) {
    cells[key_of(c)] = 0;
    c.x += static_cast<int>(random.below(3)) - 1;
    c.y += static_cast<int>(random.below(3)) - 1;
    c.z += static_cast<int>(random.below(3)) - 1;
  }
  for (auto& [key, mask] : cells) {
    const auto [z, y, x] = key;
    mask = mask_by_search(cells, {x, y, z});
  }
  return cells;
}

// The sets of split triangles are unions of integer DOPs and need not be convex. A pair is never skipped in all its
// cells. It is tested once where one of the two sets fits into 2 x 2 x 2 cells. Otherwise it may be tested again, which
// is why such pairs are flagged.
TEST(ControlBits, pairs_of_any_sets_are_never_skipped) {
  Random random(3);
  int repeated = 0;
  int with_small = 0;
  for (int i = 0; i < 40000; ++i) {
    const MaskedCells a = random_walk(random, 1 + i % 20);
    const MaskedCells b = i % 2 == 0 ? masked_union({random_integer_dop(random, 2), random_integer_dop(random, 2)})
                                     : random_walk(random, 1 + i / 20 % 12);
    const Meetings meetings = meet(a, b);
    if (meetings.shared == 0) continue;
    ASSERT_GE(meetings.executed, 1) << "pair " << i;
    if (fits_in_two(a) || fits_in_two(b)) {
      ++with_small;
      ASSERT_EQ(meetings.executed, 1) << "pair " << i;
    }
    repeated += meetings.executed > 1 ? 1 : 0;
  }
  EXPECT_GT(repeated, 100) << "what flags are for must occur";
  EXPECT_GT(with_small, 1000);
}

TEST(ControlBits, face_neighbours_prune_only_what_masks_skip) {
  const std::uint32_t all = 1U << kMaskBits;
  for (std::uint32_t a = 0; a < all; ++a) {
    const std::uint32_t k_a = missing_face_neighbours(a);
    for (std::uint32_t b = 0; b < all; ++b) {
      if ((a & b) != 0) continue;
      ASSERT_EQ(k_a | missing_face_neighbours(b), 7U);
    }
    ASSERT_EQ((k_a & 1U) != 0, (a & (1U << 12)) == 0);
  }
}

TEST(ControlBits, partners_begin_with_the_missing_bits) {
  for (std::uint32_t k_a = 0; k_a < 8; ++k_a) {
    for (std::uint32_t k_b = 0; k_b < 8; ++k_b) {
      if ((k_a | k_b) == 7U) {
        EXPECT_GE(k_a, ExactControl::lowest_partner_k(k_b));
      }
    }
  }
}

TEST(ControlBits, keys_hold_cell_and_rank) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const std::uint32_t cell = random.below(kCellCount);
    const std::uint32_t rank = random.below(8);
    const std::uint32_t key = entry_key(cell, rank);
    ASSERT_EQ(key_cell(key), cell);
    ASSERT_EQ(key_rank(key), rank);
  }
  EXPECT_LT(entry_key(9, 0), entry_key(9, 7));
  EXPECT_LT(entry_key(9, 7), entry_key(10, 0));
}

TEST(ControlBits, entries_hold_what_was_packed) {
  for (std::uint32_t owned = 0; owned < 64; ++owned) {
    const Entry entry{77, entry_bits(ExactControl::pack(0x1FFF, true, true), 33, owned)};
    EXPECT_EQ(owned_vertices(entry), owned & 7U);
    EXPECT_EQ(owned_edges(entry), owned >> 3U);
    EXPECT_EQ(body_class(entry), 1U);
    EXPECT_EQ(body_class(Entry{77, entry_bits(0x7FFFF, 33, owned)}), 1U);
  }
}

TEST(ControlBits, only_pairs_with_a_large_split_side_are_flagged) {
  const auto entry = [](bool split, bool fits) { return Entry{0, ExactControl::pack(0, split, fits)}; };
  EXPECT_EQ(ExactControl::judge(0, entry(false, false), entry(false, false)), Verdict::execute);
  EXPECT_EQ(ExactControl::judge(0, entry(true, false), entry(false, true)), Verdict::execute);
  EXPECT_EQ(ExactControl::judge(0, entry(true, false), entry(false, false)), Verdict::execute_and_flag);
  EXPECT_EQ(ExactControl::judge(0, entry(true, false), entry(true, false)), Verdict::execute_and_flag);
  const Entry a{0, ExactControl::pack(5, false, false)};
  const Entry b{1, ExactControl::pack(4, true, false)};
  EXPECT_EQ(ExactControl::judge(0, a, b), Verdict::skip);
}

}  // namespace
}  // namespace softcd::test
