#pragma once

#include <cstddef>

#include "softcd/core/parallel.hpp"

namespace softcd {

/// Calls f(i) for every i < count, where f does a little work for one body. Uses several threads where count is large
/// enough to justify waking them.
template <class F>
void for_each_body(std::size_t count, const F& f) {
  constexpr std::size_t kManyBodies = 4096;
  constexpr std::size_t kGrain = 512;
  parallel::for_ranges(count, count < kManyBodies ? count : kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  });
}

}  // namespace softcd
