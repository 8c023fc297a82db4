#pragma once

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <new>
#include <tuple>
#include <utility>
#include <vector>

#include "lanes/feature_pairs.hpp"
#include "lanes/pair_tests.hpp"
#include "lanes/patches.hpp"
#include "lanes/stars.hpp"
#include "lanes/volumes.hpp"
#include "output.hpp"
#include "radix_sort.hpp"
#include "softcd/core/parallel.hpp"
#include "softcd/core/team.hpp"
#include "softcd/pipeline/detector.hpp"
#include "softcd/pipeline/memory_account.hpp"
#include "softcd/pipeline/output.hpp"
#include "softcd/pipeline/stage_clock.hpp"
#include "softcd/pipeline/workspace.hpp"
#include "work_units.hpp"

namespace softcd {

/// The stages' primitives on the host. All work is done when a call returns, except launch(), which runs the whole
/// detection as a task.
class CpuBackend {
 public:
  /// Counts are in host memory: a list that overflowed can grow at once.
  static constexpr bool kKnowsCounts = true;
  /// Patches stand for triangles in the grid.
  static constexpr bool kHasPatches = true;

  /// The backend's data for one query.
  struct Session {};

  /// Refers to a host array, which it does not copy.
  template <class T>
  class Mirror {
   public:
    void follow(CpuBackend& /*backend*/, Span<const T> values, Span<const Range> /*changes*/) { data_ = values.data(); }
    const T* data() const { return data_; }

   private:
    const T* data_ = nullptr;
  };

  /// Uninitialised memory that only grows.
  template <class T>
  class Buffer {
    static_assert(std::is_trivially_copyable_v<T>);

   public:
    /// Grows the buffer and keeps the first `kept` values. If none are kept, frees the old memory first.
    void reserve(CpuBackend& backend, std::uint64_t capacity, std::uint64_t kept) {
      if (capacity <= capacity_) return;
      if (kept == 0) *this = {};
      const std::uint64_t bytes = capacity * sizeof(T);
      if (!std::in_range<std::size_t>(bytes)) throw std::bad_alloc();  // with 32 bits
      Memory grown(backend.account_, bytes, [&] { return std::unique_ptr<std::byte[]>(new std::byte[bytes]); });
      if (kept > 0) std::memcpy(grown.get(), memory_.get(), std::min(kept, capacity_) * sizeof(T));
      memory_ = std::move(grown);
      capacity_ = capacity;
    }
    T* data() { return reinterpret_cast<T*>(memory_.get()); }
    const T* data() const { return reinterpret_cast<const T*>(memory_.get()); }
    std::uint64_t capacity() const { return capacity_; }
    void rewind() {}

   private:
    using Memory = AccountedMemory<std::unique_ptr<std::byte[]>>;

    Memory memory_;
    std::uint64_t capacity_ = 0;
  };

  /// Refers to a buffer that the host reads, which it does not copy.
  template <class T>
  class Readback {
   public:
    /// Returns the first `count` values. All work that writes them must be done. Valid until the buffer is written to
    /// again.
    Span<const T> read(CpuBackend& /*backend*/, const Buffer<T>& buffer, std::uint64_t count) {
      return {buffer.data(), count};
    }
  };

  /// A buffer and the scratch that sorting it needs.
  template <class T>
  class SortBuffer {
   public:
    void reserve(CpuBackend& backend, std::uint64_t capacity, std::uint64_t kept) {
      if (capacity > scratch_.capacity()) scratch_ = {};
      current_.reserve(backend, capacity, kept);
      scratch_.reserve(backend, capacity, 0);
    }
    T* data() { return current_.data(); }
    T* scratch() { return scratch_.data(); }
    void swap() { std::swap(current_, scratch_); }
    void rewind() {}

   private:
    Buffer<T> current_;
    Buffer<T> scratch_;
  };

  explicit CpuBackend(MemoryAccount& account) : account_(account) {}
  CpuBackend(const CpuBackend&) = delete;
  CpuBackend& operator=(const CpuBackend&) = delete;
  /// Waits for a detection that the caller did not wait for. Drops its result, or its failure.
  ~CpuBackend() noexcept {
    task_.cancel();
    try {
      task_.wait();
    } catch (...) {  // NOLINT(bugprone-empty-catch)
    }
  }

  template <class F>
  void for_each(const char* /*label*/, Count count, const F& f) {
    parallel::for_ranges(count.get(), kGrain, [&](std::uint64_t begin, std::uint64_t end) {
      cpu::for_range(f, static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end));
    });
  }

  /// Calls f(team) once.
  template <class F>
  void run_once(const char* /*label*/, const F& f) {
    SerialTeam team;
    f(team);
  }

