#include "lanes/stars.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "each_target.hpp"
#include "random_stars.hpp"

namespace softcd::test {
namespace {

TEST(StarsInLanes, are_the_bytes_of_one_by_one) {
  for_each_target([] {
    Random random(7);
    for (const double size : {1.0, 1e-3, 1e-7, 1e6, 1e9, 1e19}) {
      std::size_t spread_count = 0;
      for (int round = 0; round < 40; ++round) {
        const RandomStars scene(random, 77, size);
        const std::vector<std::uint8_t> at_once =
            scene.spread([](const TestStar& test, std::uint32_t count) { cpu::for_range(test, 0, count); });
        const std::vector<std::uint8_t> one_by_one = scene.spread([](const TestStar& test, std::uint32_t count) {
          for (std::uint32_t i = 0; i < count; ++i) test(i);
        });
        ASSERT_EQ(at_once, one_by_one) << "size " << size;
        for (const VertexStar& star : scene.stars) spread_count += one_by_one[star.centre];
      }
      // Stars are judged if their edges are from 2^-16 to 2^28 long.
      const bool is_judged = size > 1e-4 && size < 1e8;
      EXPECT_EQ(spread_count > 300, is_judged) << spread_count << ", size " << size;
      EXPECT_LT(spread_count, 1500U);
    }
  });
}

}  // namespace
}  // namespace softcd::test
