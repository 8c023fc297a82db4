#include <gtest/gtest.h>

#include <array>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "random.hpp"
#include "softcd/grid/uniform_grid.hpp"
#include "softcd/math/end_volumes.hpp"
#include "softcd/math/kdop.hpp"
#include "softcd/stages/cell_ranges.hpp"
#include "softcd/stages/slab_reach.hpp"

// Functions with SSE2 return the same as their twins in namespace generic, which other processors use, for any input.
namespace softcd::test {
namespace {

constexpr int kRounds = 400000;
/// The number of kRounds that must have either result for the comparison to mean something.
constexpr int kFew = 4000;

/// Returns zeros of both signs, subnormal numbers, neighbours of these and of 1, the largest number, infinities and
/// NaN.
float awkward_value(Random& random) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr std::array<float, 14> kValues = {0.0F,           -0.0F,
                                             FLT_TRUE_MIN,   -FLT_TRUE_MIN,
                                             FLT_MIN,        -FLT_MIN,
                                             0.5F * FLT_MIN, 1.0F + FLT_EPSILON,
                                             1.0F,           FLT_MAX,
                                             -FLT_MAX,       kInfinity,
                                             -kInfinity,     std::numeric_limits<float>::quiet_NaN()};
  return kValues[random.below(kValues.size())];
}

/// Returns a small integer, so that bounds touch, or now and then an awkward_value.
float value(Random& random, int lowest, int highest) {
  if (random.chance(0.04)) return awkward_value(random);
  return static_cast<float>(lowest + static_cast<int>(random.below(static_cast<std::uint32_t>(highest - lowest + 1))));
}

/// Counts how often both returned true, and both false.
class Outcomes {
 public:
  void add(bool first, bool second, int round) {
    ASSERT_EQ(first, second) << "round " << round;
    ++(first ? yes_ : no_);
  }
  void expect_both() const {
    EXPECT_GT(yes_, kFew);
    EXPECT_GT(no_, kFew);
  }

 private:
  int yes_ = 0;
  int no_ = 0;
};

Kdop18 random_volume(Random& random) {
  Kdop18 dop{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    dop.lo[axis] = value(random, -8, 0);
    dop.hi[axis] = value(random, -1, 8);
  }
  return dop;
}

/// Expects two predicates to agree about pairs that `make` makes.
template <class Make, class First, class Second>
void expect_the_same(std::uint64_t seed, Make make, First first, Second second) {
  Random random(seed);
  Outcomes outcomes;
  for (int round = 0; round < kRounds; ++round) {
    const auto a = make(random);
    const auto b = make(random);
    outcomes.add(first(a, b), second(a, b), round);
  }
  outcomes.expect_both();
}

struct SlabInVolume {
  Kdop18 volume;
  SlabReach reach;
};

TEST(Twins, volumes_are_beyond_slabs) {
  const auto make = [](Random& random) {
    SlabInVolume made{random_volume(random), {}};
    for (float& share : made.reach.share) share = 0.25F * value(random, 2, 4);
    return made;
  };
  constexpr float kGrowth = 4.0F;
  expect_the_same(
      11, make,
      [](const SlabInVolume& a, const SlabInVolume& b) {
        return certainly_beyond_slabs(a.volume, b.volume, kGrowth, a.reach, b.reach);
      },
      [](const SlabInVolume& a, const SlabInVolume& b) {
        return generic::certainly_beyond_slabs(a.volume, b.volume, kGrowth, a.reach, b.reach);
      });
}

TEST(Twins, volumes_overlap) {
  expect_the_same(
      1, random_volume, [](const Kdop18& a, const Kdop18& b) { return overlap(a, b); },
      [](const Kdop18& a, const Kdop18& b) { return generic::overlap(a, b); });
}

TEST(Twins, volumes_contain) {
  const auto make = [](Random& random) {
    Kdop18 dop = random_volume(random);
    if (random.chance(0.5)) {
      for (float& lo : dop.lo) lo -= 4.0F;
      for (float& hi : dop.hi) hi += 4.0F;
    }
    return dop;
  };
  expect_the_same(
      8, make, [](const Kdop18& a, const Kdop18& b) { return contains(a, b); },
      [](const Kdop18& a, const Kdop18& b) { return generic::contains(a, b); });
}

TEST(Twins, end_volumes_are_apart_throughout) {
  expect_the_same(
      2, [](Random& random) { return end_volumes(random_volume(random), random_volume(random)); },
      [](const EndVolumes& a, const EndVolumes& b) { return certainly_apart_throughout(a, b); },
      [](const EndVolumes& a, const EndVolumes& b) { return generic::certainly_apart_throughout(a, b); });
}

// Every axis, in either direction, at either end alone and at both.
TEST(Twins, end_volumes_are_apart_on_one_axis) {
  const auto volume = [](int axis, float at) {
    Kdop18 dop{};
    dop.lo[axis] = dop.hi[axis] = at;
    return dop;
  };
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    for (const float t0 : {-1.0F, 0.0F, 1.0F}) {
      for (const float t1 : {-1.0F, 0.0F, 1.0F}) {
        const EndVolumes a = end_volumes(volume(axis, t0), volume(axis, t1));
        const EndVolumes b = end_volumes(volume(axis, 0.0F), volume(axis, 0.0F));
        EXPECT_EQ(certainly_apart_throughout(a, b), t0 * t1 == 1.0F) << "axis " << axis << ", " << t0 << " to " << t1;
        EXPECT_EQ(generic::certainly_apart_throughout(a, b), t0 * t1 == 1.0F);
      }
      EXPECT_EQ(overlap(volume(axis, t0), volume(axis, 0.0F)), t0 == 0.0F) << "axis " << axis;
      EXPECT_EQ(generic::overlap(volume(axis, t0), volume(axis, 0.0F)), t0 == 0.0F);
    }
  }
}

