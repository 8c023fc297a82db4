#pragma once

#include "selected_detector.hpp"

namespace softcd::paper {

/// As machine_factories, of detectors whose broad phase is the printed one (paper/scheme.hpp). On CUDA they use the
/// device that is current.
DetectorFactories detector_factories(const SceneOptions& options);

}  // namespace softcd::paper
