#include "cpu_backend.hpp"
#include "softcd/pipeline/detector_on.hpp"

namespace softcd {

std::unique_ptr<Detector> make_cpu_detector() {
  return std::make_unique<DetectorOn<CpuBackend>>();
}

}  // namespace softcd
