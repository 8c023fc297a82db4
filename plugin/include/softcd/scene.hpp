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

/// The kinds of feature pairs that a body takes part in. Two bodies are tested for a kind when both take part in it.
struct Features {
  bool vertex_triangle = true;  ///< vertices against triangles
  bool edge_edge = true;        ///< edges against edges
};

/// A body's settings. They may change from one detection to the next, without a change of topology.
struct BodySettings {
  /// Two features are in contact when their distance is at most the sum of their bodies' margins.
  /// Unit: the positions'. Finite, at least 0.
  float margin = 0.0F;
  /// Bodies a and b are compared when (a.filter_group & b.filter_mask) and (b.filter_group & a.filter_mask).
  std::uint32_t filter_group = 1;
  std::uint32_t filter_mask = 0xFFFFFFFFu;  ///< see filter_group
  /// If true, also finds contacts between features of this body that share no vertex, whatever its group and mask.
  bool self_collision = true;
  /// If true, the body is moved by the application (static or animated). Two kinematic bodies are never compared, nor
  /// is one with itself.
  bool kinematic = false;
  Features features;  ///< which pairs of features it takes part in
  /// Bodies of different batches never touch, wherever they are. Many small scenes can thus be detected together as
  /// one.
  std::uint32_t batch = 0;
  /// Features of this body that are connected by a path of fewer edges than this are never in contact. With 1, features
  /// that share a vertex are excluded; with 2, also features whose vertices are joined by an edge; and so on. In [1,
  /// 16]. More than 1 needs memory for each vertex's surroundings: in a regular mesh 24 bytes with 2, 72 with 3,
  /// growing with the square.
  std::uint32_t neighbour_rings = 1;
  /// Features of this body are never in contact if their distance in the rest positions is at most this (see
  /// Scene::set_rest_positions()). Unit: the positions'. Finite, at least 0, which excludes none. Above 0 with
  /// self_collision, a detection throws InvalidInput unless rest positions were set.
  float rest_distance = 0.0F;
};

/// Two bodies, in either order, or a body and itself.
struct BodyPair {
  BodyId a;  ///< one body
  BodyId b;  ///< the other one
};

/// A mesh: triangles and segments over vertices 0 .. vertex_count - 1. A vertex that belongs to none of them does not
/// collide, unless a triangle {v, v, v} is added for it.
struct BodyDesc {
  Span<const Triangle> triangles;  ///< read during the call
  std::uint32_t vertex_count = 0;  ///< the number of positions to set
  BodySettings settings{};         ///< initial settings; set_settings() changes them later
  /// With SceneOptions::communicator, the only rank that sets the body's positions; the next detection gives them to
  /// all others. If starting that detection throws, they must be set again. -1: every rank sets the same positions.
  std::int32_t rank = -1;
  /// Segments, for ropes and hair, read during the call. See Contact for the indices of their edges. A probe or a count
  /// of triangles treats segment i as triangle triangles.size() + i, {v[0], v[1], v[1]}.
  /// - A segment's vertices touch triangles.
  /// - With Features::edge_edge, a segment's edge touches edges of triangles and of other segments. Only by this
  ///   contact do segments touch each other, and vertices touch segments, as ends of edges. A triangle {v, v, v} has no
  ///   edge and touches no segment.
  /// - Segments that share a vertex do not touch.
  /// - A segment that is given twice, or is also a triangle's side, exists once.
  Span<const Segment> segments{};
};

/// The importance of a log message.
enum class LogLevel : std::uint32_t { information, warning };
/// Receives log messages. It is called on the thread that calls a scene or its queries, by any function that is not
/// const.
using LogCallback = std::function<void(LogLevel, std::string_view)>;

/// The processor and the memory for the detections on a scene.
struct SceneOptions {
  Backend backend = Backend::automatic;  ///< the processor that computes detections
  /// The most bytes of the backend's memory that the scene may hold at once; 0 for no limit. Lists that grow count
  /// twice while they are copied. Meshes and positions on the host do not count. A new limit holds from the next
  /// detection on, which frees memory beyond it.
  /// - Where the limit is too low for all pairs of triangles at once, the pairs are tested in parts, with the same
  ///   contacts.
  /// - Where it is too low for the triangles, their grid entries or the contacts, starting a detection or waiting for
  ///   it throws OutOfMemory.
  std::uint64_t memory_limit = 0;
  /// The most threads that work on detections on the CPU, including the calling thread; 0 for as many as there are
  /// processors.
  std::uint32_t max_threads = 0;
  /// The CUDA device, as cudaGetDeviceCount counts them; -1 for the calling thread's current device at construction.
  std::int32_t cuda_device = -1;
  /// The cudaStream_t for the GPU's work, which must live as long as the scene; null for a stream of the scene's own.
  /// No other work may be captured on it.
  void* cuda_stream = nullptr;
  /// The ranks that detect in this scene together. Fixed for the scene's life.
  Communicator communicator{};
};

