#include "lose_context.hpp"

#include <cuda_runtime.h>

namespace softcd::test {
namespace {

__global__ void stop_at_a_trap() {
  __trap();
}

}  // namespace

bool lose_cuda_context() {
  stop_at_a_trap<<<1, 1>>>();
  return cudaDeviceSynchronize() != cudaSuccess && cudaDeviceSynchronize() != cudaSuccess;
}

}  // namespace softcd::test
