#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace softcd::benchmarks {

/// What the caller waits for.
template <class F>
double milliseconds_of(const F& f) {
  const auto begin = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// The median of what follows the first value, which was measured to warm up: it takes memory. There are at least two.
inline double median_without_first(std::vector<double> values) {
  const auto median = values.begin() + static_cast<std::ptrdiff_t>(1 + (values.size() - 1) / 2);
  std::nth_element(values.begin() + 1, median, values.end());
  return *median;
}

}  // namespace softcd::benchmarks
