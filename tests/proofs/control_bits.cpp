#include "softcd/grid/control_bits.hpp"

#include "cell_sets.hpp"
#include "enumeration.hpp"
#include "lower_neighbour.hpp"

namespace softcd::test {
namespace {

constexpr std::uint32_t kMaskCount = 1U << kMaskBits;

// Statement 1. Of the 26 cells around one, each that is lower has one bit of the mask, and no other has.
TEST(LowerNeighbours, are_all_lower_cells_around_a_cell) {
  Enumeration cells(26);
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        if (x == 0 && y == 0 && z == 0) continue;
        int bits = 0;
        for (int bit = 0; bit < static_cast<int>(kMaskBits); ++bit) {
          const Cell lower = lower_neighbour({5, 6, 7}, bit);
          bits += lower.x == 5 + x && lower.y == 6 + y && lower.z == 7 + z ? 1 : 0;
        }
        ASSERT_EQ(bits, is_lower({x, y, z}, {0, 0, 0}) ? 1 : 0) << x << ' ' << y << ' ' << z;
        cells.next();
      }
    }
  }
}

// Statement 2. A pair is tested where its masks have no common bit, and nowhere else. It is flagged if one of the two
// is split and neither fits into 2 x 2 x 2 cells. The other bits of entries have no influence.
TEST(Verdict, depends_on_common_bits_and_on_splits) {
  Enumeration pairs(std::uint64_t{4} * 4 * kMaskCount * kMaskCount);
  for (std::uint32_t kinds = 0; kinds < 16; ++kinds) {
    const bool split_a = (kinds & 1U) != 0U, fits_a = (kinds & 2U) != 0U;
    const bool split_b = (kinds & 4U) != 0U, fits_b = (kinds & 8U) != 0U;
    const Verdict executed = (split_a || split_b) && !(fits_a || fits_b) ? Verdict::execute_and_flag : Verdict::execute;
    for (std::uint32_t a = 0; a < kMaskCount; ++a) {
      const Entry entry_a{0, entry_bits(ExactControl::pack(a, split_a, fits_a), 31, 63)};
      for (std::uint32_t b = 0; b < kMaskCount; ++b) {
        const Entry entry_b{1, entry_bits(ExactControl::pack(b, split_b, fits_b), 31, 63)};
        ASSERT_EQ(ExactControl::judge(0, entry_a, entry_b), (a & b) != 0U ? Verdict::skip : executed)
            << a << ' ' << b << ' ' << kinds;
      }
    }
    pairs.add(std::uint64_t{kMaskCount} * kMaskCount);
  }
}

// Statement 3. Bit a of K tells that the lower neighbour along axis a is missing. So a pair that is tested has all
// three bits in one K or the other.
TEST(MissingFaceNeighbours, cover_all_axes_in_a_pair_that_is_tested) {
  Enumeration masks(std::uint64_t{kMaskCount} + std::uint64_t{kMaskCount} * kMaskCount);
  for (std::uint32_t mask = 0; mask < kMaskCount; ++mask) {
    std::uint32_t missing = 0;
    for (int bit = 0; bit < static_cast<int>(kMaskBits); ++bit) {
      const Cell lower = lower_neighbour({0, 0, 0}, bit);
      if (((mask >> bit) & 1U) != 0U) continue;
      if (lower.y == 0 && lower.z == 0) missing |= 1U;
      if (lower.x == 0 && lower.z == 0) missing |= 2U;
      if (lower.x == 0 && lower.y == 0) missing |= 4U;
    }
    ASSERT_EQ(missing_face_neighbours(mask), missing) << mask;
    masks.next();
  }
  for (std::uint32_t a = 0; a < kMaskCount; ++a) {
    for (std::uint32_t b = 0; b < kMaskCount; ++b) {
      if ((a & b) == 0U) {
        ASSERT_EQ(missing_face_neighbours(a) | missing_face_neighbours(b), 7U) << a << ' ' << b;
      }
    }
    masks.add(kMaskCount);
  }
}

}  // namespace
}  // namespace softcd::test
