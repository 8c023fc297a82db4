#pragma once

#include <numeric>

#include "primitives.hpp"

// Primitives that sum, sort and reduce.
namespace softcd::test {

struct CountInBins {
  static constexpr int kHistograms = 3;
  static constexpr int kBins = 64;

  template <class Counter>
  SOFTCD_HD void operator()(std::uint32_t i, Counter& counter) const {
    counter.count(0, i % 64U);
    counter.count(2, hashed(i) % 5U);
    if (i % 2U == 0U) counter.count(2, 63U);
  }
};

struct ValueAt {
  const float* values;
  SOFTCD_HD float operator()(std::uint32_t i) const { return values[i]; }
};

/// Returns keys of so many bits; with few bits every value occurs several times.
template <class Key>
std::vector<Key> scrambled_keys(std::uint32_t count, int bits) {
  std::vector<Key> keys(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t key = (static_cast<std::uint64_t>(hashed(i)) << 32) | hashed(~i);
    keys[i] = static_cast<Key>(key >> (64 - bits));
  }
  return keys;
}

template <class Machine>
class OrderPrimitives : public Primitives<Machine> {
 protected:
  template <class T>
  using SortBuffer = typename Primitives<Machine>::template SortBuffer<T>;

  /// Fills a buffer, with capacity for a few more values.
  template <class T>
  void fill(SortBuffer<T>& buffer, const std::vector<T>& values) {
    buffer.reserve(this->backend(), values.size() + kSpare, 0);
    Machine::copy_in(values, buffer.data());
  }

  template <class Key>
  void expect_sorted_keys(std::uint32_t size, int bits) {
    std::vector<Key> expected = scrambled_keys<Key>(size, bits);
    SortBuffer<Key> keys;
    fill(keys, expected);
    const auto value = this->one_count(size);
    this->backend().sort_keys("sort_keys", Count{value.data(), size + kSpare}, keys, bits);
    std::sort(expected.begin(), expected.end());
    EXPECT_TRUE(Machine::copy_out(keys.data(), size) == expected) << size << " keys of " << bits << " bits";
  }

  /// Expects sorted pairs, with equal keys in their original order.
  template <class Key, class Value>
  void expect_sorted_pairs(std::uint32_t size, int bits) {
    const std::vector<Key> expected_keys = scrambled_keys<Key>(size, bits);
    std::vector<Value> expected(size);
    std::iota(expected.begin(), expected.end(), Value{0});
    SortBuffer<Key> keys;
    SortBuffer<Value> values;
    fill(keys, expected_keys);
    fill(values, expected);
    const auto value = this->one_count(size);
    this->backend().sort_pairs("sort_pairs", Count{value.data(), size + kSpare}, keys, values, bits);
    std::stable_sort(expected.begin(), expected.end(),
                     [&](Value a, Value b) { return expected_keys[a] < expected_keys[b]; });
    const std::vector<Key> sorted_keys = Machine::copy_out(keys.data(), size);
    EXPECT_TRUE(Machine::copy_out(values.data(), size) == expected) << size << " keys of " << bits << " bits";
    for (std::uint32_t i = 0; i < size; ++i) ASSERT_EQ(sorted_keys[i], expected_keys[expected[i]]);
  }

  static constexpr std::uint32_t kSpare = 7;
};
TYPED_TEST_SUITE_P(OrderPrimitives);

TYPED_TEST_P(OrderPrimitives, exclusive_scan_sums_what_comes_before) {
  for (const std::uint32_t size : kSizes) {
    std::vector<std::uint32_t> values(size + 3U, 12345U);
    for (std::uint32_t i = 0; i < size; ++i) values[i] = hashed(i);
    const auto on_backend = this->uploaded(values);
    auto sums = this->uploaded(std::vector<std::uint64_t>(size + 3U, 0U));
    auto total = this->one_count(99);
    const auto value = this->one_count(size);
    this->backend().exclusive_scan("exclusive_scan", Count{value.data(), size + 3U}, on_backend.data(), sums.data(),
                                   total.data());
    std::vector<std::uint64_t> expected(size);
    std::exclusive_scan(values.begin(), values.begin() + size, expected.begin(), std::uint64_t{0});
    EXPECT_TRUE(TypeParam::copy_out(sums.data(), size) == expected) << size;
    EXPECT_EQ(TypeParam::copy_out(total.data(), 1)[0],
              std::accumulate(values.begin(), values.begin() + size, std::uint64_t{0}));
  }
}

TYPED_TEST_P(OrderPrimitives, sort_keys_sorts) {
  for (const std::uint32_t size : kSizes) {
    this->template expect_sorted_keys<std::uint32_t>(size, 5);
    this->template expect_sorted_keys<std::uint32_t>(size, 32);
    this->template expect_sorted_keys<std::uint64_t>(size, 45);
    this->template expect_sorted_keys<std::uint64_t>(size, 64);
  }
}

TYPED_TEST_P(OrderPrimitives, sort_pairs_moves_values_along_and_keeps_the_order_of_equal_keys) {
  for (const std::uint32_t size : kSizes) {
    this->template expect_sorted_pairs<std::uint32_t, std::uint32_t>(size, 4);
    this->template expect_sorted_pairs<std::uint32_t, std::uint64_t>(size, 27);
    this->template expect_sorted_pairs<std::uint64_t, std::uint32_t>(size, 53);
  }
}

TYPED_TEST_P(OrderPrimitives, histogram_counts_in_cleared_bins) {
  constexpr std::size_t kBins = CountInBins::kHistograms * CountInBins::kBins;
  for (const std::uint32_t size : kSizes) {
    auto bins = this->uploaded(std::vector<std::uint32_t>(kBins, 42U));
    const auto value = this->one_count(size);
    this->backend().histogram("histogram", Count{value.data(), size + 1U}, bins.data(), CountInBins::kHistograms,
                              CountInBins::kBins, CountInBins{});
    std::vector<std::uint32_t> expected(kBins, 0U);
    for (std::uint32_t i = 0; i < size; ++i) {
      ++expected[i % 64U];
      ++expected[128U + hashed(i) % 5U];
      expected[191U] += i % 2U == 0U ? 1U : 0U;
    }
    EXPECT_EQ(TypeParam::copy_out(bins.data(), kBins), expected) << size;
  }
}

TYPED_TEST_P(OrderPrimitives, minimum_lowers_to_the_least_value) {
  for (const std::uint32_t size : kSizes) {
    for (const float offset : {0.0F, 0.25F, 2.0F, -0.5F, -3.0F}) {
      std::vector<float> values(size);
      for (std::uint32_t i = 0; i < size; ++i) values[i] = offset + 0x1p-32F * static_cast<float>(hashed(i + 77U));
      const auto on_backend = this->uploaded(values);
      auto least = this->uploaded(std::vector<float>{1.0F});
      const auto value = this->one_count(size);
      this->backend().minimum("minimum", Count{value.data(), size}, ValueAt{on_backend.data()}, least.data());
      const float expected = values.empty() ? 1.0F : std::min(1.0F, *std::min_element(values.begin(), values.end()));
      EXPECT_EQ(TypeParam::copy_out(least.data(), 1)[0], expected) << size << " values from " << offset;
    }
  }
}

REGISTER_TYPED_TEST_SUITE_P(OrderPrimitives, exclusive_scan_sums_what_comes_before, sort_keys_sorts,
                            sort_pairs_moves_values_along_and_keeps_the_order_of_equal_keys,
                            histogram_counts_in_cleared_bins, minimum_lowers_to_the_least_value);

}  // namespace softcd::test
