#include <string>

#include "cuda_backend.cuh"
#include "occupancy.cuh"
#include "softcd/pipeline/detector_on.hpp"

namespace softcd {
namespace {

std::string find_problem() {
  int count = 0;
  const cudaError_t status = cudaGetDeviceCount(&count);
  cudaGetLastError();
  if (status != cudaSuccess) return std::string(cudaGetErrorString(status)) + " (is an NVIDIA driver installed?)";
  if (count == 0) return "there is no CUDA device";
  return {};
}

}  // namespace

std::unique_ptr<Detector> make_cuda_detector(void* stream) {
  return std::make_unique<DetectorOn<CudaBackend>>(static_cast<cudaStream_t>(stream));
}

const char* cuda_problem() {
  static const std::string problem = find_problem();
  return problem.c_str();
}

}  // namespace softcd
