#include "softcd/pipeline/detector.hpp"

namespace softcd {

DetectorFactory cuda_detector_factory(void* /*stream*/) {
  return {};
}

const char* cuda_problem() {
  return "this build of softcd has no CUDA backend (no nvcc was found when it was configured); rebuild with "
         "SOFTCD_CUDA=ON";
}

}  // namespace softcd
