#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace softcd::benchmarks {

struct Quartiles {
  double first, third;
};

/// The values a quarter of the way from either end, in order; of less than five the least and the greatest.
inline Quartiles quartiles_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t quarter = (values.size() - 1) / 4;
  return {values[quarter], values[values.size() - 1 - quarter]};
}

}  // namespace softcd::benchmarks
