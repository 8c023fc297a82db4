#pragma once

#include <cooperative_groups.h>
#include <cooperative_groups/scan.h>
#include <cub/block/block_scan.cuh>

#include <tuple>

#include "softcd/core/count.hpp"
#include "softcd/pipeline/output.hpp"
#include "softcd/pipeline/workspace.hpp"

/// One kernel for each primitive; the stage is its functor.
namespace softcd::cuda {

constexpr int kBlockSize = 256;

/// Appends to a list from many threads. The active threads of a warp reserve places together.
template <class Target>
class Output {
 public:
  SOFTCD_HD explicit Output(const Appender<Target>& list) : list_(list) {}

  SOFTCD_HD void push([[maybe_unused]] const typename Target::Value& value) {
#if defined(__CUDA_ARCH__)
    const auto active = cooperative_groups::coalesced_threads();
    unsigned long long at = 0;
    if (active.thread_rank() == 0) {
      at =
          atomicAdd(reinterpret_cast<unsigned long long*>(list_.count), static_cast<unsigned long long>(active.size()));
    }
    at = active.shfl(at, 0) + active.thread_rank();
    if (at < list_.capacity) list_.target.store(at, value);
#endif
  }

  /// Reserved places for `count` values of this thread, written one after the other.
  class Room {
   public:
    SOFTCD_HD Room(const Appender<Target>& list, std::uint64_t at) : list_(list), at_(at) {}
    /// Returns the first place, before any value is put.
    SOFTCD_HD std::uint64_t begin() const { return at_; }
    SOFTCD_HD void put(const typename Target::Value& value) {
      if (at_ < list_.capacity) list_.target.store(at_, value);
      ++at_;
    }

   private:
    const Appender<Target>& list_;
    std::uint64_t at_;
  };
  SOFTCD_HD Room allocate([[maybe_unused]] std::uint32_t count) const {
    unsigned long long at = 0;
#if defined(__CUDA_ARCH__)
    const auto active = cooperative_groups::coalesced_threads();
    const std::uint32_t before = cooperative_groups::exclusive_scan(active, count);
    const unsigned last = active.size() - 1;
    if (active.thread_rank() == last) {
      at = atomicAdd(reinterpret_cast<unsigned long long*>(list_.count),
                     static_cast<unsigned long long>(before + count));
    }
    at = active.shfl(at, last) + before;
#endif
    return Room(list_, at);
  }

 private:
  Appender<Target> list_;
};

/// Memory in which the first kernel of one or more parts of a detection notes the time when they begin. An event
/// between two kernels would take 2.5 us of a graph on an H100.
struct Marks {
  std::uint64_t* times;  ///< in nanoseconds
  std::uint32_t count;

  static __device__ std::uint64_t now() {
    std::uint64_t time = 0;
    asm volatile("mov.u64 %0, %globaltimer;" : "=l"(time));
    return time;
  }
  /// Begins a kernel: waits for the one before it, and notes the time. Every kernel calls it before it reads or writes.
  __device__ void begin() const {
#if __CUDA_ARCH__ >= 900
    cudaGridDependencySynchronize();
#endif
    if (count == 0 || blockIdx.x != 0 || threadIdx.x != 0) return;
    const std::uint64_t time = now();
    for (std::uint32_t i = 0; i < count; ++i) times[i] = time;
  }
};

__device__ inline std::uint64_t global_thread() {
  return static_cast<std::uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
}
__device__ inline std::uint64_t grid_threads() {
  return static_cast<std::uint64_t>(gridDim.x) * blockDim.x;
}

template <class F>
__global__ void for_each(Marks marks, Count count, F f) {
  marks.begin();
  const std::uint64_t n = count.get();
  for (std::uint64_t i = global_thread(); i < n; i += grid_threads()) f(static_cast<std::uint32_t>(i));
}

/// Minimum number of resident blocks of a functor's kernel per multiprocessor. It bounds the registers of kernels that
/// need many.
template <class F>
constexpr int kResidentBlocks = 1;

template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize, kResidentBlocks<F>)
    for_each_append(Marks marks, Count count, F f, Appender<Targets>... lists) {
  marks.begin();
  const std::uint64_t n = count.get();
  for (std::uint64_t i = global_thread(); i < n; i += grid_threads()) {
    std::uint32_t item = static_cast<std::uint32_t>(i);
    [&](Output<Targets>... outputs) { f(item, outputs...); }(Output<Targets>(lists)...);
  }
}

