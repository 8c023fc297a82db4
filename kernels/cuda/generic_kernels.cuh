#pragma once

#include <cooperative_groups.h>
#include <cooperative_groups/scan.h>
#include <cub/block/block_scan.cuh>

#include <tuple>

#include "softcd/core/count.hpp"
#include "softcd/pipeline/output.hpp"

/// One kernel per primitive: the stage is the functor.
namespace softcd::cuda {

constexpr int kBlockSize = 256;

/// Appends to a list from many threads: the active threads of a warp take room together.
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

  /// Room for `count` values of this thread, put one after the other; the warp's active threads take room together.
  class Room {
   public:
    SOFTCD_HD Room(const Appender<Target>& list, std::uint64_t at) : list_(list), at_(at) {}
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

__device__ inline std::uint64_t global_thread() {
  return static_cast<std::uint64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
}
__device__ inline std::uint64_t grid_threads() {
  return static_cast<std::uint64_t>(gridDim.x) * blockDim.x;
}

template <class F>
__global__ void for_each(Count count, F f) {
  const std::uint64_t n = count.get();
  for (std::uint64_t i = global_thread(); i < n; i += grid_threads()) f(static_cast<std::uint32_t>(i));
}

template <class F, class... Targets>
__global__ void for_each_append(Count count, F f, Appender<Targets>... lists) {
  const std::uint64_t n = count.get();
  for (std::uint64_t i = global_thread(); i < n; i += grid_threads()) {
    std::uint32_t item = static_cast<std::uint32_t>(i);
    [&](Output<Targets>... outputs) { f(item, outputs...); }(Output<Targets>(lists)...);
  }
}

/// Last item whose offset is at most `at`, in [begin, end).
__device__ inline std::uint64_t item_of(const std::uint64_t* offsets, std::uint64_t begin, std::uint64_t end,
                                        std::uint64_t at) {
  while (end - begin > 1) {
    const std::uint64_t middle = begin + (end - begin) / 2;
    if (offsets[middle] <= at) {
      begin = middle;
    } else {
      end = middle;
    }
  }
  return begin;
}

constexpr int kTestsPerThread = 4;
constexpr int kTileSize = kBlockSize * kTestsPerThread;
using ScanOfStarts = cub::BlockScan<std::uint32_t, kBlockSize>;

struct TileStorage {
  std::uint64_t bounds[2];
  std::uint32_t
      starts[kTileSize];  ///< per unit of the tile: 1 + the item that begins there; then, the item it belongs to
  typename ScanOfStarts::TempStorage scan;
};

struct LargerOf {
  __device__ std::uint32_t operator()(std::uint32_t a, std::uint32_t b) const { return a < b ? b : a; }
};

/// The paper's workload distribution (section 3.4, Fig. 10): one unit of work per thread. The items of a tile's first
/// and last unit are found by binary search in the prefix sums in global memory. Instead of one more search per thread,
/// each item between marks the unit that it begins with in shared memory, and a running maximum tells every unit its
/// item. Calls body(is_inside, item, part) for all threads of the block together. Blocks stride over tiles, since the
/// total is known on the device only.
template <class Body>
__device__ void for_each_unit(TileStorage& storage, Count items, const std::uint64_t* offsets,
                              const std::uint64_t* total, const Body& body) {
  const std::uint64_t item_count = items.get();
  const std::uint64_t work = item_count == 0 ? 0 : *total;
  for (std::uint64_t tile = static_cast<std::uint64_t>(blockIdx.x) * kTileSize; tile < work;
       tile += static_cast<std::uint64_t>(gridDim.x) * kTileSize) {
    const std::uint64_t tile_end = tile + kTileSize < work ? tile + kTileSize : work;
    if (threadIdx.x < 2)
      storage.bounds[threadIdx.x] = item_of(offsets, 0, item_count, threadIdx.x == 0 ? tile : tile_end - 1);
    for (int unit = static_cast<int>(threadIdx.x); unit < kTileSize; unit += kBlockSize) storage.starts[unit] = 0;
    __syncthreads();
    const std::uint64_t first = storage.bounds[0];
    const auto last = static_cast<std::uint32_t>(storage.bounds[1] - first);
    for (std::uint32_t i = 1 + threadIdx.x; i <= last; i += kBlockSize) {
      atomicMax(&storage.starts[offsets[first + i] - tile], i);
    }
    __syncthreads();
    std::uint32_t own[kTestsPerThread];
    for (int k = 0; k < kTestsPerThread; ++k) own[k] = storage.starts[threadIdx.x * kTestsPerThread + k];
    ScanOfStarts(storage.scan).InclusiveScan(own, own, LargerOf{});
    for (int k = 0; k < kTestsPerThread; ++k) storage.starts[threadIdx.x * kTestsPerThread + k] = own[k];
    __syncthreads();
    for (int k = 0; k < kTestsPerThread; ++k) {
      const std::uint32_t unit = threadIdx.x + static_cast<std::uint32_t>(k) * kBlockSize;
      const bool is_inside = tile + unit < tile_end;
      const std::uint64_t item = first + storage.starts[unit];
      const std::uint64_t begin = is_inside ? offsets[item] : 0;
      body(is_inside, static_cast<std::uint32_t>(item), static_cast<std::uint32_t>(tile + unit - begin));
    }
    __syncthreads();
  }
}

template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize)
    for_each_work(Count items, const std::uint64_t* offsets, const std::uint64_t* total, F f,
                  Appender<Targets>... lists) {
  __shared__ TileStorage storage;
  for_each_unit(storage, items, offsets, total, [&](bool is_inside, std::uint32_t item, std::uint32_t part) {
    if (is_inside) [&](Output<Targets>... outputs) { f(item, part, outputs...); }(Output<Targets>(lists)...);
  });
}

constexpr int kWarpSize = 32;

/// A warp's candidates that passed the filter, gathered until there is one for each thread: the expensive test then
/// runs without idle lanes.
template <class Candidate>
struct WarpQueue {
  Candidate values[2 * kWarpSize];
};

template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize)
    for_each_work_filtered(Count items, const std::uint64_t* offsets, const std::uint64_t* total, F f,
                           Appender<Targets>... lists) {
  __shared__ TileStorage storage;
  __shared__ WarpQueue<typename F::Candidate> queues[kBlockSize / kWarpSize];
  WarpQueue<typename F::Candidate>& queue = queues[threadIdx.x / kWarpSize];
  const unsigned lane = threadIdx.x % kWarpSize;
  unsigned queued = 0;
  const auto test = [&](const typename F::Candidate& candidate) {
    [&](Output<Targets>... outputs) { f.test(candidate, outputs...); }(Output<Targets>(lists)...);
  };
  for_each_unit(storage, items, offsets, total, [&](bool is_inside, std::uint32_t item, std::uint32_t part) {
    typename F::Candidate candidate;
    const bool passes = is_inside && f.filter(f.load_item(item), part, candidate);
    const unsigned ballot = __ballot_sync(0xFFFFFFFFU, passes);
    if (passes) queue.values[queued + __popc(ballot & ((1U << lane) - 1U))] = candidate;
    queued += __popc(ballot);
    __syncwarp();
    if (queued < kWarpSize) return;
    queued -= kWarpSize;
    test(queue.values[queued + lane]);
    __syncwarp();
  });
  if (lane < queued) test(queue.values[lane]);
}

