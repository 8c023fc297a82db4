#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstdint>

namespace softcd::cpu {

/// Whether the calling thread alone does so much work best.
inline bool is_one_range(std::uint64_t count, std::uint64_t grain) {
  return count <= grain || tbb::this_task_arena::max_concurrency() == 1;
}

/// Calls f(begin, end) for ranges that make up 0 <= i < count. If there are several, they have at least `grain`
/// elements.
template <class F>
void parallel_ranges(std::uint64_t count, std::uint64_t grain, const F& f) {
  if (count == 0) return;
  if (is_one_range(count, grain)) {
    f(0, count);
    return;
  }
  tbb::parallel_for(tbb::blocked_range<std::uint64_t>(0, count, grain),
                    [&](const tbb::blocked_range<std::uint64_t>& range) { f(range.begin(), range.end()); });
}

}  // namespace softcd::cpu
