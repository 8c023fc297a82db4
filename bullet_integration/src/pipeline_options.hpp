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
  options.log = settings.log;
  return options;
}

}  // namespace softcd::bullet
