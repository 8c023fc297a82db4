#include "lanes/partners.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <vector>

#include "each_target.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

using cpu::kMostPartners;
constexpr std::uint32_t kMask = (1U << kMaskBits) - 1U;

/// Returns an entry with few different bounds, so that they touch, and now and then any 15 bits; masks have few bits.
BoxedEntry random_entry(Random& random) {
  const std::uint32_t few_bits = static_cast<std::uint32_t>(random.bits() & random.bits() & random.bits()) & kMask;
  BoxedEntry entry{{},
                   static_cast<std::uint32_t>(random.bits()),
                   {},
                   (static_cast<std::uint32_t>(random.bits()) & ~kMask) | few_bits};
  const auto halves = [&](std::uint32_t lowest) {
    const auto half = [&] { return random.chance(0.04) ? random.below(1U << 15) : lowest + random.below(6); };
    return half() | (half() << 16);
  };
  for (int axis = 0; axis < 3; ++axis) {
    entry.lo[axis] = halves(0);
    entry.hi[axis] = halves(2) | kTopBits;
  }
  return entry;
}

template <bool kSwept>
void expect_the_generic_answer() {
  Random random(1);
  int to_test = 0;
  int partners_in_all = 0;
  for (int round = 0; round < 60; ++round) {
    const BoxedEntry entry = random_entry(random);
    for (std::uint32_t count = 0; count <= kMostPartners; ++count) {
      // Exactly as long as needed, so that sanitizers see any read beyond the end.
      std::vector<BoxedEntry> partners(count);
      for (BoxedEntry& partner : partners) partner = random_entry(random);
      const std::uint64_t bits = cpu::partners_to_test<kSwept>(entry, partners.data(), count);
      ASSERT_EQ(bits, cpu::generic::partners_to_test<kSwept>(entry, partners.data(), count)) << count << " partners";
      to_test += std::popcount(bits);
      partners_in_all += static_cast<int>(count);
    }
  }
  EXPECT_GT(to_test, partners_in_all / 50);
  EXPECT_LT(to_test, partners_in_all - partners_in_all / 50);
}

TEST(PartnersInLanes, answer_as_one_by_one) {
  for_each_target([] {
    expect_the_generic_answer<true>();
    expect_the_generic_answer<false>();
  });
}

/// Returns an entry that meets others, except in the tested part.
BoxedEntry meeting_entry() {
  const std::uint32_t middle = 100U | (100U << 16);
  return {{middle, middle, middle}, 7, {middle | kTopBits, middle | kTopBits, middle | kTopBits}, 0};
}

// Tests each half of each bound, in either direction, and each bit of the mask, at every place of a register.
TEST(PartnersInLanes, every_bound_and_every_bit_counts) {
  for_each_target([] {
    constexpr std::uint32_t kCount = 33;
    for (std::uint32_t at = 0; at < kCount; ++at) {
      const std::uint64_t all = (1ULL << kCount) - 1;
      const std::uint64_t others = all & ~(1ULL << at);
      const auto bits_with = [&](const BoxedEntry& entry, const BoxedEntry& partner) {
        std::vector<BoxedEntry> partners(kCount, meeting_entry());
        partners[at] = partner;
        EXPECT_EQ(cpu::partners_to_test<true>(entry, partners.data(), kCount),
                  cpu::generic::partners_to_test<true>(entry, partners.data(), kCount));
        return cpu::partners_to_test<false>(entry, partners.data(), kCount);
      };
      EXPECT_EQ(bits_with(meeting_entry(), meeting_entry()), all);
      for (int axis = 0; axis < 3; ++axis) {
        for (const std::uint32_t one : {1U, 1U << 16}) {
          BoxedEntry above = meeting_entry();
          above.lo[axis] += one;
          EXPECT_EQ(bits_with(meeting_entry(), above), others) << "axis " << axis;
          BoxedEntry below = meeting_entry();
          below.hi[axis] -= one;
          EXPECT_EQ(bits_with(meeting_entry(), below), others) << "axis " << axis;
        }
      }
      for (std::uint32_t bit = 0; bit < 32; ++bit) {
        BoxedEntry entry = meeting_entry();
        entry.bits = 1U << bit;
        EXPECT_EQ(bits_with(entry, entry), bit < kMaskBits ? others : all) << "bit " << bit;
      }
    }
  });
}

}  // namespace
}  // namespace softcd::test
