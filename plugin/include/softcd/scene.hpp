#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

#include "softcd/communicator.hpp"
#include "softcd/core/contact.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/core/types.hpp"
#include "softcd/export.hpp"
#include "softcd/positions.hpp"
#include "softcd/version.hpp"

namespace softcd {

namespace detail {
class SceneCore;
}

inline namespace SOFTCD_VERSION_NAMESPACE {

/// Which feature pairs a body takes part in. A kind is tested between two bodies when both want it.
struct Features {
  bool vertex_triangle = true;  ///< vertices against triangles
  bool edge_edge = true;        ///< edges against edges
};

/// What may change from one detection to the next without a change of topology.
struct BodySettings {
  /// Two features are in contact when their distance is at most the sum of their bodies' margins.
  /// Unit: the positions'. Finite, at least 0.
  float margin = 0.0F;
  /// Bodies a and b are compared when (a.filter_group & b.filter_mask) and (b.filter_group & a.filter_mask).
  std::uint32_t filter_group = 1;
  std::uint32_t filter_mask = 0xFFFFFFFFu;  ///< see filter_group
  /// Also find contacts between features of this body that share no vertex, whatever its group and mask.
  bool self_collision = true;
  /// Moved by somebody else (static or animated): two such bodies are never compared, nor is one with itself.
  bool kinematic = false;
  Features features;  ///< which pairs of features it takes part in
  /// Bodies of different batches never touch, wherever they are: many small scenes in one, which are detected together.
  std::uint32_t batch = 0;
  /// Features of this body that a path of fewer edges than this joins are no contact: with 1 those that share a vertex;
  /// with 2 also those with vertices that an edge joins, and so on. 1 to 16. More than 1 takes memory for what is near
  /// each vertex: 24 bytes in a regular mesh with 2, 72 with 3, growing with the square.
  std::uint32_t neighbour_rings = 1;
  /// Features of this body that are at most so far apart where Scene::set_rest_positions() says are no contact. Unit:
  /// the positions'. Finite, at least 0, which excludes none. With self_collision a detection throws InvalidInput
  /// unless rest positions were set.
  float rest_distance = 0.0F;
};

/// Two bodies, in either order, or a body and itself.
struct BodyPair {
  BodyId a;  ///< the one
  BodyId b;  ///< and the other
};

/// A mesh: triangles and segments over vertices 0 .. vertex_count - 1. A vertex in none of them does not collide;
/// give it a triangle {v, v, v} when it should.
struct BodyDesc {
  Span<const Triangle> triangles;  ///< read during the call
  std::uint32_t vertex_count = 0;  ///< as many positions are set
  BodySettings settings{};         ///< which set_settings() changes later
  /// With SceneOptions::communicator: the only rank that sets the body's positions, which all others are given by the
  /// next detection that is started; where that throws they have to be set again. -1: every rank sets them, the same
  /// everywhere.
  std::int32_t rank = -1;
  /// Ropes and hair: what collides without being a triangle's side, read during the call. A segment's vertices touch
  /// triangles; its edge touches edges, of triangles and of other segments, with Features::edge_edge: by that alone
  /// segments touch each other, and by that vertices touch segments, as ends of edges (a triangle {v, v, v} has no edge
  /// and does not). Segments that share a vertex do not touch. Given twice, or as a side of a triangle, a segment is
  /// there once. See Contact for how their edges are numbered. Where triangles are counted, or named by a Probe,
  /// segment i is triangle triangles.size() + i, {v[0], v[1], v[1]}.
  Span<const Segment> segments{};
};

/// How much a line of the log matters.
enum class LogLevel : std::uint32_t { information, warning };
/// Called on the thread that calls a scene or its queries, by any function that is not const.
using LogCallback = std::function<void(LogLevel, std::string_view)>;

/// Where the detections on a scene run, and with how much memory.
struct SceneOptions {
  Backend backend = Backend::automatic;  ///< where detections are computed
  /// Most bytes of the backend's memory that the scene may hold at once, lists that grow counted twice while they
  /// are copied; 0 for no limit. From the next detection on: what an earlier one holds beyond a lower limit is given
  /// back. Where the bytes do not suffice for all pairs of triangles at once the pairs are tested in parts, with the
  /// same contacts; where they do not suffice for the triangles, their grid entries or the contacts, starting a
  /// detection or waiting for it throws OutOfMemory. Not counted: the bodies' meshes and positions on the host.
  std::uint64_t memory_limit = 0;
  /// Most threads that work on detections on the CPU, the calling one included; 0 for as many as there are processors.
  std::uint32_t max_threads = 0;
  /// The CUDA device, as cudaGetDeviceCount counts them; -1 for the calling thread's current one at construction.
  std::int32_t cuda_device = -1;
  /// A cudaStream_t that the GPU's work is enqueued on, which must live as long as the scene; null for a stream of
  /// the scene's own. No other work may be captured on it.
  void* cuda_stream = nullptr;
  /// The ranks that detect in this scene together, for as long as it lives.
  Communicator communicator{};
};

/// Whether all members are equal.
SOFTCD_EXPORT bool operator==(const SceneOptions& a, const SceneOptions& b);
inline bool operator!=(const SceneOptions& a, const SceneOptions& b) {
  return !(a == b);
}  ///< see ==

/// Bodies, of which queries find the contacts. One thread at a time for a scene and its queries together; several
/// scenes may be used from several threads. A scene that was moved from throws Error from every function until another
/// one is assigned to it.
///
/// Everything may be called while a detection runs, and concerns the next one that is started.
class SOFTCD_EXPORT Scene {
 public:
  /// `log` as set_log(). Throws BackendError when options.backend cannot be had, InvalidInput when an option is out of
  /// range.
  explicit Scene(const SceneOptions& options = {}, LogCallback log = {});
  /// Detections that were not waited for are ended; the scene's queries can only be destroyed, moved or assigned to
  /// afterwards, and read for what their last detections found.
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// Throws InvalidInput naming the triangle, or segment, and the index when one is out of range; nothing is added
  /// then.
  BodyId add_body(const BodyDesc& desc);
  /// New topology, vertex count and settings for a body, whose positions have to be set again. Throws as add_body; the
  /// body is unchanged then.
  void update_body(BodyId body, const BodyDesc& desc);
  /// The same at the cost of what has changed, where a mesh is cut, torn, refined or made coarser: of desc.triangles
  /// those are read whose indices are in `changed`, in any order, and those behind the last that the body had. The
  /// others are as they were; where desc has fewer, those behind its last are gone. Edges that stay keep their indices,
  /// see Contact. All positions have to be set again: those of new vertices at t0 are what continuous detections take
  /// for the start of their way, which is where on the mesh they were made.
  ///
  /// The first such call after add_body() or update_body(body, desc), and the detection after it, cost about as much as
  /// these. So does every call where the body had segments, or desc has: it is update_body(body, desc) then, and all
  /// triangles are read. Throws also when an index in `changed` is out of range, or a vertex of a triangle that stays.
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

  /// These pairs are not compared by any query from the next detection on, instead of those that were given before.
  /// Throws InvalidInput when a body is not in the scene; nothing is changed then.
  void set_ignored_pairs(Span<const BodyPair> pairs);
  /// What the body's vertices may touch, of other bodies and of its own, beside what bodies' groups and masks decide;
  /// see VertexFilter. One for each vertex, or none. Vertices of bodies without filters have VertexFilter(): group 1
  /// and all bits as mask, so that a mask without bit 1 keeps a vertex from all of them. Copied. Throws InvalidInput
  /// when they are not as many as the body's vertices. Gone when the body is updated.
  void set_vertex_filters(BodyId body, Span<const VertexFilter> filters);
  /// Where the body's vertices are at rest, in whatever place, for BodySettings::rest_distance; none forgets them. On
  /// the host; copied, as floats relative to the middle of their box. Throws InvalidInput as set_positions(), and when
  /// one is not finite. Gone when the body is updated.
  void set_rest_positions(BodyId body, Positions x);

  /// Detections that were not waited for are ended, and their contacts are lost; with another backend, device or
  /// stream, or a lower memory_limit, all queries' contacts are. Contacts that are held (Query::hold_contacts) stay,
  /// and count towards the limit. Throws as the constructor does.
  void set_options(const SceneOptions& options);
  /// What was set last.
  const SceneOptions& options() const;
  /// Told warnings and what else may be of interest from now on; none is told nothing. It must not call the scene.
  void set_log(LogCallback log);

  /// The backend of the last detection, before the first one the expected: never `automatic`. With `automatic` small
  /// scenes go to the CPU even where there is a GPU, and a GPU that fails, or whose memory does not suffice, is
  /// replaced by the CPU in the same call, with one warning. With `cuda` that is a BackendError, or OutOfMemory.
  Backend backend() const;

 private:
  friend class Probe;
  friend class Query;
  detail::SceneCore& core() const;
  /// Throws Error where the scene was moved from.
  std::shared_ptr<detail::SceneCore> shared_core() const;

  std::shared_ptr<detail::SceneCore> core_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
