#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace softcd::benchmarks {

struct Quartiles {
  double first, third;
};

/// Returns the values at a quarter of the way from either end, in order; of fewer than five values, the least and the
/// greatest.
inline Quartiles quartiles_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t quarter = (values.size() - 1) / 4;
  return {values[quarter], values[values.size() - 1 - quarter]};
}

}  // namespace softcd::benchmarks
