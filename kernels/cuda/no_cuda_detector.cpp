#include "softcd/pipeline/detector.hpp"

namespace softcd {

std::unique_ptr<Detector> make_cuda_detector(void* /*stream*/) {
  return nullptr;
}

const char* cuda_problem() {
  return "this build of softcd has no CUDA backend (no nvcc was found when it was configured); rebuild with "
         "SOFTCD_CUDA=ON";
}

}  // namespace softcd
