#pragma once

#include <type_traits>

#include "softcd/core/host_device.hpp"

namespace softcd {

/// Adds 1 to a counter that many threads share. Returns its value before.
template <class T>
SOFTCD_HD T count_one_more(T* counter) {
#if defined(__CUDA_ARCH__)
  using Word = std::conditional_t<sizeof(T) == 8, unsigned long long, unsigned>;
  static_assert(sizeof(T) == sizeof(Word));
  return atomicAdd(reinterpret_cast<Word*>(counter), Word{1});
#else
  return __atomic_fetch_add(counter, T{1}, __ATOMIC_RELAXED);
#endif
}

}  // namespace softcd