constexpr unsigned kWarpSize = 32;
constexpr unsigned kWholeWarp = 0xFFFFFFFFU;

/// The number of idle threads of a warp that triggers the start of new searches.
constexpr int kIdleThreads = 4;

/// Runs searches, which take different numbers of steps. A thread that finishes begins another search while its warp's
/// other threads continue.
template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize, kResidentBlocks<F>)
    for_each_search(Marks marks, Count count, F f, Appender<Targets>... lists) {
  marks.begin();
  const std::uint64_t n = count.get();
  const unsigned lane = threadIdx.x % kWarpSize;
  // A warp's items: rows of 32 consecutive items; the warps take rows in turn.
  std::uint64_t row = global_thread() - lane;
  unsigned begun = 0;  // number of the row's items that threads have taken
  bool is_searching = false;
  typename F::Search search;
  [&](Output<Targets>... outputs) {
    while (true) {
      const unsigned idle = __ballot_sync(kWholeWarp, !is_searching);
      const int idle_count = __popc(idle);
      if (row < n && idle_count >= kIdleThreads) {
        const unsigned place = begun + static_cast<unsigned>(__popc(idle & ((1U << lane) - 1U)));
        const bool begins = !is_searching && place < kWarpSize && row + place < n;
        if (begins) is_searching = !f.begin(static_cast<std::uint32_t>(row + place), search, outputs...);
        begun += static_cast<unsigned>(idle_count);
        if (begun >= kWarpSize) {
          row += grid_threads();
          begun = 0;
        }
      } else if (idle == kWholeWarp) {
        return;
      }
      if (is_searching && f.advance(search)) {
        f.finish(search, outputs...);
        is_searching = false;
      }
    }
  }(Output<Targets>(lists)...);
}

/// Returns the last item whose offset is at most `at`, found by all threads of a warp together. It must exist.
__device__ inline std::uint32_t item_of(const std::uint64_t* offsets, std::uint32_t item_count, std::uint64_t at) {
  const std::uint32_t lane = threadIdx.x % kWarpSize;
  std::uint32_t begin = 0;
  std::uint32_t end = item_count;
  while (end - begin > 1) {
    const std::uint32_t step = (end - begin - 1) / kWarpSize + 1;
    const std::uint64_t probe = begin + static_cast<std::uint64_t>(step) * lane;
    const unsigned low = __ballot_sync(kWholeWarp, probe < end && offsets[probe] <= at);
    begin += step * (kWarpSize - 1U - static_cast<unsigned>(__clz(static_cast<int>(low))));
    end = min(end, begin + step);
  }
  return begin;
}

/// The number of units that a warp distributes at a time.
constexpr std::uint32_t kTileSize = 256;

/// The number of times 32 units that a warp takes at least, where units are so cheap that they are not worth a search
/// by each warp of a device.
constexpr std::uint64_t kStepsOfCheapUnits = 4;

/// For each unit of a warp's tile where an item begins: the item's place after the tile's first item; else 0.
struct TileStorage {
  std::uint32_t places[kBlockSize / kWarpSize][kTileSize];
};

