#pragma once

#include <cooperative_groups.h>

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

constexpr int kTilesPerBlock = 4;
constexpr std::uint64_t kTileSize = kBlockSize * kTilesPerBlock;
constexpr int kStagedOffsets = 2048;

/// The paper's workload distribution (section 3.4, Fig. 10): one unit of work per thread. Each block finds the items of
/// its first and last unit by binary search in global memory, copies the offsets between into shared memory, and every
/// thread finds its item there. Blocks stride over tiles, since the total is known on the device only.
template <class F, class... Targets>
__global__ void for_each_work(Count items, const std::uint64_t* offsets, const std::uint64_t* total, F f,
                              Appender<Targets>... lists) {
  __shared__ std::uint64_t staged[kStagedOffsets];
  __shared__ std::uint64_t bounds[2];
  const std::uint64_t item_count = items.get();
  const std::uint64_t work = item_count == 0 ? 0 : *total;
  for (std::uint64_t tile = static_cast<std::uint64_t>(blockIdx.x) * kTileSize; tile < work;
       tile += gridDim.x * kTileSize) {
    const std::uint64_t tile_end = tile + kTileSize < work ? tile + kTileSize : work;
    if (threadIdx.x < 2) {
      bounds[threadIdx.x] = item_of(offsets, 0, item_count, threadIdx.x == 0 ? tile : tile_end - 1);
    }
    __syncthreads();
    const std::uint64_t first = bounds[0];
    const std::uint64_t size = bounds[1] + 1 - first;
    const bool is_staged = size <= kStagedOffsets;
    if (is_staged) {
      for (std::uint64_t i = threadIdx.x; i < size; i += kBlockSize) staged[i] = offsets[first + i];
    }
    __syncthreads();
    for (std::uint64_t at = tile + threadIdx.x; at < tile_end; at += kBlockSize) {
      const std::uint64_t* const known = is_staged ? staged : offsets + first;
      const std::uint64_t place = item_of(known, 0, size, at);
      const auto item = static_cast<std::uint32_t>(first + place);
      const auto part = static_cast<std::uint32_t>(at - known[place]);
      [&](Output<Targets>... outputs) { f(item, part, outputs...); }(Output<Targets>(lists)...);
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
