#pragma once

#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

inline SceneOptions scene_options(const Settings& settings) {
  SceneOptions options;
  options.backend = settings.backend;
  return options;
}

/// Returns whether softcd detects contacts of soft bodies with any kind of rigid objects.
inline bool finds_rigid_contacts(const Settings& settings) {
  return settings.rigid_meshes || settings.convex_shapes != ConvexShapes::nodes;
}

/// Returns the options that all queries of a world share: the accuracy, and contacts of edges only if EdgeContacts asks
/// for them.
inline QueryOptions query_options(const Settings& settings) {
  QueryOptions options;
  options.accuracy = settings.accuracy;
  options.broad_phase = settings.broad_phase;
  options.cell_size_factor = settings.cell_size_factor;
  options.reuse_pairs = settings.reuse_pairs;
  options.features.edge_edge = settings.edge_contacts != EdgeContacts::off;
  return options;
}

/// Returns the options of queries that are continuous whatever Settings::detection is.
inline QueryOptions continuous_options(const Settings& settings) {
  QueryOptions options = query_options(settings);
  options.detection = Detection::ccd;
  return options;
}

/// Returns whether the query's last detection had no bodies. A next one without bodies can be skipped, as the
/// statistics already say so.
inline bool had_no_bodies(const Query& query) {
  return query.statistics().bodies == 0;
}

}  // namespace softcd::bullet