/// The paper's workload distribution (section 3.4, Fig. 10): one unit of work per thread. Each warp takes a run of
/// units, tile by tile. It finds the item of its first unit by search in the prefix sums.
///
/// No further search is needed. Every item marks its first unit in shared memory. Each unit finds the last mark up to
/// itself among its warp's votes. Calls body(is_inside, item, part) for all threads of the warp together.
template <class Body>
__device__ void for_each_unit(TileStorage& storage, Count items, const std::uint64_t* offsets,
                              const std::uint64_t* total, Share share, std::uint64_t least_steps, const Body& body) {
  constexpr std::uint32_t kWarps = kBlockSize / kWarpSize;
  const std::uint32_t lane = threadIdx.x % kWarpSize;
  std::uint32_t* const places = storage.places[threadIdx.x / kWarpSize];
  const auto item_count = static_cast<std::uint32_t>(items.get());
  const std::uint64_t work = item_count == 0 ? 0 : *total;
  const std::uint64_t share_begin = share.begin(work);
  const std::uint64_t share_end = share.end(work);
  const std::uint64_t steps = (share_end - share_begin + kWarpSize - 1) / kWarpSize;
  const std::uint64_t warp = static_cast<std::uint64_t>(blockIdx.x) * kWarps + threadIdx.x / kWarpSize;
  const std::uint64_t warps = min(static_cast<std::uint64_t>(gridDim.x) * kWarps, steps / least_steps + 1);
  if (warp >= warps) return;
  const std::uint64_t begin = share_begin + steps * warp / warps * kWarpSize;
  const std::uint64_t steps_end = share_begin + steps * (warp + 1) / warps * kWarpSize;
  const std::uint64_t end = steps_end < share_end ? steps_end : share_end;
  if (begin >= end) return;

  std::uint32_t first = item_of(offsets, item_count, begin);
  for (std::uint64_t tile = begin; tile < end; tile += kTileSize) {
    const auto unit_count = static_cast<std::uint32_t>(end - tile < kTileSize ? end - tile : kTileSize);
    const auto done_of_first = static_cast<std::uint32_t>(tile - offsets[first]);
    for (std::uint32_t base = 0; base < unit_count; base += kWarpSize) places[base + lane] = 0;
    __syncwarp();
    bool may_follow = true;
    for (std::uint32_t place = 1 + lane; __all_sync(kWholeWarp, may_follow); place += kWarpSize) {
      const std::uint64_t item = static_cast<std::uint64_t>(first) + place;
      const std::uint64_t item_begin = item < item_count ? offsets[item] : work;
      const std::uint64_t item_end = item + 1 < item_count ? offsets[item + 1] : work;
      may_follow = item_begin < tile + unit_count;
      if (may_follow && item_begin < item_end) places[item_begin - tile] = place;
    }
    __syncwarp();
    std::uint32_t last_place = 0;  // of the item that the last unit so far belongs to
    std::uint32_t last_start = 0;  // the unit that it begins with
    for (std::uint32_t base = 0; base < unit_count; base += kWarpSize) {
      const std::uint32_t place = places[base + lane];
      const unsigned starts = __ballot_sync(kWholeWarp, place != 0);
      const unsigned starts_so_far = starts & (kWholeWarp >> (kWarpSize - 1U - lane));
      const unsigned start = kWarpSize - 1U - static_cast<unsigned>(__clz(static_cast<int>(starts_so_far)));
      const std::uint32_t start_place = __shfl_sync(kWholeWarp, place, static_cast<int>(start));
      const std::uint32_t own_place = starts_so_far != 0 ? start_place : last_place;
      const std::uint32_t own_start = starts_so_far != 0 ? base + start : last_start;
      const std::uint32_t unit = base + lane;
      body(unit < unit_count, first + own_place, unit - own_start + (own_place == 0 ? done_of_first : 0U));
      last_place = __shfl_sync(kWholeWarp, own_place, kWarpSize - 1);
      last_start = __shfl_sync(kWholeWarp, own_start, kWarpSize - 1);
    }
    first += last_place;
    __syncwarp();
  }
}

template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize)
    for_each_work(Marks marks, Count items, const std::uint64_t* offsets, const std::uint64_t* total, F f,
                  Appender<Targets>... lists) {
  marks.begin();
  __shared__ TileStorage storage;
  for_each_unit(storage, items, offsets, total, {0, 1}, 1, [&](bool is_inside, std::uint32_t item, std::uint32_t part) {
    if (is_inside) [&](Output<Targets>... outputs) { f(item, part, outputs...); }(Output<Targets>(lists)...);
  });
}

/// A warp's candidates that passed the filter, gathered until there is one for each thread. The expensive test then
/// runs without idle lanes. Each thread knows the number of queued candidates.
template <class Candidate>
class WarpQueue {
 public:
  template <class Test>
  __device__ void add(bool passes, const Candidate& candidate, unsigned& queued, const Test& test) {
    const unsigned lane = threadIdx.x % kWarpSize;
    const unsigned ballot = __ballot_sync(kWholeWarp, passes);
    if (passes) values_[queued + __popc(ballot & ((1U << lane) - 1U))] = candidate;
    queued += __popc(ballot);
    __syncwarp();
    if (queued < kWarpSize) return;
    queued -= kWarpSize;
    test(values_[queued + lane]);
    __syncwarp();
  }

  template <class Test>
  __device__ void finish(unsigned queued, const Test& test) {
    const unsigned lane = threadIdx.x % kWarpSize;
    if (lane < queued) test(values_[lane]);
  }

 private:
  Candidate values_[2 * kWarpSize];
};

