#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "softcd/fields/options.hpp"

/// Reports of StageTimes in the programs' output.
namespace softcd::demo {

struct StageTime {
  const char* name;
  double StageTimes::*ms;
};

inline constexpr auto kStageTimes = std::apply(
    [](auto... stage) {
      return std::array{StageTime{stage.kName, stage.kPointer}...};
    },
    kFields<StageTimes>);

/// Returns the median; for an even number of values, the mean of the middle two.
inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

/// Returns each stage's own median.
inline StageTimes median(const std::vector<StageTimes>& runs) {
  StageTimes result;
  for (const StageTime& stage : kStageTimes) {
    std::vector<double> values;
    values.reserve(runs.size());
    for (const StageTimes& run : runs) values.push_back(run.*stage.ms);
    result.*stage.ms = median(std::move(values));
  }
  return result;
}

}  // namespace softcd::demo
