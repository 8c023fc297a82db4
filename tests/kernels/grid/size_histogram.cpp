#include "softcd/grid/size_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "random.hpp"
#include "softcd/core/team.hpp"

namespace softcd::test {
namespace {

std::vector<std::uint32_t> histogram_of(const std::vector<float>& values) {
  std::vector<std::uint32_t> bins(kSizeBins, 0);
  for (const float value : values) ++bins[size_bin(value)];
  return bins;
}

float mean_of(const std::vector<float>& values) {
  SerialTeam team;
  return clipped_mean(team, histogram_of(values).data());
}

float largest_of(const std::vector<float>& values) {
  SerialTeam team;
  return largest_size(team, histogram_of(values).data());
}

std::vector<float> log_uniform(std::uint64_t seed, double low, double high, std::size_t count) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& value : values) value = static_cast<float>(low * std::pow(high / low, random.unit()));
  return values;
}

TEST(SizeHistogram, bins_hold_their_values) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const auto value = static_cast<float>(std::ldexp(1.0 + random.unit(), static_cast<int>(random.below(250)) - 125));
    const std::uint32_t bin = size_bin(value);
    ASSERT_LE(size_bin_edge(bin), value);
    ASSERT_GT(size_bin_edge(bin + 1), value);
    ASSERT_LE(size_bin_edge(bin + 1), 1.26F * size_bin_edge(bin));
  }
}

TEST(SizeHistogram, mean_is_near_the_mean) {
  for (const double ratio : {1.0001, 2.0, 6.0}) {
    for (const double scale : {1e-30, 1e-6, 1.0, 1e6, 1e30}) {
      const std::vector<float> values = log_uniform(2, scale, ratio * scale, 10000);
      double sum = 0.0;
      for (const float value : values) sum += static_cast<double>(value);
      EXPECT_NEAR(mean_of(values) / (sum / 10000.0), 1.0, 0.13) << ratio << ' ' << scale;
    }
  }
}

TEST(SizeHistogram, outliers_hardly_move_the_mean) {
  std::vector<float> values = log_uniform(3, 0.5, 2.0, 10000);
  const float before = mean_of(values);
  for (int i = 0; i < 10; ++i) values.push_back(1e30F);
  EXPECT_NEAR(mean_of(values), before, 0.02F * before);
  values.push_back(INFINITY);
  EXPECT_NEAR(mean_of(values), before, 0.02F * before);
}

TEST(SizeHistogram, mean_of_the_largest_numbers_is_finite) {
  const std::vector<float> values = log_uniform(5, 1e38, 3.4e38, 10000);
  double sum = 0.0;
  for (const float value : values) sum += static_cast<double>(value);
  EXPECT_NEAR(static_cast<double>(mean_of(values)) / (sum / 10000.0), 1.0, 0.13);
  EXPECT_LT(mean_of({INFINITY}), INFINITY);
  EXPECT_GT(mean_of({INFINITY}), 2e38F);
}

TEST(SizeHistogram, mean_of_nothing_is_zero) {
  EXPECT_EQ(mean_of({}), 0.0F);
  EXPECT_EQ(largest_of({}), 0.0F);
}

TEST(SizeHistogram, points_have_no_size) {
  const float mean = mean_of(std::vector<float>(100, 0.0F));
  EXPECT_GE(mean, 0.0F);
  EXPECT_LT(mean, 1e-30F);
}

TEST(SizeHistogram, huge_counts_do_not_overflow) {
  std::vector<std::uint32_t> bins(kSizeBins, 0);
  bins[size_bin(1.0F)] = 0xFFFFFFFFU;
  SerialTeam team;
  EXPECT_NEAR(clipped_mean(team, bins.data()), 1.0F, 0.15F);
}

TEST(SizeHistogram, largest_is_bounded_from_above) {
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    std::vector<float> values = log_uniform(random.bits(), 1e-3, 1e3, 50);
    const float largest = *std::max_element(values.begin(), values.end());
    const float bound = largest_of(values);
    ASSERT_GE(bound, largest);
    ASSERT_LE(bound, 1.26F * largest);
  }
}

}  // namespace
}  // namespace softcd::test
