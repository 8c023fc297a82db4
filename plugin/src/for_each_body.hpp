#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace softcd {

/// Calls f(i) for every i < count, where f does a little work for one body. Uses several threads where count is large
/// enough to justify waking them.
template <class F>
void for_each_body(std::size_t count, const F& f) {
  constexpr std::size_t kManyBodies = 4096;
  constexpr std::size_t kGrain = 512;
  if (count < kManyBodies) {
    for (std::size_t i = 0; i < count; ++i) f(i);
    return;
  }
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) f(i);
                    });
}

}  // namespace softcd