/// Returns whether all members are equal.
SOFTCD_EXPORT bool operator==(const SceneOptions& a, const SceneOptions& b);
inline bool operator!=(const SceneOptions& a, const SceneOptions& b) {
  return !(a == b);
}  ///< see ==

/// Holds bodies, whose contacts queries find. Only one thread at a time may use a scene and its queries; different
/// scenes may be used by different threads. A scene that was moved from throws Error from every function until another
/// scene is assigned to it.
///
/// Every function may be called while a detection runs; it then concerns the next detection.
class SOFTCD_EXPORT Scene {
 public:
  /// Passes `log` to set_log(). Throws BackendError when options.backend is not available, InvalidInput when an option
  /// is out of range.
  explicit Scene(const SceneOptions& options = {}, LogCallback log = {});
  /// Ends detections that the caller has not waited for. Afterwards the scene's queries can only be destroyed, moved,
  /// assigned to, or read for the results of their last detections.
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// Adds a body. Throws InvalidInput, naming the triangle or segment and the index, when an index is out of range. It
  /// then adds nothing.
  BodyId add_body(const BodyDesc& desc);
  /// Replaces a body's topology, vertex count and settings. Its positions must be set again. Throws the exceptions of
  /// add_body(), and InvalidInput when there is no such body; the body is then unchanged.
  void update_body(BodyId body, const BodyDesc& desc);
  /// Replaces a body's mesh where it was cut, torn, refined or made coarser. The cost depends on the size of the
  /// change.
  /// - Of desc.triangles, the function reads those with indices in `changed` (in any order), and those behind the last
  ///   that the body had. It keeps all other triangles. If desc has fewer triangles, those behind its last
  ///   are removed.
  /// - Remaining edges keep their indices, see Contact.
  /// - All positions must be set again. Continuous detections take a new vertex's position at t0 as the start of its
  ///   path: the place on the mesh where it was made.
  ///
  /// Some calls cost as much as update_body(body, desc), which reads all triangles:
  /// - the first such call after add_body() or update_body(body, desc), with the detection after it;
  /// - every call where the body had segments, or desc has some.
  ///
  /// Also throws InvalidInput when an index in `changed` is out of range, or a vertex index of an unchanged triangle
  /// is.
  void update_body(BodyId body, const BodyDesc& desc, Span<const std::uint32_t> changed);
  /// Sets a body's settings. Throws InvalidInput when there is no such body or a setting is out of range.
  void set_settings(BodyId body, const BodySettings& settings);
  /// Removes a body. Throws InvalidInput when there is no such body.
  void remove_body(BodyId body);
  /// Returns whether the body was added and not removed.
  bool has_body(BodyId body) const;

  /// Sets the positions of a body that does not move during the step: t0 and t1 are the same. Throws the exceptions of
  /// the next function.
  void set_positions(BodyId body, Positions x);
  /// Sets the positions of the body's vertices at both ends of the step. Throws InvalidInput when there is no such
  /// body, a count is not the body's, a pointer is null, a stride is shorter than a position, or one end is float and
  /// the other double.
  void set_positions(BodyId body, Positions x_t0, Positions x_t1);

  /// Sets the pairs of bodies that no query compares from the next detection on. Replaces the pairs that were set
  /// before. Throws InvalidInput when a body is not in the scene; nothing is then changed.
  void set_ignored_pairs(Span<const BodyPair> pairs);
  /// Sets a filter for each vertex of the body, or none if empty. It restricts the features of other bodies and of its
  /// own body that the vertex may touch, in addition to the bodies' groups and masks; see VertexFilter.
  ///
  /// Vertices of bodies without filters have VertexFilter(): group 1 and all bits as mask. A mask without bit 1
  /// therefore keeps a vertex from all of them. The filters are copied, and dropped when the body is updated. Throws
  /// InvalidInput when their number is not the body's vertex count.
  void set_vertex_filters(BodyId body, Span<const VertexFilter> filters);
  /// Sets the body's rest positions, in any place, for BodySettings::rest_distance; none removes them. They must be in
  /// host memory. They are copied, as floats relative to the middle of their box, and dropped when the body is updated.
  /// Throws the exceptions of set_positions(), and InvalidInput when a coordinate is not finite.
  void set_rest_positions(BodyId body, Positions x);

  /// Sets the options. Ends detections that the caller has not waited for, and drops their contacts. With another
  /// backend, device or stream, or a lower memory_limit, drops all queries' contacts. Held contacts
  /// (Query::hold_contacts) stay, and count towards the limit. Throws the exceptions of the constructor.
  void set_options(const SceneOptions& options);
  /// Returns the options that were set last.
  const SceneOptions& options() const;
  /// Sets the function that receives warnings and other messages from now on; an empty function turns them off. It must
  /// not call the scene.
  void set_log(LogCallback log);

  /// Returns the backend of the last detection, or, before the first one, the expected backend. Never `automatic`.
  /// - With `automatic`, the CPU computes small scenes even where a GPU exists. When a GPU fails or lacks memory, the
  ///   CPU replaces it in the same call, with one warning.
  /// - With `cuda`, such a failure throws BackendError or OutOfMemory.
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
