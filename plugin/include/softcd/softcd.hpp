#pragma once

/// softcd: collision detection between deformable triangle meshes. This header is the whole public
/// interface; it needs neither CUDA nor Bullet and is valid C++17.
///
/// Positions in, contacts out:
///
///     softcd::CollisionPipeline pipeline;
///     const softcd::BodyId cloth = pipeline.add_body({triangles, vertex_count});
///     pipeline.set_positions(cloth, positions);
///     for (const softcd::Contact& contact : pipeline.detect()) { ... }

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "softcd/core/contact.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/core/types.hpp"

namespace softcd {

/// Every exception that softcd throws. The text names the problem, its cause and the remedy.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller's data cannot be used: an index out of range, arrays of unequal length, an option out
/// of its range. The pipeline is unchanged.
class InvalidInput : public Error {
 public:
  using Error::Error;
};

/// The requested backend cannot be had: not built in, no device, or the device failed.
class BackendError : public Error {
 public:
  using Error::Error;
};

/// A detection would need more memory than there is.
class OutOfMemory : public Error {
 public:
  using Error::Error;
};

/// Which feature pairs a body takes part in. A kind is tested between two bodies when both want it.
struct Features {
  bool vertex_triangle = true;
  bool edge_edge = false;
};

/// What may change from one detection to the next without a change of topology.
struct BodySettings {
  /// Two features are in contact when their distance is at most the sum of their bodies' margins.
  /// Unit: the positions'. Finite, at least 0.
  float margin = 0.0F;
  /// Bodies a and b are compared when (a.filter_group & b.filter_mask) and (b.filter_group & a.filter_mask).
  std::uint32_t filter_group = 1;
  std::uint32_t filter_mask = 0xFFFFFFFFu;
  /// Also find contacts between features of this body that share no vertex, whatever its group and mask.
  bool self_collision = false;
  /// Moved by somebody else (static or animated): two such bodies are never compared, nor is one with itself.
  bool kinematic = false;
  Features features;
};

/// A mesh: triangles over vertices 0 .. vertex_count - 1. A vertex in no triangle does not collide;
/// give it a triangle {v, v, v} when it should.
struct BodyDesc {
  Span<const Triangle> triangles;  ///< read during the call
  std::uint32_t vertex_count = 0;
  BodySettings settings;
};

/// Positions become float32 relative to the scene's origin, which moves along only where the whole scene is far away:
/// float positions stay as they are, double positions keep about 7 digits of the scene's extent, stray vertices
/// included. With Accuracy::conservative a body's margin grows by the most that this moves one of its vertices by, so
/// that no contact of the double positions is lost: by at most 6e-8 of its furthest vertex's distance from the scene's
/// origin, and by nothing where all of them are floats. A vertex with a coordinate beyond 1e37 counts as not finite.
///
/// `count` positions of three consecutive floats or doubles, `stride` bytes apart. The memory is read by
/// the next detect() or detect_async(), before that call returns, and never afterwards: a body whose positions are not
/// set again stays where it was.
class Positions {
 public:
  Positions() = default;
  Positions(Span<const Vec3f> positions)  // NOLINT(google-explicit-constructor)
      : Positions(positions.data() == nullptr ? nullptr : &positions.data()->x, positions.size(), sizeof(Vec3f)) {}
  Positions(Span<const Vec3d> positions)  // NOLINT(google-explicit-constructor)
      : Positions(positions.data() == nullptr ? nullptr : &positions.data()->x, positions.size(), sizeof(Vec3d)) {}
  Positions(const std::vector<Vec3f>& positions)  // NOLINT(google-explicit-constructor)
      : Positions(Span<const Vec3f>(positions)) {}
  Positions(const std::vector<Vec3d>& positions)  // NOLINT(google-explicit-constructor)
      : Positions(Span<const Vec3d>(positions)) {}
  Positions(const float* first_x, std::size_t count, std::size_t stride)
      : data_(first_x), count_(count), stride_(stride), is_double_(false) {}
  Positions(const double* first_x, std::size_t count, std::size_t stride)
      : data_(first_x), count_(count), stride_(stride), is_double_(true) {}

  const void* data() const { return data_; }
  std::size_t count() const { return count_; }
  std::size_t stride() const { return stride_; }
  bool is_double() const { return is_double_; }

