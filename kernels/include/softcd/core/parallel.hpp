#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <utility>

#ifdef SOFTCD_SERIAL
#include <vector>
#else
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_scan.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#endif

/// The only place that calls oneTBB. With SOFTCD_SERIAL, which the build option SOFTCD_THREADS=OFF defines, the calling
/// thread does everything. Results never depend on how a range is divided.
namespace softcd::parallel {

#ifdef SOFTCD_SERIAL

/// Returns how many threads take part in loops that are started here.
inline std::size_t concurrency() {
  return 1;
}

/// Returns how many threads the process may use.
inline std::size_t allowed_threads() {
  return 1;
}

/// Limits the threads of the process while it lives.
class ThreadLimit {
 public:
  explicit ThreadLimit(std::size_t /*threads*/) {}
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
  ~ThreadLimit() {}  // NOLINT(modernize-use-equals-default): else it would be an unused variable
};

/// Runs functions with threads of its own. Threads that wait here take no work from outside.
class Arena {
 public:
  /// 0: all allowed threads.
  explicit Arena(std::size_t /*most_threads*/) {}
  void limit(std::size_t /*most_threads*/) {}
  template <class F>
  void execute(const F& f) {
    f();
  }
};

/// A function that runs beside the calling thread, until wait() at the latest.
class Task {
 public:
  template <class F>
  void run(const F& f) noexcept {
    try {
      f();
    } catch (...) {
      failure_ = std::current_exception();
    }
  }
  /// Throws what the function has thrown.
  void wait() {
    if (failure_ != nullptr) std::rethrow_exception(std::exchange(failure_, nullptr));
  }
  void cancel() {}

 private:
  std::exception_ptr failure_;
};

/// One value for each thread that asks for its own.
template <class T>
class PerThread {
 public:
  template <class Make>
  explicit PerThread(const Make& make) : values_(1, make()) {}
  T& local() { return values_.front(); }
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }

 private:
  std::vector<T> values_;
};

#else

inline std::size_t concurrency() {
  return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
}

inline std::size_t allowed_threads() {
  return tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
}

class ThreadLimit {
 public:
  explicit ThreadLimit(std::size_t threads) : control_(tbb::global_control::max_allowed_parallelism, threads) {}

 private:
  tbb::global_control control_;
};

class Arena {
 public:
  explicit Arena(std::size_t most_threads) : arena_(size(most_threads)) {}
  void limit(std::size_t most_threads) {
    arena_.terminate();
    arena_.initialize(size(most_threads));
  }
  template <class F>
  void execute(const F& f) {
    arena_.execute(f);
  }

 private:
  /// oneTBB reserves a place for each thread of an arena, and crashes where it cannot.
  static int size(std::size_t most_threads) {
    return most_threads == 0 ? tbb::task_arena::automatic : static_cast<int>(std::min(most_threads, allowed_threads()));
  }

  tbb::task_arena arena_;
};

using Task = tbb::task_group;

template <class T>
using PerThread = tbb::enumerable_thread_specific<T>;

#endif

/// Whether the calling thread alone does so much work best.
inline bool is_one_range(std::uint64_t count, std::uint64_t grain) {
  return count <= grain || concurrency() == 1;
}

/// Calls f(begin, end) for ranges that make up 0 <= i < count. If there are several, they have at least `grain`
/// elements.
template <class F>
void for_ranges(std::uint64_t count, std::uint64_t grain, const F& f) {
  if (count == 0) return;
  if (is_one_range(count, grain)) {
    f(0, count);
    return;
  }
#ifndef SOFTCD_SERIAL
  tbb::parallel_for(tbb::blocked_range<std::uint64_t>(0, count, grain),
                    [&](const tbb::blocked_range<std::uint64_t>& range) { f(range.begin(), range.end()); });
#endif
}

/// Calls f(i) for every i < count.
template <class F>
void for_each(std::size_t count, const F& f) {
#ifdef SOFTCD_SERIAL
  for (std::size_t i = 0; i < count; ++i) f(i);
#else
  tbb::parallel_for(std::size_t{0}, count, f);
#endif
}

/// Calls both.
template <class F, class G>
void invoke(const F& f, const G& g) {
#ifdef SOFTCD_SERIAL
  f();
  g();
#else
  tbb::parallel_invoke(f, g);
#endif
}

/// Returns f(0, count, start), where f(begin, end, value) continues a range's value. Ranges start with `start`, and
/// combine(a, b) joins the values of two.
template <class T, class F, class Combine>
T reduce(std::uint64_t count, std::uint64_t grain, const T& start, const F& f, const Combine& combine) {
  if (is_one_range(count, grain)) return f(0, count, start);
#ifdef SOFTCD_SERIAL
  static_cast<void>(combine);
  return start;
#else
  using Range = tbb::blocked_range<std::uint64_t>;
  return tbb::parallel_reduce(
      Range(0, count, grain), start,
      [&](const Range& range, const T& value) { return f(range.begin(), range.end(), value); }, combine);
#endif
}

/// Returns f(0, count, 0, true), where f(begin, end, sum, is_final) adds a range to the sum of those before. It is
/// called once for each range with is_final, and maybe without it before.
template <class F>
std::uint64_t scan(std::uint64_t count, std::uint64_t grain, const F& f) {
  if (is_one_range(count, grain)) return f(0, count, 0, true);
#ifdef SOFTCD_SERIAL
  return 0;
#else
  using Range = tbb::blocked_range<std::uint64_t>;
  return tbb::parallel_scan(
      Range(0, count, grain), std::uint64_t{0},
      [&](const Range& range, std::uint64_t sum, bool is_final) {
        return f(range.begin(), range.end(), sum, is_final);
      },
      std::plus<>());
#endif
}

}  // namespace softcd::parallel
