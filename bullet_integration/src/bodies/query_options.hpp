#pragma once

#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

inline SceneOptions scene_options(const Settings& settings) {
  SceneOptions options;
  options.backend = settings.backend;
  return options;
}

/// Whether softcd finds contacts of soft bodies with rigid objects of any kind.
inline bool finds_rigid_contacts(const Settings& settings) {
  return settings.rigid_meshes || settings.convex_shapes != ConvexShapes::nodes;
}

/// What all queries of a world have in common: how precisely they compute, and that edges are what few ask for.
inline QueryOptions query_options(const Settings& settings) {
  QueryOptions options;
  options.accuracy = settings.accuracy;
  options.broad_phase = settings.broad_phase;
  options.lambda = settings.lambda;
  options.reuse_pairs = settings.reuse_pairs;
  options.features.edge_edge = settings.edge_contacts != EdgeContacts::off;
  return options;
}

/// For queries that look at the way of a step, whatever Settings::detection is.
inline QueryOptions continuous_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.detection = Detection::ccd;
  return options;
}

/// Whether the query's next detection may be left out where there is nothing to look for: its statistics say so
/// already.
inline bool has_looked_at_nothing(const Query& query) {
  return query.statistics().bodies == 0;
}

}  // namespace softcd::bullet
