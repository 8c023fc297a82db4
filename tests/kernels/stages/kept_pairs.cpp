#include "softcd/stages/kept_pairs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "host_scene.hpp"

namespace softcd::test {
namespace {

Kdop18 unit_volume() {
  Kdop18 volume{};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    volume.lo[axis] = -1.0F;
    volume.hi[axis] = 1.0F;
  }
  return volume;
}

/// Returns the indices that FindEscaped reports.
std::vector<std::uint32_t> escaped_of(const std::vector<Kdop18>& volumes, const std::vector<Kdop18>& kept) {
  Collector<std::uint32_t> active;
  Collector<std::uint32_t> escaped;
  std::vector<TriangleShape> shapes(volumes.size());
  const FindEscaped stage{volumes.data(), kept.data(), shapes.data()};
  for (std::uint32_t t = 0; t < volumes.size(); ++t) stage(t, active, escaped);
  for (const std::uint32_t t : escaped.items) EXPECT_EQ(shapes[t].flags, kEscapedTriangle);
  EXPECT_EQ(active.items.size(), volumes.size());
  return escaped.items;
}

// Triangle t leaves its kept volume by one rounding on one of the 18 sides, whatever t is.
TEST(KeptPairs, every_triangle_that_leaves_its_volume_is_reported) {
  constexpr std::uint32_t kCount = 36 * 8;
  const std::vector<Kdop18> kept(kCount, unit_volume());
  std::vector<Kdop18> volumes = kept;
  EXPECT_TRUE(escaped_of(volumes, kept).empty()) << "a volume is within itself";
  for (std::uint32_t t = 0; t < kCount; ++t) {
    const auto axis = static_cast<int>(t % kKdopAxes);
    if ((t / kKdopAxes) % 2 == 0) {
      volumes[t].lo[axis] = std::nextafter(-1.0F, -2.0F);
    } else {
      volumes[t].hi[axis] = std::nextafter(1.0F, 2.0F);
    }
  }
  const std::vector<std::uint32_t> escaped = escaped_of(volumes, kept);
  ASSERT_EQ(escaped.size(), kCount);
  for (std::uint32_t t = 0; t < kCount; ++t) EXPECT_EQ(escaped[t], t);
}

// Diagonals are not of unit length: a bound along one is sqrt(2) times as far away as the plane.
TEST(KeptPairs, headroom_is_the_distance_to_the_nearest_side) {
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    Kdop18 kept = unit_volume();
    for (int other = 0; other < kKdopAxes; ++other) {
      kept.lo[other] -= 8.0F;
      kept.hi[other] += 8.0F;
    }
    kept.hi[axis] = 1.5F;
    const Kdop18 volume = unit_volume();
    const float expected = axis < 3 ? 0.5F : 0.5F / std::sqrt(2.0F);
    EXPECT_FLOAT_EQ((MeasureHeadroom{&volume, &kept}(0)), expected) << axis;
  }
}

}  // namespace
}  // namespace softcd::test
