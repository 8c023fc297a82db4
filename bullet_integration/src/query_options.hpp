#pragma once

#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

inline SceneOptions scene_options(const Settings& settings) {
  SceneOptions options;
  options.backend = settings.backend;
  return options;
}

/// What all queries of a world have in common: how precisely they compute.
inline QueryOptions query_options(const Settings& settings) {
  QueryOptions options;
  options.accuracy = settings.accuracy;
  options.broad_phase = settings.broad_phase;
  options.lambda = settings.lambda;
  options.reuse_pairs = settings.reuse_pairs;
  return options;
}

/// For queries that look at the way of a step, whatever Settings::detection is.
inline QueryOptions continuous_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.detection = Detection::ccd;
  return options;
}

}  // namespace softcd::bullet
