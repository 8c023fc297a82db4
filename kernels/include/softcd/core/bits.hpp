#pragma once

#include <bit>
#include <cstdint>

#include "softcd/core/host_device.hpp"

namespace softcd {

SOFTCD_HD inline std::uint32_t count_bits(std::uint32_t word) {
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__popc(word));
#else
  return static_cast<std::uint32_t>(std::popcount(word));
#endif
}

/// Returns the index of the lowest bit that is set; there is one.
SOFTCD_HD inline int lowest_bit(std::uint32_t word) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(word)) - 1;
#else
  return std::countr_zero(word);
#endif
}

/// Returns the number of zeros above the highest bit that is set: 64 for 0.
SOFTCD_HD inline int leading_zeros(std::uint64_t bits) {
#if defined(__CUDA_ARCH__)
  return __clzll(static_cast<long long>(bits));
#else
  return std::countl_zero(bits);
#endif
}

/// Returns the index of the n-th bit that is set (n from 0), of which there are more than n.
SOFTCD_HD inline std::uint32_t nth_bit(std::uint32_t word, std::uint32_t n) {
  for (; n > 0; --n) word &= word - 1U;
  return static_cast<std::uint32_t>(lowest_bit(word));
}

}  // namespace softcd
