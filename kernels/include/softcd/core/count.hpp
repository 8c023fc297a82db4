#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"

namespace softcd {

/// Number of items of a stage, in the backend's memory: kernels read it there, the host need not know it.
/// `*value` may exceed `capacity` when a list overflowed; only `capacity` items exist then.
struct Count {
  const std::uint64_t* value;
  std::uint64_t capacity;

  SOFTCD_HD std::uint64_t get() const { return *value < capacity ? *value : capacity; }
};

}  // namespace softcd