  template <class F, class... Targets>
  void for_each_append(const char* /*label*/, Count count, const F& f, Appender<Targets>... lists) {
    parallel::for_ranges(count.get(), kGrain, [&](std::uint64_t begin, std::uint64_t end) {
      std::tuple<cpu::Output<Targets>...> outputs(lists...);
      std::apply(
          [&](auto&... output) {
            for (std::uint64_t i = begin; i < end; ++i) f(static_cast<std::uint32_t>(i), output...);
          },
          outputs);
    });
  }

  /// Calls f.begin(item, search, lists...). Unless that returns true, calls f.advance(search) until it does, and then
  /// f.finish(search, lists...).
  template <class F, class... Targets>
  void for_each_search(const char* label, Count count, const F& f, Appender<Targets>... lists) {
    const auto search_to_the_end = [&](std::uint32_t i, auto&... outputs) {
      typename F::Search search;  // NOLINT(cppcoreguidelines-pro-type-member-init): begin() sets what is needed
      if (f.begin(i, search, outputs...)) return;
      while (!f.advance(search)) {
      }
      f.finish(search, outputs...);
    };
    for_each_append(label, count, search_to_the_end, lists...);
  }

  /// Calls f(i, k, lists...) for every item i and k < its share of work; offsets[i] is the work of the items before.
  /// Distributes the work evenly, however unevenly the items have it.
  template <class F, class... Targets>
  void for_each_work(const char* /*label*/, Count items, const std::uint64_t* offsets, const std::uint64_t* total,
                     const F& f, Appender<Targets>... lists) {
    cpu::distribute<cpu::AllUnits<F>>(items, offsets, total, Share{0, 1}, kWorkGrain, f, lists...);
  }

  /// Does the same for a share of the work. Calls f.test(candidate, lists...) for each candidate that
  /// f.filter(f.load_item(i), k, candidate) lets through.
  template <class F, class... Targets>
  void for_each_work_filtered(const char* /*label*/, Count items, const std::uint64_t* offsets,
                              const std::uint64_t* total, Share share, const F& f, Appender<Targets>... lists) {
    cpu::distribute<cpu::FilteredUnits<F>>(items, offsets, total, share, kFilteredGrain, f, lists...);
  }

  /// Calls f(item, k, lists...) for every item = f.load_item(i) and k < item.part_count().
  template <class F, class... Targets>
  void for_each_part(const char* label, Count count, const F& f, Appender<Targets>... lists) {
    const auto all_parts = [&f](std::uint32_t i, auto&... outputs) {
      const typename F::Item item = f.load_item(i);
      const std::uint32_t parts = item.part_count();
      for (std::uint32_t part = 0; part < parts; ++part) f(item, part, outputs...);
    };
    for_each_append(label, count, all_parts, lists...);
  }

  /// Does the same, and calls f.test(candidate, lists...) for each candidate that f.filter(item, part, candidate) lets
  /// through.
  template <class F, class... Targets>
  void for_each_part_filtered(const char* /*label*/, Count count, const F& f, Appender<Targets>... lists) {
    parallel::for_ranges(count.get(), kGrain, [&](std::uint64_t begin, std::uint64_t end) {
      std::tuple<cpu::Output<Targets>...> outputs(lists...);
      cpu::GatheredUnits<F> gathered(f);
      std::apply(
          [&](auto&... output) {
            for (std::uint64_t i = begin; i < end; ++i) {
              const typename F::Item item = f.load_item(static_cast<std::uint32_t>(i));
              cpu::for_each_unit_that_may_pass(f, item, 0, item.part_count(),
                                               [&](std::uint32_t part) { gathered.offer(item, part, output...); });
            }
            gathered.test(output...);
          },
          outputs);
    });
  }

  /// Calls both, in any order: neither reads what the other appends to.
  template <class F, class G>
  void concurrently(const F& f, const G& g) {
    f();
    g();
  }

  void exclusive_scan(const char* /*label*/, Count count, const std::uint32_t* values, std::uint64_t* sums,
                      std::uint64_t* total) {
    const auto scan = [&](std::uint64_t begin, std::uint64_t end, std::uint64_t sum, bool is_final) {
      for (std::uint64_t i = begin; i < end; ++i) {
        if (is_final) sums[i] = sum;
        sum += values[i];
      }
      return sum;
    };
    *total = parallel::scan(count.get(), kScanGrain, scan);
  }

  template <class Key>
  void sort_keys(const char* /*label*/, Count count, SortBuffer<Key>& keys, int bits) {
    if (radix_sort_keys(keys.data(), keys.scratch(), count.get(), bits)) keys.swap();
  }

