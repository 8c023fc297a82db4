#include "paper/cuda_detector.hpp"

namespace softcd::paper {

DetectorFactory cuda_detector_factory(void* /*stream*/) {
  return {};
}

}  // namespace softcd::paper
