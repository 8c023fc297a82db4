#pragma once

#include "selected_detector.hpp"

namespace softcd::paper {

/// Returns factories of detectors with the printed broad phase (paper/scheme.hpp), otherwise as machine_factories does.
/// On CUDA they use the current device.
DetectorFactories detector_factories(const SceneOptions& options);

}  // namespace softcd::paper
