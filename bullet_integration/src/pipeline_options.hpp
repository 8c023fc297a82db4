#pragma once

#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// What all detectors of a world have in common: where and how precisely they compute.
inline PipelineOptions pipeline_options(const Settings& settings) {
  PipelineOptions options;
  options.backend = settings.backend;
  options.accuracy = settings.accuracy;
  options.broad_phase = settings.broad_phase;
  options.lambda = settings.lambda;
  return options;
}

/// For detectors that look at the way of a step, whatever Settings::detection is.
inline PipelineOptions continuous_options(const Settings& settings) {
  PipelineOptions options = pipeline_options(settings);
  options.detection = Detection::ccd;
  return options;
}

}  // namespace softcd::bullet
