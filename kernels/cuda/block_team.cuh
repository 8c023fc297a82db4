#pragma once

#include <cub/block/block_reduce.cuh>
#include <cub/block/block_scan.cuh>

#include <climits>
#include <cstdint>

#include "generic_kernels.cuh"
#include "softcd/core/host_device.hpp"

namespace softcd::cuda {

constexpr int kTeamSize = 256;

/// A block of kTeamSize threads as a team; see core/team.hpp.
class BlockTeam {
 public:
  struct Storage {
    union {
      typename cub::BlockReduce<std::uint64_t, kTeamSize>::TempStorage reduce;
      typename cub::BlockScan<std::uint64_t, kTeamSize>::TempStorage scan;
    };
    std::uint64_t answer;
    int first, end;
  };

  SOFTCD_HD explicit BlockTeam(Storage& storage) : storage_(storage) {}

  SOFTCD_HD bool is_leader() const {
#if defined(__CUDA_ARCH__)
    return threadIdx.x == 0;
#else
    return false;
#endif
  }

  /// Skips the values before the first and behind the last that is not 0. Most sums then take one round of the block.
  template <class F>
  SOFTCD_HD void skip_zeros([[maybe_unused]] int count, [[maybe_unused]] const F& is_any) {
#if defined(__CUDA_ARCH__)
    if (threadIdx.x == 0) {
      storage_.first = count;
      storage_.end = 0;
    }
    __syncthreads();
    for (int i = static_cast<int>(threadIdx.x); i < count; i += kTeamSize) {
      if (!is_any(i)) continue;
      atomicMin(&storage_.first, i);
      atomicMax(&storage_.end, i + 1);
    }
    __syncthreads();
    first_ = storage_.first;
    end_ = storage_.end;
    __syncthreads();
#endif
  }

  template <class F>
  SOFTCD_HD std::uint64_t sum([[maybe_unused]] int count, [[maybe_unused]] const F& f) {
#if defined(__CUDA_ARCH__)
    std::uint64_t own = 0;
    for (int i = first_ + static_cast<int>(threadIdx.x); i < min(count, end_); i += kTeamSize) own += f(i);
    const std::uint64_t total = cub::BlockReduce<std::uint64_t, kTeamSize>(storage_.reduce).Sum(own);
    if (threadIdx.x == 0) storage_.answer = total;
    __syncthreads();
    const std::uint64_t answer = storage_.answer;
    __syncthreads();
    return answer;
#else
    return 0;
#endif
  }

  template <class F>
  SOFTCD_HD int first_exceeding([[maybe_unused]] int count, [[maybe_unused]] std::uint64_t threshold,
                                [[maybe_unused]] const F& f) {
#if defined(__CUDA_ARCH__)
    if (threadIdx.x == 0) storage_.first = count - 1;
    __syncthreads();
    std::uint64_t before = 0;
    for (int begin = first_; begin < min(count, end_); begin += kTeamSize) {
      const int i = begin + static_cast<int>(threadIdx.x);
      const std::uint64_t own = i < min(count, end_) ? f(i) : 0;
      std::uint64_t up_to = 0;
      std::uint64_t total = 0;
      cub::BlockScan<std::uint64_t, kTeamSize>(storage_.scan).InclusiveSum(own, up_to, total);
      if (before + up_to > threshold && before + up_to - own <= threshold) storage_.first = i;
      before += total;
      __syncthreads();
    }
    const int answer = storage_.first;
    __syncthreads();
    return answer;
#else
    return 0;
#endif
  }

 private:
  Storage& storage_;
  int first_ = 0;
  int end_ = INT_MAX;
};

template <class F>
__global__ void __launch_bounds__(kTeamSize) run_once(Marks marks, F f) {
  marks.begin();
  __shared__ BlockTeam::Storage storage;
  BlockTeam team(storage);
  f(team);
}

}  // namespace softcd::cuda