  template <class Key, class Value>
  void sort_pairs(const char* /*label*/, Count count, SortBuffer<Key>& keys, SortBuffer<Value>& values, int bits) {
    if (radix_sort_pairs(keys.data(), keys.scratch(), values.data(), values.scratch(), count.get(), bits)) {
      keys.swap();
      values.swap();
    }
  }

  template <class F>
  void histogram(const char* /*label*/, Count count, std::uint32_t* bins, int histograms, int bins_per_histogram,
                 const F& f) {
    const std::size_t size = static_cast<std::size_t>(histograms) * static_cast<std::size_t>(bins_per_histogram);
    std::fill(bins, bins + size, 0U);
    if (parallel::is_one_range(count.get(), kGrain)) {
      BinCounter counter{bins, bins_per_histogram};
      for (std::uint64_t i = 0; i < count.get(); ++i) f(static_cast<std::uint32_t>(i), counter);
      return;
    }
    parallel::PerThread<std::vector<std::uint32_t>> local([&] { return std::vector<std::uint32_t>(size, 0); });
    parallel::for_ranges(count.get(), kGrain, [&](std::uint64_t begin, std::uint64_t end) {
      BinCounter counter{local.local().data(), bins_per_histogram};
      for (std::uint64_t i = begin; i < end; ++i) f(static_cast<std::uint32_t>(i), counter);
    });
    for (const std::vector<std::uint32_t>& counts : local) {
      for (std::size_t bin = 0; bin < size; ++bin) bins[bin] += counts[bin];
    }
  }

  /// Lowers *least to the least f(i).
  template <class F>
  void minimum(const char* /*label*/, Count count, const F& f, float* least) {
    *least = parallel::reduce(
        count.get(), kGrain, *least,
        [&](std::uint64_t begin, std::uint64_t end, float value) {
          for (std::uint64_t i = begin; i < end; ++i) value = std::min(value, f(static_cast<std::uint32_t>(i)));
          return value;
        },
        [](float a, float b) { return std::min(a, b); });
  }

  template <class T>
  void upload(Buffer<T>& buffer, Span<const T> values) {
    if (!values.empty()) std::memcpy(buffer.data(), values.data(), values.size() * sizeof(T));
  }

  template <class F>
  void launch(const Signature& /*signature*/, F f) {
    task_.run(std::move(f));
  }

  /// Returns the counts so far.
  Counters read(const Buffer<Counters>& counters) const { return *counters.data(); }

  void download(const Buffer<Counters>& counters, const Buffer<Contact>& contacts, Count /*count*/, bool /*to_host*/) {
    counters_ = counters.data();
    contacts_ = contacts.data();
  }

  void* mark_end() { return nullptr; }
  Counters finish() {
    task_.wait();
    end_part();
    return *counters_;
  }

  Span<const Contact> contacts(std::uint64_t count) {
    times_.total = milliseconds(start_, Clock::now());
    return {contacts_, count};
  }

  void begin_detection(Session& /*session*/) {
    times_ = {};
    reruns_ = 0;
    start_ = part_start_ = Clock::now();
  }
  void begin(Stage stage) {
    end_part();
    stage_ = stage;
  }

  void count_rerun() { ++reruns_; }
  void give_scratch_back() {}
  std::uint64_t reruns() const { return reruns_; }
  const StageTimes& times() const { return times_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::uint64_t kGrain = 512;
  /// A child of a split triangle takes some 300 ns, and the filter of a pair a few.
  static constexpr std::uint64_t kWorkGrain = 64;
  static constexpr std::uint64_t kFilteredGrain = 4096;
  /// Additions are cheap, and most are made twice in parallel.
  static constexpr std::uint64_t kScanGrain = 1ULL << 15;

  struct BinCounter {
    std::uint32_t* bins;
    int bins_per_histogram;
    void count(int histogram, std::uint32_t bin) const {
      ++bins[static_cast<std::size_t>(histogram) * static_cast<std::size_t>(bins_per_histogram) + bin];
    }
  };

  static double milliseconds(Clock::time_point begin, Clock::time_point end) {
    return std::chrono::duration<double, std::milli>(end - begin).count();
  }

  void end_part() {
    const Clock::time_point now = Clock::now();
    stage_time(times_, stage_) += milliseconds(part_start_, now);
    part_start_ = now;
  }

  MemoryAccount& account_;
  parallel::Task task_;
  const Counters* counters_ = nullptr;
  const Contact* contacts_ = nullptr;
  Clock::time_point start_{};
  Clock::time_point part_start_{};
  Stage stage_ = Stage::transfer;
  StageTimes times_;
  std::uint64_t reruns_ = 0;
};

}  // namespace softcd
