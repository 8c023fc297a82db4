#pragma once

#include <utility>

#include "softcd/query.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// The options of a scene and of its query.
struct PipelineOptions : SceneOptions, QueryOptions {
  friend bool operator==(const PipelineOptions& a, const PipelineOptions& b) {
    return static_cast<const SceneOptions&>(a) == static_cast<const SceneOptions&>(b) &&
           static_cast<const QueryOptions&>(a) == static_cast<const QueryOptions&>(b);
  }
  friend bool operator!=(const PipelineOptions& a, const PipelineOptions& b) { return !(a == b); }
};

/// A scene with one query, for programs that need no more:
///
///     CollisionPipeline pipeline;
///     const BodyId cloth = pipeline.scene.add_body({triangles, vertex_count});
///     pipeline.scene.set_positions(cloth, x);
///     for (const Contact& contact : pipeline.detect()) ...
class CollisionPipeline {
 public:
  /// Throws the exceptions of Scene's and Query's constructors.
  explicit CollisionPipeline(const PipelineOptions& options = {}, LogCallback log = {})
      : scene(options, std::move(log)), query(scene, options) {}

  /// Sets the options of both. Ends a detection that the caller has not waited for. Throws the exceptions of
  /// Scene::set_options() and Query::set_options(); all options then stay as they were.
  void set_options(const PipelineOptions& options) {
    const QueryOptions before = query.options();
    query.set_options(options);
    try {
      scene.set_options(options);
    } catch (...) {
      query.set_options(before);
      throw;
    }
  }

  /// Returns the options that were set last.
  PipelineOptions options() const { return {scene.options(), query.options()}; }

  /// Finds all contacts, see Query::detect().
  Span<const Contact> detect() { return query.detect(); }

  Scene scene;  ///< the bodies, and the choice of the backend
  Query query;  ///< the scene's only query: pair filters, running detections, statistics
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
