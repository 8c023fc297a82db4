#include "paper/cuda_detector.hpp"

#include "cuda_backend.cuh"
#include "occupancy.cuh"
#include "paper/scheme.hpp"
#include "softcd/pipeline/detector_on.hpp"

namespace softcd::paper {

DetectorFactory cuda_detector_factory(void* stream) {
  return [stream] { return std::make_unique<DetectorOn<CudaBackend, Scheme>>(static_cast<cudaStream_t>(stream)); };
}

}  // namespace softcd::paper