template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize, kResidentBlocks<F>)
    for_each_work_filtered(Marks marks, Count items, const std::uint64_t* offsets, const std::uint64_t* total,
                           Share share, F f, Appender<Targets>... lists) {
  marks.begin();
  __shared__ TileStorage storage;
  __shared__ WarpQueue<typename F::Candidate> queues[kBlockSize / kWarpSize];
  const auto test = [&](const typename F::Candidate& candidate) {
    [&](Output<Targets>... outputs) { f.test(candidate, outputs...); }(Output<Targets>(lists)...);
  };
  unsigned queued = 0;
  for_each_unit(storage, items, offsets, total, share, kStepsOfCheapUnits,
                [&](bool is_inside, std::uint32_t item, std::uint32_t part) {
                  typename F::Candidate candidate;
                  const bool passes = is_inside && f.filter(f.load_item(item), part, candidate);
                  queues[threadIdx.x / kWarpSize].add(passes, candidate, queued, test);
                });
  queues[threadIdx.x / kWarpSize].finish(queued, test);
}

/// The number of items whose parts a block distributes at a time. It is low where some items have very many parts.
template <class F>
constexpr std::uint32_t kItemsAtOnce = kBlockSize;

template <class F>
struct PartStorage {
  static constexpr std::uint32_t kPartsAtOnce = 10 * kBlockSize;
  static_assert(kItemsAtOnce<F> <= 256);

  std::uint32_t starts[kBlockSize];
  typename F::Item items[kItemsAtOnce<F>];
  std::uint8_t owners[kPartsAtOnce];
  typename cub::BlockScan<std::uint32_t, kBlockSize>::TempStorage scan;
};

/// Distributes the parts of items over a block. Each thread marks its item's parts as its own. The block then shares
/// out the parts of all its items evenly, some thousand at a time. Calls body(is_inside, item, part) for all threads of
/// the block together.
template <class F, class Body>
__device__ void for_each_part_of_items(PartStorage<F>& storage, Count count, const F& f, const Body& body) {
  constexpr std::uint32_t kPartsAtOnce = PartStorage<F>::kPartsAtOnce;
  const std::uint64_t n = count.get();
  for (std::uint64_t group = static_cast<std::uint64_t>(blockIdx.x) * kItemsAtOnce<F>; group < n;
       group += static_cast<std::uint64_t>(gridDim.x) * kItemsAtOnce<F>) {
    const std::uint64_t own_item = group + threadIdx.x;
    std::uint32_t own = 0;
    if (threadIdx.x < kItemsAtOnce<F> && own_item < n) {
      const typename F::Item item = f.load_item(static_cast<std::uint32_t>(own_item));
      own = item.part_count();
      storage.items[threadIdx.x] = item;
    }
    std::uint32_t start = 0;
    std::uint32_t parts = 0;
    cub::BlockScan<std::uint32_t, kBlockSize>(storage.scan).ExclusiveSum(own, start, parts);
    storage.starts[threadIdx.x] = start;
    for (std::uint32_t first = 0; first < parts; first += kPartsAtOnce) {
      const std::uint32_t end = min(first + kPartsAtOnce, parts);
      for (std::uint32_t part = max(start, first); part < min(start + own, end); ++part)
        storage.owners[part - first] = static_cast<std::uint8_t>(threadIdx.x);
      __syncthreads();
      for (std::uint32_t base = first; base < end; base += kBlockSize) {
        const std::uint32_t part = base + threadIdx.x;
        const bool is_inside = part < end;
        const std::uint32_t item = is_inside ? storage.owners[part - first] : 0U;
        body(is_inside, storage.items[item], part - storage.starts[item]);
      }
      __syncthreads();
    }
  }
}

template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize) for_each_part(Marks marks, Count count, F f, Appender<Targets>... lists) {
  marks.begin();
  __shared__ PartStorage<F> storage;
  for_each_part_of_items(storage, count, f, [&](bool is_inside, const typename F::Item& item, std::uint32_t part) {
    if (is_inside) [&](Output<Targets>... outputs) { f(item, part, outputs...); }(Output<Targets>(lists)...);
  });
}