 private:
  const void* data_ = nullptr;
  std::size_t count_ = 0;
  std::size_t stride_ = 0;
  bool is_double_ = false;
};

/// One line of explain().
struct StageReport {
  std::string stage;
  bool ran = false;
  std::string reason;
};

enum class LogLevel : std::uint32_t { information, warning };
using LogCallback = std::function<void(LogLevel, std::string_view)>;

/// Called for pairs of bodies that pass groups, masks and bounding boxes; false leaves the pair out of this
/// detection. Called on the thread that calls detect(), in ascending order of ids, a < b.
using PairFilter = std::function<bool(BodyId a, BodyId b)>;

struct PipelineOptions {
  Backend backend = Backend::automatic;
  Detection detection = Detection::dcd;
  Accuracy accuracy = Accuracy::precise;
  BroadPhase broad_phase = BroadPhase::exact;
  /// Off: no triangle is split. `exact` then registers large triangles in every cell of their own volume, `paper`
  /// makes its cells fit the largest triangle. Changes the number of tests only, not the contacts of `exact`.
  bool subdivision = true;
  /// Cell size in units of the triangles' clipped mean bounding radius: cell = lambda * mean for `exact`
  /// (useful 1.2 to 2.4; allowed 0.1 to 100), cell = 3 * lambda * mean for `paper` (equation 1; 1.1 to 1.3). 0 chooses
  /// 1.8, and more where triangles move many cells or have large margins, and 1.2.
  float lambda = 0.0F;
  /// Discrete detection only: a vertex's margin against triangles of other bodies grows by this many times the distance
  /// that it moves from t0 to t1 (Bullet's classic soft bodies use 2). At least 0.
  float motion_margin = 0.0F;
  ContactRule contact_rule = ContactRule::distance;
  /// Most bytes of the backend's memory that the detection may use, statistics().peak_bytes; 0 for no limit. Where they
  /// do not suffice for all pairs of triangles at once the pairs are tested in parts, with the same contacts; where
  /// they do not suffice for the triangles, their grid entries or the contacts, detect() throws OutOfMemory.
  std::uint64_t memory_limit = 0;
  /// A cudaStream_t that the GPU's work is enqueued on, which must live as long as the pipeline; null for a stream of
  /// the pipeline's own. No other work may be captured on it.
  void* cuda_stream = nullptr;
  PairFilter pair_filter;
  LogCallback log;
};

/// Detects contacts between the bodies that it holds. One thread at a time per object; several objects may be
/// used from several threads. The same input gives the same bytes, whatever the number of threads or backend.
class CollisionPipeline {
 public:
  /// Throws BackendError when options.backend cannot be had, InvalidInput when an option is out of range.
  explicit CollisionPipeline(PipelineOptions options = {});
  ~CollisionPipeline();
  CollisionPipeline(CollisionPipeline&&) noexcept;
  CollisionPipeline& operator=(CollisionPipeline&&) noexcept;

  /// Throws InvalidInput naming the triangle and the index when one is out of range; nothing is added then.
  BodyId add_body(const BodyDesc& desc);
  /// New topology, vertex count and settings for a body, whose positions have to be set again. Throws as add_body; the
  /// body is unchanged then.
  void update_body(BodyId body, const BodyDesc& desc);
  void set_settings(BodyId body, const BodySettings& settings);
  void remove_body(BodyId body);

  /// Where the body's vertices are, at t1 only: it does not move during the step.
  void set_positions(BodyId body, Positions x);
  /// Where the body's vertices are at both ends of the step. Throws InvalidInput when a count is not the
  /// body's, a pointer is null, a stride is shorter than a position, or one end is float and the other double.
  void set_positions(BodyId body, Positions x_t0, Positions x_t1);

  void set_options(const PipelineOptions& options);
  const PipelineOptions& options() const;

  /// All contacts, sorted by (kind, body_a, feature_a, body_b, feature_b), each once. Valid until the next call
  /// that is not const. Bodies whose positions were never set are left out. A triangle with a vertex that is
  /// not finite is left out, counted in statistics() and named in a warning.
  Span<const Contact> detect();

  /// The same in two halves: positions are read and the work is started, then waited for.
  void detect_async();
  Span<const Contact> wait();

  /// The backend of the last detection, before the first one the expected: never `automatic`. With `automatic` small
  /// scenes go to the CPU even where there is a GPU. A GPU that fails, or whose memory does not suffice, is replaced by
  /// the CPU in the same call, with one warning.
  Backend backend() const;
  const Statistics& statistics() const;
  /// Which stages the last detection ran or left out, and why.
  std::vector<StageReport> explain() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace softcd
