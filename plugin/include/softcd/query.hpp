#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "softcd/core/contact.hpp"
#include "softcd/core/statistics.hpp"
#include "softcd/export.hpp"
#include "softcd/scene.hpp"
#include "softcd/version.hpp"

namespace softcd {

namespace detail {
class QueryCore;
}

inline namespace SOFTCD_VERSION_NAMESPACE {

/// The parts of a detection on which explain() reports, in the order of time.
enum class DetectionStage : std::uint32_t {
  backend,                ///< the choice of the processor
  positions,              ///< of bodies that have none yet
  body_pairs,             ///< the choice of the bodies that may touch
  ranks,                  ///< the division among the ranks of a Communicator
  swept_volumes,          ///< bounding volumes of moving triangles
  virtual_subdivision,    ///< of triangles that are larger than a cell
  broad_phase,            ///< the search for pairs of triangles
  tests_against_all,      ///< of triangles that would need too many cells
  tests_in_parts,         ///< of pairs, so that memory suffices
  accuracy,               ///< the choice of the narrow phase's arithmetic
  vertex_triangle_tests,  ///< the narrow phase of vertices with triangles
  edge_edge_tests,        ///< the narrow phase of edges
  time_of_impact,         ///< the search for the first time of contact
  contact_economy,        ///< the choice of the contacts that a solver gets
};
/// Returns the stage in words, such as "broad phase".
SOFTCD_EXPORT const char* name_of(DetectionStage stage);

/// One line of explain().
struct StageReport {
  DetectionStage stage = DetectionStage::backend;  ///< the part of a detection
  bool ran = false;                                ///< whether the last detection ran it
  std::string reason;                              ///< why it ran or did not
};

/// The end of the step that a discrete detection uses.
enum class StepEnd : std::uint32_t { t0, t1 };

/// The options of a query.
struct QueryOptions {
  Detection detection = Detection::dcd;        ///< positions at one end of the step, or the path between both
  Accuracy accuracy = Accuracy::automatic;     ///< the guarantees for the contacts
  BroadPhase broad_phase = BroadPhase::exact;  ///< changes the number of tests, not the contacts
  /// If false, no triangle is split; large ones are registered in every cell of their own volume. Changes only the
  /// number of tests, not the contacts.
  bool subdivision = true;
  /// Cell size of `exact` in units of the clipped mean bounding radius of what the grid holds: triangles on a GPU,
  /// patches of up to 8 neighbouring triangles on the CPU. Useful from 1.2 to 2.4, allowed from 0.1 to 100. 0 chooses
  /// 1.8, or more where triangles move many cells or have large margins.
  float cell_size_factor = 0.0F;
  /// Discrete detection only: enlarges a vertex's margin against triangles of other bodies by this many times its
  /// distance from t0 to t1 (Bullet's classic soft bodies use 2). At least 0; must be 0 with StepEnd::t0.
  float motion_margin = 0.0F;
  ContactRule contact_rule = ContactRule::distance;  ///< for vertices with triangles
  /// Discrete detection only: the end of the step whose positions are compared.
  StepEnd step_end = StepEnd::t1;
  /// If false, every body's margin counts as 0.
  bool margins = true;
  /// If false, ignores BodySettings::neighbour_rings and rest_distance, so that the query reports every
  /// self-intersection.
  bool neighbour_filters = true;
  /// The kinds of feature pairs to test. Two bodies are tested for a kind when both bodies and the query want it.
  Features features = {true, true};
  /// If true, and without memory_limit, near pairs of triangles are found once and serve several detections of the
  /// scene's queries, until many triangles leave their volumes. Changes no contacts. Needs memory for these pairs,
  /// of up to four queries, once reuse has proved worthwhile. On CUDA, the host then waits once more.
  bool reuse_pairs = true;
  /// If true, contacts stay in the memory of the scene's CUDA device; see Ticket::wait_on_device(). Only for scenes
  /// with Backend::cuda.
  bool contacts_on_device = false;
};

/// Returns whether all members are equal.
SOFTCD_EXPORT bool operator==(const QueryOptions& a, const QueryOptions& b);
inline bool operator!=(const QueryOptions& a, const QueryOptions& b) {
  return !(a == b);
}  ///< see ==

/// The pairs of bodies that a detection compares, of those that groups, masks, boxes, lists of pairs and the filter
/// admit.
enum class Pairs : std::uint32_t {
  all,
  /// Pairs with a body that was added or updated, or given positions or settings, since the query's last detection.
  changed,
};

/// Decides which pairs of bodies a detection compares; false excludes the pair. Called on the thread that starts the
/// detection, with a <= b, for pairs that pass groups, masks, bounding boxes and lists of pairs. Called with a == b for
/// bodies that collide with themselves.
using PairFilter = std::function<bool(BodyId a, BodyId b)>;

/// Contacts in a CUDA device's memory, as Ticket::wait() would return them.
struct DeviceContacts {
  const Contact* data = nullptr;  ///< on that device; valid as long as the result of Ticket::wait()
  std::uint64_t count = 0;        ///< the number of contacts
  std::int32_t device = 0;        ///< as cudaGetDeviceCount counts them
  /// On that device, 2 * body_ids + 1 values. Contacts [body_begin[k * body_ids + id], body_begin[k * body_ids + id +
  /// 1]) are those of kind k whose body_a has this id; kind 0 is vertex-triangle, 1 is edge-edge. Null where no bodies
  /// were compared. Valid as long as `data`.
  const std::uint64_t* body_begin = nullptr;
  std::uint32_t body_ids = 0;  ///< all bodies' ids are below this
};

/// Contacts in a CUDA device's memory, of a detection that may still run. For work that the caller enqueues on that
/// device.
struct PendingContacts {
  const Contact* data = nullptr;  ///< on the device, as DeviceContacts has them, once `ready` has happened
  std::uint64_t capacity = 0;     ///< the number of contacts that fit
  /// On the device: the number of contacts, and whether all are stored. Null where no bodies are compared: there are no
  /// contacts.
  const ContactCounts* counts = nullptr;
  const std::uint64_t* body_begin = nullptr;  ///< see DeviceContacts
  std::uint32_t body_ids = 0;                 ///< see DeviceContacts
  void* ready = nullptr;                      ///< a cudaEvent_t after which all results are there
  std::int32_t device = 0;                    ///< as cudaGetDeviceCount counts them
};

/// A detection that was started.
class SOFTCD_EXPORT Ticket {
 public:
  Ticket(Ticket&&) noexcept;
  Ticket& operator=(Ticket&&) noexcept;
  ~Ticket();

  /// Waits for the detection and returns all contacts, each once, sorted by (kind, body_a, feature_a, body_b,
  /// feature_b). They stay valid until the query starts its next detection, its options are set, or it is destroyed.
  /// Callable once.
  ///
  /// Throws the error of a detection that failed. Throws Error in these cases:
  /// - it was called before;
  /// - the query is gone, or has started another detection;
  /// - the scene's options were set;
  /// - the contacts are on the device.
  Span<const Contact> wait();
  /// Waits for the detection of a query with contacts_on_device. All contacts are on the device when it returns.
  DeviceContacts wait_on_device();
  /// Returns where the contacts of a query with contacts_on_device will be, without waiting for them. A stream that
  /// waits for `ready` may read them.
  ///
  /// Only `counts` says whether the contacts are complete, either on the device or after wait_on_device(). Where they
  /// are not, wait_on_device() repeats the detection; positions on the device must not change until then. Valid as long
  /// as the result of wait_on_device(). Throws its exceptions.
  PendingContacts on_device();

 private:
  friend class Query;
  Ticket(std::shared_ptr<detail::QueryCore> query, std::uint64_t number);

  std::shared_ptr<detail::QueryCore> query_;
  std::uint64_t number_;
};

/// Finds contacts between the bodies of a scene. The same input gives the same bytes, whatever the number of threads,
/// the backend or the number of repetitions. The detections of one scene run one after another. A query that was moved
/// from throws Error from every function until another query is assigned to it.
class SOFTCD_EXPORT Query {
 public:
  /// Makes a query on the scene. Throws InvalidInput when an option is out of range.
  explicit Query(Scene& scene, const QueryOptions& options = {});
  /// Ends a detection that still runs.
  ~Query();
  Query(Query&&) noexcept;
  Query& operator=(Query&&) noexcept;

  /// Reads positions that were set, and starts a detection. The contacts of the query's previous detection are dropped.
  /// Throws Error when the scene is gone.
  ///
  /// Bodies without positions are left out. So are triangles with a vertex that is not finite; statistics() counts
  /// them. Warnings name both. A warning is also logged when a continuous detection has no body with positions at both
  /// ends of the step.
  [[nodiscard]] Ticket start(Pairs pairs = Pairs::all);
  /// Calls start() and Ticket::wait().
  Span<const Contact> detect(Pairs pairs = Pairs::all);
  /// Calls start() and Ticket::wait_on_device().
  DeviceContacts detect_on_device(Pairs pairs = Pairs::all);

  /// Sets the options. Ends a running detection of the query and drops its contacts. Throws the exceptions of the
  /// constructor, and Error when the scene is gone.
  void set_options(const QueryOptions& options);
  /// Returns the options that were set last.
  const QueryOptions& options() const;
  /// Sets the filter that every later detection asks; an empty filter admits all pairs. It must not call the scene or
  /// its queries.
  void set_pair_filter(PairFilter filter);
  /// Restricts later detections to these pairs; an empty list, the default, restricts nothing. Pairs of bodies that are
  /// not in the scene are ignored.
  void set_only_pairs(Span<const BodyPair> pairs);

  /// Returns an object that keeps contacts valid, whatever happens to the query and its scene, until it and all its
  /// copies are destroyed. It keeps the contacts that were returned last, or announced last by Ticket::on_device()
  /// unless that detection is repeated. Later detections use other memory.
  ///
  /// Throws Error when those contacts are no longer valid. Destroying the object counts as a use of the scene: one
  /// thread at a time.
  std::shared_ptr<const void> hold_contacts();

  /// Returns the contacts of all ranks' last detections, in order, where the scene has a communicator; all ranks must
  /// call it together. Otherwise returns the contacts that were returned last. Throws Error when those are no longer
  /// valid, or are on the device.
  std::vector<Contact> gather_contacts();

  /// Returns the statistics of the last detection that was waited for, and of this rank's part of it.
  const Statistics& statistics() const;
  /// Returns which stages that detection ran or skipped, and why, in the order of DetectionStage.
  std::vector<StageReport> explain() const;

 private:
  detail::QueryCore& core() const;

  std::shared_ptr<detail::QueryCore> core_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