template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize, kResidentBlocks<F>)
    for_each_part_filtered(Marks marks, Count count, F f, Appender<Targets>... lists) {
  marks.begin();
  __shared__ PartStorage<F> storage;
  __shared__ WarpQueue<typename F::Candidate> queues[kBlockSize / kWarpSize];
  const auto test = [&](const typename F::Candidate& candidate) {
    [&](Output<Targets>... outputs) { f.test(candidate, outputs...); }(Output<Targets>(lists)...);
  };
  unsigned queued = 0;
  for_each_part_of_items(storage, count, f, [&](bool is_inside, const typename F::Item& item, std::uint32_t part) {
    typename F::Candidate candidate;
    const bool passes = is_inside && f.filter(item, part, candidate);
    queues[threadIdx.x / kWarpSize].add(passes, candidate, queued, test);
  });
  queues[threadIdx.x / kWarpSize].finish(queued, test);
}

struct BinCounter {
  std::uint32_t* bins;
  int bins_per_histogram;

  SOFTCD_HD void count([[maybe_unused]] int histogram, [[maybe_unused]] std::uint32_t bin) const {
#if defined(__CUDA_ARCH__)
    atomicAdd(bins + histogram * bins_per_histogram + bin, 1U);
#endif
  }
};

/// Counts in shared-memory bins, and adds them to the global bins at the end. `bins` must be 0 before.
template <class F>
__global__ void histogram(Marks marks, Count count, std::uint32_t* bins, int histograms, int bins_per_histogram, F f) {
  marks.begin();
  extern __shared__ std::uint32_t local_bins[];
  const int size = histograms * bins_per_histogram;
  for (int bin = static_cast<int>(threadIdx.x); bin < size; bin += kBlockSize) local_bins[bin] = 0;
  __syncthreads();
  BinCounter counter{local_bins, bins_per_histogram};
  const std::uint64_t n = count.get();
  for (std::uint64_t i = global_thread(); i < n; i += grid_threads()) f(static_cast<std::uint32_t>(i), counter);
  __syncthreads();
  for (int bin = static_cast<int>(threadIdx.x); bin < size; bin += kBlockSize) {
    if (local_bins[bin] != 0) atomicAdd(bins + bin, local_bins[bin]);
  }
}

/// Lowers *least to the least f(i). As integers, the bits of non-negative floats keep their order. As unsigned
/// integers, the bits of negative floats have the opposite order, and are above those of all others.
template <class F>
__global__ void minimum(Marks marks, Count count, F f, float* least) {
  marks.begin();
  const std::uint64_t n = count.get();
  float lowest = __int_as_float(0x7F800000);
  for (std::uint64_t i = global_thread(); i < n; i += grid_threads())
    lowest = fminf(lowest, f(static_cast<std::uint32_t>(i)));
  for (int offset = 16; offset > 0; offset /= 2) lowest = fminf(lowest, __shfl_xor_sync(kWholeWarp, lowest, offset));
  if (threadIdx.x % 32 != 0) return;
  if (__float_as_int(lowest) >= 0) {
    atomicMin(reinterpret_cast<int*>(least), __float_as_int(lowest));
  } else {
    atomicMax(reinterpret_cast<unsigned*>(least), __float_as_uint(lowest));
  }
}

/// Sets the keys behind the last item to the highest key, so that a sort of the whole capacity leaves them at the end.
template <class Key>
__global__ void fill_tail(Marks marks, Count count, Key* keys) {
  marks.begin();
  for (std::uint64_t i = count.get() + global_thread(); i < count.capacity; i += grid_threads())
    keys[i] = static_cast<Key>(~Key{0});
}

/// Results of every detection that the host reads.
struct Results {
  const Counters* counters;
  Counters* host_counters;
  const std::uint64_t* times;  ///< see Marks
  std::uint64_t* host_times;   ///< one more: the end
  std::uint32_t time_count;
  std::uint32_t* done_blocks;  ///< 0 between kernels
};

__device__ inline void copy_words(const void* from, void* to, std::uint64_t bytes, std::uint64_t first,
                                  std::uint64_t step) {
  const auto* source = static_cast<const std::uint32_t*>(from);
  auto* target = static_cast<std::uint32_t*>(to);
  for (std::uint64_t i = first; i < bytes / sizeof(std::uint32_t); i += step) target[i] = source[i];
}

