#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstdint>

namespace softcd::cpu {

/// Whether so much work is done best by the calling thread alone.
inline bool is_one_range(std::uint64_t count, std::uint64_t grain) {
  return count <= grain || tbb::this_task_arena::max_concurrency() == 1;
}

/// f(begin, end) for ranges of 0 <= i < count that make up all of it; of at least `grain`, where there are several.
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
