#pragma once

#include <cstdint>

#include "softcd/core/count.hpp"
#include "softcd/core/host_device.hpp"
#include "softcd/core/types.hpp"
#include "softcd/stages/cell_assignment.hpp"

namespace softcd {

/// Targets say where an appended value is stored.
template <class T>
struct ArrayTarget {
  using Value = T;
  T* data;
  SOFTCD_HD void store(std::uint64_t i, const T& value) const { data[i] = value; }
};

/// Counts values without keeping them.
struct CountTarget {
  using Value = std::uint32_t;
  SOFTCD_HD void store(std::uint64_t /*i*/, std::uint32_t /*value*/) const {}
};

/// A list that a stage appends to. A value that does not fit is counted but not stored. Then the list grows and the
/// stage runs again: nothing is ever dropped.
template <class Target>
struct Appender {
  Target target;
  std::uint64_t* count;
  std::uint64_t capacity;
};

}  // namespace softcd