/// Expects equal bounds; zeros of different signs differ, and NaN equals NaN.
void expect_same_bounds(const Kdop18& a, const Kdop18& b, int round) {
  const auto is_same = [](float x, float y) {
    return (std::isnan(x) && std::isnan(y)) || (x == y && std::signbit(x) == std::signbit(y));
  };
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    ASSERT_TRUE(is_same(a.lo[axis], b.lo[axis]))
        << a.lo[axis] << " is not " << b.lo[axis] << ", round " << round << ", axis " << axis;
    ASSERT_TRUE(is_same(a.hi[axis], b.hi[axis]))
        << a.hi[axis] << " is not " << b.hi[axis] << ", round " << round << ", axis " << axis;
  }
}

TEST(Twins, merged_volumes) {
  Random random(6);
  for (int round = 0; round < kRounds / 4; ++round) {
    const Kdop18 a = random_volume(random);
    const Kdop18 b = random_volume(random);
    expect_same_bounds(merged(a, b), generic::merged(a, b), round);
  }
}

TEST(Twins, integer_volumes) {
  Random random(7);
  for (int round = 0; round < kRounds / 4; ++round) {
    // Points are as far from the origin as a grid reaches, or on the borders of its cells.
    const float scale = random.chance(0.5) ? 1.0F : 130000.0F;
    const auto coordinate = [&] {
      const auto steps = static_cast<int>(random.below(65)) - 32;
      return scale * 0.25F * static_cast<float>(steps);
    };
    const Vec3f points[3] = {{coordinate(), coordinate(), coordinate()},
                             {coordinate(), coordinate(), coordinate()},
                             {coordinate(), coordinate(), coordinate()}};
    const float inverse_size = random.chance(0.5) ? 1.0F : 0.7F;
    const Kdop18 volume = grown_volume(points, random.chance(0.5) ? 0.0F : 0.1F);
    if (!within_grid(volume, inverse_size)) continue;
    const IntegerDop cells = integer_dop(volume, inverse_size);
    const IntegerDop expected = generic::integer_dop(volume, inverse_size);
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      ASSERT_EQ(cells.lo[axis], expected.lo[axis]) << "round " << round << ", axis " << axis;
      ASSERT_EQ(cells.hi[axis], expected.hi[axis]) << "round " << round << ", axis " << axis;
    }
  }
}

template <bool kSwept>
void compare_boxed_entries() {
  Random random(8);
  for (int round = 0; round < kRounds; ++round) {
    BoxedBounds bounds;
    const double centre = random.chance(0.5) ? 0.0 : random.uniform(-1e6, 1e6);
    const auto bound = [&] { return static_cast<float>(centre + random.uniform(-200.0, 200.0)); };
    for (EndVolumes::Axis& axis : bounds) axis = {bound(), bound(), bound(), bound()};
    const auto cell = static_cast<std::uint32_t>(random.bits());
    const float inverse_size = random.chance(0.5) ? 1.0F : 0.7F;
    const BoxedEntry entry = boxed<kSwept>(bounds, cell, inverse_size, {1, 2});
    const BoxedEntry expected = generic::boxed<kSwept>(bounds, cell, inverse_size, {1, 2});
    ASSERT_EQ(std::memcmp(&entry, &expected, sizeof entry), 0) << "round " << round;
  }
}

TEST(Twins, boxed_entries) {
  compare_boxed_entries<true>();
  compare_boxed_entries<false>();
}

}  // namespace
}  // namespace softcd::test
