#pragma once

#include "generic_kernels.cuh"
#include "softcd/pipeline/detector.hpp"

namespace softcd::cuda {

template <class T, class Out>
__device__ void place_run(const DevicePositions& run, const Vec3d& origin, Out* out) {
  const PlacePosition<T, Out> place{run.positions, origin, out + run.first};
  for (std::uint64_t i = threadIdx.x; i < run.count; i += kBlockSize) place(i);
}

/// Places positions, one block for each run of vertices. The host lists the runs.
template <class Out>
__global__ void __launch_bounds__(kBlockSize) place_positions(const DevicePositions* runs, Vec3d origin, Out* out) {
  const DevicePositions run = runs[blockIdx.x];
  if (run.positions.is_double) {
    place_run<double>(run, origin, out);
  } else {
    place_run<float>(run, origin, out);
  }
}

}  // namespace softcd::cuda
