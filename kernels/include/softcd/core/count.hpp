#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"

namespace softcd {

/// Number of items of a stage, in the backend's memory. Kernels read it there, so the host need not know it. When a
/// list overflows, `*value` exceeds `capacity`; only `capacity` items exist then.
struct Count {
  const std::uint64_t* value;
  std::uint64_t capacity;

  SOFTCD_HD std::uint64_t get() const { return *value < capacity ? *value : capacity; }
};

/// One of `count` equal parts of a stage's work.
struct Share {
  std::uint32_t index;
  std::uint32_t count;

  friend bool operator==(const Share&, const Share&) = default;

  SOFTCD_HD std::uint64_t begin(std::uint64_t work) const { return bound(work, index); }
  SOFTCD_HD std::uint64_t end(std::uint64_t work) const { return bound(work, index + 1ULL); }

 private:
  SOFTCD_HD std::uint64_t bound(std::uint64_t work, std::uint64_t part) const {
    return work / count * part + work % count * part / count;
  }
};

}  // namespace softcd
