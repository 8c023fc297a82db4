#pragma once

#include "softcd/pipeline/detector.hpp"

namespace softcd::paper {

/// For detectors on the CUDA device that is current when they are made and used, as softcd::cuda_detector_factory.
DetectorFactory cuda_detector_factory(void* stream);

}  // namespace softcd::paper
