#pragma once

#include "softcd/pipeline/detector.hpp"

namespace softcd::paper {

/// Returns a factory of detectors on the current CUDA device, as softcd::cuda_detector_factory does.
DetectorFactory cuda_detector_factory(void* stream);

}  // namespace softcd::paper
