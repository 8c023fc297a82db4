#include "softcd/pipeline/detector.hpp"

namespace softcd {

DetectorFactory cuda_detector_factory(int /*device*/, void* /*stream*/) {
  return {};
}

DevicePositionReaderFactory cuda_position_reader_factory(int /*device*/) {
  return {};
}

void* allocate_shared_memory(std::uint64_t /*bytes*/) {
  return nullptr;
}

void free_shared_memory(void* /*memory*/) {}

const char* cuda_problem() {
  return "this build of softcd has no CUDA backend (it was configured without one, or found no nvcc); "
         "rebuild with SOFTCD_CUDA=ON";
}

}  // namespace softcd