/// Ends a detection: copies its counters and times, and the existing items of a list, to page-locked host memory. The
/// host thus need not know their number first.
template <class T>
__global__ void hand_out(Marks marks, Results results, Count count, const T* from, T* to) {
  static_assert(sizeof(T) % sizeof(std::uint32_t) == 0 && sizeof(Counters) % sizeof(std::uint32_t) == 0);
  marks.begin();
  if (blockIdx.x == 0) {
    __syncthreads();
    copy_words(results.counters, results.host_counters, sizeof(Counters), threadIdx.x, blockDim.x);
    copy_words(results.times, results.host_times, results.time_count * sizeof(std::uint64_t), threadIdx.x, blockDim.x);
  }
  copy_words(from, to, count.get() * sizeof(T), global_thread(), grid_threads());
  __syncthreads();
  if (threadIdx.x != 0) return;
  const bool is_last = atomicInc(results.done_blocks, gridDim.x - 1) == gridDim.x - 1;
  if (is_last) results.host_times[results.time_count] = Marks::now();
}

/// The memory of scans. It holds zeros between kernels.
struct ScanState {
  unsigned long long* tiles;  ///< value:62 | state:2 of each tile, see sum_before()
  unsigned* done_blocks;
};

constexpr unsigned kScanItems = 4;  ///< of a thread
constexpr std::uint64_t kScanTile = kScanItems * kBlockSize;

/// Returns the sum of all tiles before `tile`, found by the threads of a warp together. A tile's word holds the tile's
/// sum (state 1), then the sum up to its end (state 2).
__device__ inline std::uint64_t sum_before(const unsigned long long* tiles, std::uint64_t tile) {
  const std::uint64_t lane = threadIdx.x % kWarpSize;
  std::uint64_t sum = 0;
  for (std::uint64_t end = tile; end > 0; end -= min(end, std::uint64_t{kWarpSize})) {
    unsigned long long word = 2;  // before the first tile
    if (lane < end) {
      const volatile unsigned long long* const at = tiles + (end - 1 - lane);
      do {
        word = *at;
      } while (word == 0);
    }
    const unsigned up_to_end = __ballot_sync(kWholeWarp, (word & 3U) == 2U);
    const unsigned last =
        up_to_end == 0 ? kWarpSize - 1U : static_cast<unsigned>(__ffs(static_cast<int>(up_to_end))) - 1U;
    std::uint64_t own = lane <= last ? word >> 2 : 0;
    for (int offset = kWarpSize / 2; offset > 0; offset /= 2) own += __shfl_xor_sync(kWholeWarp, own, offset);
    sum += own;
    if (up_to_end != 0) break;
  }
  return sum;
}

/// Writes exclusive sums of the values, and the sum of all, in one kernel: each tile of values waits for the sums
/// before it (decoupled look-back; Merrill and Garland 2016).
static __global__ void __launch_bounds__(kBlockSize) scan(Marks marks, Count count, const std::uint32_t* values,
                                                          std::uint64_t* sums, std::uint64_t* total, ScanState state) {
  using BlockScan = cub::BlockScan<std::uint64_t, kBlockSize>;
  __shared__ typename BlockScan::TempStorage storage;
  __shared__ bool is_last_block;
  __shared__ std::uint64_t shared_sum;
  marks.begin();
  const std::uint64_t n = count.get();
  const std::uint64_t tile_count = n / kScanTile + 1;  // one at least, which writes the total
  for (std::uint64_t tile = blockIdx.x; tile < tile_count; tile += gridDim.x) {
    const std::uint64_t first = tile * kScanTile + threadIdx.x * kScanItems;
    std::uint64_t own[kScanItems];
    for (unsigned k = 0; k < kScanItems; ++k) own[k] = first + k < n ? values[first + k] : 0;
    std::uint64_t tile_sum = 0;
    BlockScan(storage).ExclusiveSum(own, own, tile_sum);
    if (threadIdx.x < kWarpSize) {
      if (tile > 0 && threadIdx.x == 0) atomicExch(state.tiles + tile, (tile_sum << 2) | 1U);
      const std::uint64_t before = sum_before(state.tiles, tile);
      if (threadIdx.x == 0) {
        atomicExch(state.tiles + tile, ((before + tile_sum) << 2) | 2U);
        shared_sum = before;
        if (tile + 1 == tile_count) *total = before + tile_sum;
      }
    }
    __syncthreads();
    for (unsigned k = 0; k < kScanItems; ++k) {
      if (first + k < n) sums[first + k] = shared_sum + own[k];
    }
    __syncthreads();
  }
  if (threadIdx.x == 0) is_last_block = atomicInc(state.done_blocks, gridDim.x - 1) == gridDim.x - 1;
  __syncthreads();
  if (!is_last_block) return;
  for (std::uint64_t tile = threadIdx.x; tile < tile_count; tile += kBlockSize) state.tiles[tile] = 0;
}

}  // namespace softcd::cuda
