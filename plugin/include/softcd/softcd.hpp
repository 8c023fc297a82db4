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
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "softcd/core/contact.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/core/types.hpp"

namespace softcd {

/// Every exception that softcd throws; those of a pair filter or a log callback pass through as they are. The text
/// names the problem, its cause and the remedy. A call that throws leaves the pipeline as it was, and usable.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The caller's data cannot be used: an index out of range, arrays of unequal length, an option out
/// of its range.
class InvalidInput : public Error {
 public:
  using Error::Error;
};

/// Backend::cuda was asked for and cannot be had: not built in, no device, or the device failed.
class BackendError : public Error {
 public:
  using Error::Error;
};

/// A mesh, its positions or a detection would need more memory than there is.
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
/// `count` positions of three consecutive floats or doubles, `stride` bytes apart, aligned as their coordinates are.
/// The memory is read by the next detect() or detect_async(), before that call returns or throws, and never afterwards:
/// a body whose positions are not set again stays where it was, to the last digit of what was given.
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
  /// A temporary container would be gone before it is read. Containers hand on their constness to their elements,
  /// views do not.
  template <class Container,
            class = std::enable_if_t<!std::is_same_v<decltype(std::declval<Container&>().data()),
                                                     decltype(std::declval<const Container&>().data())>>>
  Positions(const Container&& positions) = delete;

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
/// Called on the thread that calls the pipeline, by any function that is not const.
using LogCallback = std::function<void(LogLevel, std::string_view)>;

/// Called for pairs of bodies that pass groups, masks and bounding boxes; false leaves the pair out of this
/// detection. Called by detect() and detect_async() on the calling thread, in ascending order of ids, a < b.
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
  /// Most bytes of the backend's memory that the pipeline may hold at once, lists that grow counted twice while they
  /// are copied; 0 for no limit. From the next detection on: what an earlier one holds beyond a lower limit is given
  /// back. Where the bytes do not suffice for all pairs of triangles at once the pairs are tested in parts, with the
  /// same contacts; where they do not suffice for the triangles, their grid entries or the contacts, detect() throws
  /// OutOfMemory. Not counted: the bodies' meshes and last positions, which are kept on the host.
  std::uint64_t memory_limit = 0;
  /// A cudaStream_t that the GPU's work is enqueued on, which must live as long as the pipeline; null for a stream of
  /// the pipeline's own. No other work may be captured on it.
  void* cuda_stream = nullptr;

  friend bool operator==(const PipelineOptions& a, const PipelineOptions& b) {
    const auto values = [](const PipelineOptions& o) {
      return std::tie(o.backend, o.detection, o.accuracy, o.broad_phase, o.subdivision, o.lambda, o.motion_margin,
                      o.contact_rule, o.memory_limit, o.cuda_stream);
    };
    return values(a) == values(b);
  }
  friend bool operator!=(const PipelineOptions& a, const PipelineOptions& b) { return !(a == b); }
};

/// Detects contacts between the bodies that it holds. One thread at a time per object; several objects may be
/// used from several threads. The same input gives the same bytes, whatever the number of threads or backend, and
/// however often it is detected. A pipeline that was moved from throws Error from every function until another one is
/// assigned to it.
class CollisionPipeline {
 public:
  /// `log` as set_log(). The GPU's work is done on the CUDA device that is current now. Throws BackendError when
  /// options.backend cannot be had, InvalidInput when an option is out of range.
  explicit CollisionPipeline(const PipelineOptions& options = {}, LogCallback log = {});
  /// A detection that still runs is ended. So it is in a pipeline that another one is assigned to.
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

  /// A detection that runs is ended, and its contacts are lost. With another backend or stream a GPU's work is done on
  /// the CUDA device that is current now. Throws as the constructor does.
  void set_options(const PipelineOptions& options);
  const PipelineOptions& options() const;

  /// Asked by every detection from the next one on; none lets all pairs through. It must not call the pipeline.
  void set_pair_filter(PairFilter filter);
  /// Told warnings and what else may be of interest from now on; none is told nothing. It must not call the pipeline.
  void set_log(LogCallback log);

  /// All contacts, sorted by (kind, body_a, feature_a, body_b, feature_b), each once. Valid until the next detect(),
  /// detect_async() or set_options(). Bodies whose positions were never set are left out, as explain() says. A triangle
  /// with a vertex that is not finite is left out, counted in statistics() and named in a warning.
  Span<const Contact> detect();

  /// The same in two halves: positions are read and the work is started, then waited for. All other functions may be
  /// called in between and concern the next detection, but for these: detect_async() and detect() wait for the
  /// detection that runs and drop its contacts first, set_options() ends it. wait() throws Error when none runs.
  void detect_async();
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

}  // namespace softcd