/// Parts of few-part items, distributed over a block: each thread counts one item's parts, and the parts of all 256 are
/// shared out evenly.
template <class F, class... Targets>
__global__ void __launch_bounds__(kBlockSize) for_each_part(Count count, F f, Appender<Targets>... lists) {
  __shared__ std::uint32_t starts[kBlockSize];
  __shared__ typename F::Item items[kBlockSize];
  __shared__ typename ScanOfStarts::TempStorage scan;
  const std::uint64_t n = count.get();
  for (std::uint64_t block = static_cast<std::uint64_t>(blockIdx.x) * kBlockSize; block < n;
       block += static_cast<std::uint64_t>(gridDim.x) * kBlockSize) {
    const std::uint64_t own_item = block + threadIdx.x;
    std::uint32_t own = 0;
    if (own_item < n) {
      const typename F::Item item = f.load_item(static_cast<std::uint32_t>(own_item));
      own = item.part_count();
      items[threadIdx.x] = item;
    }
    std::uint32_t start = 0;
    std::uint32_t parts = 0;
    ScanOfStarts(scan).ExclusiveSum(own, start, parts);
    starts[threadIdx.x] = start;
    __syncthreads();
    for (std::uint32_t part = threadIdx.x; part < parts; part += kBlockSize) {
      std::uint32_t item = 0;
      for (std::uint32_t step = kBlockSize / 2; step > 0; step /= 2) {
        if (starts[item + step] <= part) item += step;
      }
      [&](Output<Targets>... outputs) { f(items[item], part - starts[item], outputs...); }(Output<Targets>(lists)...);
    }
    __syncthreads();
  }
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

/// Bins in shared memory, added to the global ones at the end; `bins` must be 0 before.
template <class F>
__global__ void histogram(Count count, std::uint32_t* bins, int histograms, int bins_per_histogram, F f) {
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

/// Lowers *least to the least f(i); values and *least must not be negative, whose order is that of their bits.
template <class F>
__global__ void minimum(Count count, F f, float* least) {
  const std::uint64_t n = count.get();
  unsigned lowest = 0x7F800000U;
  for (std::uint64_t i = global_thread(); i < n; i += grid_threads())
    lowest = min(lowest, __float_as_uint(f(static_cast<std::uint32_t>(i))));
  for (int offset = 16; offset > 0; offset /= 2) lowest = min(lowest, __shfl_xor_sync(0xFFFFFFFFU, lowest, offset));
  if (threadIdx.x % 32 == 0) atomicMin(reinterpret_cast<unsigned*>(least), lowest);
}

/// Sets the items behind the last one to the highest key, so that a sort of the whole capacity leaves them behind.
template <class Key>
__global__ void fill_tail(Count count, Key* keys) {
  for (std::uint64_t i = count.get() + global_thread(); i < count.capacity; i += grid_threads())
    keys[i] = static_cast<Key>(~Key{0});
}

/// Copies the items that exist to page-locked host memory, in 4-byte words, so that nobody has to know their number
/// first.
template <class T>
__global__ void copy_out(Count count, const T* from, T* to) {
  static_assert(sizeof(T) % sizeof(std::uint32_t) == 0);
  const std::uint64_t words = count.get() * (sizeof(T) / sizeof(std::uint32_t));
  const auto* source = reinterpret_cast<const std::uint32_t*>(from);
  auto* target = reinterpret_cast<std::uint32_t*>(to);
  for (std::uint64_t i = global_thread(); i < words; i += grid_threads()) target[i] = source[i];
}

/// Sums see zeros behind the last item.
struct ValueOrZero {
  Count count;
  const std::uint32_t* values;
  SOFTCD_HD std::uint64_t operator()(std::uint64_t i) const { return i < count.get() ? values[i] : 0; }
};

/// total = sum of all values, given their exclusive sums.
static __global__ void last_sum(Count count, const std::uint32_t* values, const std::uint64_t* sums,
                                std::uint64_t* total) {
  const std::uint64_t n = count.get();
  *total = n == 0 ? 0 : sums[n - 1] + values[n - 1];
}

}  // namespace softcd::cuda
