#pragma once

#include <memory>
#include <vector>

#include "softcd/export.hpp"
#include "softcd/query.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Those of its scene and of its query.
struct PipelineOptions : SceneOptions, QueryOptions {
  friend bool operator==(const PipelineOptions& a, const PipelineOptions& b) {
    return static_cast<const SceneOptions&>(a) == static_cast<const SceneOptions&>(b) &&
           static_cast<const QueryOptions&>(a) == static_cast<const QueryOptions&>(b);
  }
  friend bool operator!=(const PipelineOptions& a, const PipelineOptions& b) { return !(a == b); }
};

/// Detects contacts between the bodies that it holds. One thread at a time per object; several objects may be
/// used from several threads. The same input gives the same bytes, whatever the number of threads or backend, and
/// however often it is detected. A pipeline that was moved from throws Error from every function until another one is
/// assigned to it.
class SOFTCD_EXPORT CollisionPipeline {
 public:
  /// `log` as set_log(). The GPU's work is done on the CUDA device that is current now. Throws BackendError when
  /// options.backend cannot be had, InvalidInput when an option is out of range.
  explicit CollisionPipeline(const PipelineOptions& options = {}, LogCallback log = {});
  /// A detection that still runs is ended. So it is in a pipeline that another one is assigned to.
  ~CollisionPipeline();
  CollisionPipeline(CollisionPipeline&&) noexcept;
  CollisionPipeline& operator=(CollisionPipeline&&) noexcept;

  /// Throws InvalidInput naming the triangle, or segment, and the index when one is out of range; nothing is added
  /// then.
  BodyId add_body(const BodyDesc& desc);
  /// New topology, vertex count and settings for a body, whose positions have to be set again. Throws as add_body; the
  /// body is unchanged then.
  void update_body(BodyId body, const BodyDesc& desc);
  /// Where only some triangles change: see Scene.
  void update_body(BodyId body, const BodyDesc& desc, Span<const std::uint32_t> changed);
  /// Throws InvalidInput when there is no such body or a setting is out of range.
  void set_settings(BodyId body, const BodySettings& settings);
  /// Throws InvalidInput when there is no such body.
  void remove_body(BodyId body);
  /// Whether the body was added and not removed.
  bool has_body(BodyId body) const;

  /// Where the body's vertices are, at t1 only: it does not move during the step.
  void set_positions(BodyId body, Positions x);
  /// Where the body's vertices are at both ends of the step. Throws InvalidInput when a count is not the
  /// body's, a pointer is null, a stride is shorter than a position, or one end is float and the other double.
  void set_positions(BodyId body, Positions x_t0, Positions x_t1);

  /// As Scene::set_ignored_pairs().
  void set_ignored_pairs(Span<const BodyPair> pairs);
  /// As Scene::set_vertex_filters().
  void set_vertex_filters(BodyId body, Span<const VertexFilter> filters);
  /// As Scene::set_rest_positions().
  void set_rest_positions(BodyId body, Positions x);

  /// A detection that runs is ended, and its contacts are lost. With another backend or stream a GPU's work is done on
  /// the CUDA device that is current now. Throws as the constructor does.
  void set_options(const PipelineOptions& options);
  /// What was set last.
  const PipelineOptions& options() const;

  /// Asked by every detection from the next one on, but not about a body and itself; none lets all pairs through. It
  /// must not call the pipeline.
  void set_pair_filter(PairFilter filter);
  /// Told warnings and what else may be of interest from now on; none is told nothing. It must not call the pipeline.
  void set_log(LogCallback log);

  /// All contacts, sorted by (kind, body_a, feature_a, body_b, feature_b), each once. Valid until the next detect(),
  /// detect_async() or set_options(). A body without positions is left out, and so is a triangle with a vertex that is
  /// not finite, which statistics() counts; warnings name both.
  Span<const Contact> detect();

  /// The same in two halves: positions are read and the work is started, then waited for. All other functions may be
  /// called in between and concern the next detection, but for these: detect_async() and detect() wait for the
  /// detection that runs and drop its contacts first, set_options() ends it. wait() throws Error when none runs.
  void detect_async();
  /// The second half of detect_async().
  Span<const Contact> wait();

  /// The backend of the last detection, before the first one the expected: never `automatic`. With `automatic` small
  /// scenes go to the CPU even where there is a GPU, and a GPU that fails, or whose memory does not suffice, is
  /// replaced by the CPU in the same call, with one warning. With `cuda` that is a BackendError, or OutOfMemory.
  Backend backend() const;
  /// Of the last detection whose contacts were returned.
  const Statistics& statistics() const;
  /// Which stages that detection ran or left out, and why.
  std::vector<StageReport> explain() const;

 private:
  class Implementation;
  Implementation& implementation() const;

  std::unique_ptr<Implementation> implementation_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
