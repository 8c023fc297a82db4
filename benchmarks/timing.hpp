#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace softcd::benchmarks {

/// Returns the time that the caller waits for f.
template <class F>
double milliseconds_of(const F& f) {
  const auto begin = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

/// Returns the median of all values but the first, which belongs to a warm-up that allocates memory. There must be at
/// least two.
inline double median_without_first(std::vector<double> values) {
  const auto median = values.begin() + static_cast<std::ptrdiff_t>(1 + (values.size() - 1) / 2);
  std::nth_element(values.begin() + 1, median, values.end());
  return *median;
}

}  // namespace softcd::benchmarks
