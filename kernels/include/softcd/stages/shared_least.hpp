#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"

/// A word that many items lower at the same time. The result depends on no order.
namespace softcd {

SOFTCD_HD inline std::uint64_t load(const std::uint64_t* least) {
#if defined(__CUDA_ARCH__)
  return *static_cast<const volatile std::uint64_t*>(least);
#else
  return __atomic_load_n(least, __ATOMIC_RELAXED);
#endif
}

SOFTCD_HD inline void lower(std::uint64_t* least, std::uint64_t value) {
#if defined(__CUDA_ARCH__)
  static_assert(sizeof(unsigned long long) == sizeof(std::uint64_t));
  if (value < load(least)) atomicMin(reinterpret_cast<unsigned long long*>(least), value);
#else
  std::uint64_t before = load(least);
  while (value < before &&
         !__atomic_compare_exchange_n(least, &before, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
  }
#endif
}

}  // namespace softcd
