#include <cstdint>
#include <cstring>

#include "enumeration.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd::test {
namespace {

float float_of(std::uint32_t bits) {
  float x = 0.0F;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

/// Whether both functions are at least one float away from a float with these bits, and from its opposite; if `near`,
/// at most two. Floats have the order of their bits.
bool is_away(std::uint32_t bits, bool near) {
  const float x = float_of(bits);
  const bool away = outward_up(x) >= float_of(bits + 1) && outward_down(-x) <= -float_of(bits + 1) &&
                    outward_down(x) <= float_of(bits - 1) && outward_up(-x) >= -float_of(bits - 1);
  return away && (!near || (outward_up(x) <= float_of(bits + 2) && outward_down(-x) >= -float_of(bits + 2) &&
                            outward_down(x) >= float_of(bits - 2) && outward_up(-x) <= -float_of(bits - 2)));
}

// Statement 30. outward_up() is at least the next float, and outward_down() at most the one before: so no single
// rounding gets past them. From 2^-100 on they are at most two floats away. For all floats up to 2^-76 and from 1 to 4.
// Floats between and behind have the same results times a power of two, as FLT_MIN is then lost in a sum.
TEST(Outward, is_one_or_two_floats_away) {
  constexpr std::uint32_t kNear = 0x0D800000U, kSmall = 0x19800000U, kOne = 0x3F800000U, kFour = 0x40800000U;
  ASSERT_TRUE(float_of(kNear) == 0x1p-100F && float_of(kSmall) == 0x1p-76F);
  ASSERT_TRUE(float_of(kOne) == 1.0F && float_of(kFour) == 4.0F);
  ASSERT_TRUE(outward_up(0.0F) > 0.0F && outward_down(0.0F) < 0.0F);
  Enumeration floats(2 * (kSmall + std::uint64_t{kFour - kOne}));
  for (std::uint32_t bits = 1; bits <= kSmall; ++bits) {
    if (!is_away(bits, bits >= kNear)) FAIL() << float_of(bits);
  }
  floats.add(2 * std::uint64_t{kSmall});
  for (std::uint32_t bits = kOne; bits < kFour; ++bits) {
    if (!is_away(bits, true)) FAIL() << float_of(bits);
  }
  floats.add(2 * std::uint64_t{kFour - kOne});
}

}  // namespace
}  // namespace softcd::test
