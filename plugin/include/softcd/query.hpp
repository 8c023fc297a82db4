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

/// One line of explain().
struct StageReport {
  std::string stage;   ///< a stage, or another part of a detection, in words
  bool ran = false;    ///< in the last detection
  std::string reason;  ///< why it ran or did not
};

/// Which end of the step a discrete detection looks at.
enum class StepEnd : std::uint32_t { t1, t0 };

/// What is looked for.
struct QueryOptions {
  Detection detection = Detection::dcd;        ///< positions at an end of the step, or the way between both
  Accuracy accuracy = Accuracy::automatic;     ///< what is promised of the contacts
  BroadPhase broad_phase = BroadPhase::exact;  ///< changes the number of tests, not the contacts
  /// Off: no triangle is split, large ones are registered in every cell of their own volume. Changes the number of
  /// tests only, not the contacts.
  bool subdivision = true;
  /// Cell size of `exact` in units of the triangles' clipped mean bounding radius: useful 1.2 to 2.4, allowed 0.1 to
  /// 100. 0 chooses 1.8, and more where triangles move many cells or have large margins; on the CPU it also leaves out
  /// the grid where that has up to 4096 triangles of much the same size.
  float lambda = 0.0F;
  /// Discrete detection only: a vertex's margin against triangles of other bodies grows by this many times the distance
  /// that it moves from t0 to t1 (Bullet's classic soft bodies use 2). At least 0; 0 with StepEnd::t0.
  float motion_margin = 0.0F;
  ContactRule contact_rule = ContactRule::distance;  ///< of vertices with triangles
  /// Discrete detection only.
  StepEnd step_end = StepEnd::t1;
  /// Off: every body's margin counts as 0.
  bool margins = true;
  /// Off: BodySettings::neighbour_rings counts as 1 and rest_distance as 0, for who asks what is through each other.
  bool neighbour_filters = true;
  /// A kind of feature pairs is tested between two bodies that both want it, where the query does too.
  Features features = {true, true};
  /// Without memory_limit: pairs of triangles near each other are found once for several detections of the scene's
  /// queries, as long as all triangles stay where those were looked for. Takes memory for these pairs, once that has
  /// turned out to pay, and on CUDA has the host wait once more then. Changes no contacts.
  bool reuse_pairs = true;
  /// Contacts stay in the memory of the scene's CUDA device, where Ticket::wait_on_device() tells of them; for scenes
  /// with Backend::cuda.
  bool contacts_on_device = false;
};

/// Whether all members are equal.
SOFTCD_EXPORT bool operator==(const QueryOptions& a, const QueryOptions& b);
inline bool operator!=(const QueryOptions& a, const QueryOptions& b) {
  return !(a == b);
}  ///< see ==

/// Which pairs of bodies a detection compares, of those that groups, masks, boxes, lists of pairs and the filter leave.
enum class Pairs : std::uint32_t {
  all,
  /// Those of which a body was added or updated, or given positions or settings, since the query's last detection.
  changed,
};

/// Called for pairs of bodies that pass groups, masks, bounding boxes and lists of pairs, and, with a == b, for bodies
/// that collide with themselves; false leaves the pair out of this detection. Called on the thread that starts the
/// detection, a <= b.
using PairFilter = std::function<bool(BodyId a, BodyId b)>;

/// Contacts in a CUDA device's memory, as Ticket::wait() would return them.
struct DeviceContacts {
  const Contact* data = nullptr;  ///< on that device; valid as long as those of Ticket::wait()
  std::uint64_t count = 0;        ///< how many there are
  std::int32_t device = 0;        ///< as cudaGetDeviceCount counts them
  /// On that device, 2 * body_ids + 1 values: contacts [body_begin[k * body_ids + id], body_begin[k * body_ids + id +
  /// 1]) are those of kind k, 0 for vertex-triangle and 1 for edge-edge, whose body_a has this id. Null where no bodies
  /// were compared. Valid as long as `data`.
  const std::uint64_t* body_begin = nullptr;
  std::uint32_t body_ids = 0;  ///< all bodies' ids are less
};

/// Contacts in a CUDA device's memory of a detection that may still run, for work that is enqueued on that device.
struct PendingContacts {
  const Contact* data = nullptr;  ///< on the device, as DeviceContacts has them, once `ready` has happened
  std::uint64_t capacity = 0;     ///< how many there is room for
  /// On the device: how many there are, and whether that is all. Null where no bodies are compared: there are none.
  const ContactCounts* counts = nullptr;
  const std::uint64_t* body_begin = nullptr;  ///< see DeviceContacts
  std::uint32_t body_ids = 0;                 ///< see DeviceContacts
  void* ready = nullptr;                      ///< a cudaEvent_t after which all of it is there
  std::int32_t device = 0;                    ///< as cudaGetDeviceCount counts them
};

/// A detection that was started.
class SOFTCD_EXPORT Ticket {
 public:
  Ticket(Ticket&&) noexcept;
  Ticket& operator=(Ticket&&) noexcept;
  ~Ticket();

  /// All contacts, sorted by (kind, body_a, feature_a, body_b, feature_b), each once, once. Valid until the query's
  /// next detection is started, or its options are set, or it is destroyed. Throws Error when it was called before,
  /// when the query has started another detection or is gone, or when the scene's options were set, or when contacts
  /// are on the device; else what has gone wrong in the detection.
  Span<const Contact> wait();
  /// The same for a query with contacts_on_device. They are there, completely, when the call returns.
  DeviceContacts wait_on_device();
  /// For a query with contacts_on_device: where they will be, without waiting for them. A stream that waits for `ready`
  /// may read them; nothing else tells whether they are complete than their counts, there or after wait_on_device(),
  /// which repeats a detection where they are not: positions on the device have to stay as they are for that. Valid as
  /// long as what wait_on_device() returns. Throws as that does.
  PendingContacts on_device();

 private:
  friend class Query;
  Ticket(std::shared_ptr<detail::QueryCore> query, std::uint64_t number);

  std::shared_ptr<detail::QueryCore> query_;
  std::uint64_t number_;
};

/// Finds contacts between the bodies of a scene. The same input gives the same bytes, whatever the number of threads or
/// backend, and however often it is detected. The detections of one scene run one after another. A query that was moved
/// from throws Error from every function until another one is assigned to it.
class SOFTCD_EXPORT Query {
 public:
  /// Throws InvalidInput when an option is out of range.
  explicit Query(Scene& scene, const QueryOptions& options = {});
  /// A detection that still runs is ended.
  ~Query();
  Query(Query&&) noexcept;
  Query& operator=(Query&&) noexcept;

  /// Reads positions that were set and starts a detection. A body without positions is left out, and so is a triangle
  /// with a vertex that is not finite, which statistics() counts; warnings name both, and a continuous detection for
  /// which no body was given both ends of a step. Contacts of the query's detection before are gone. Throws Error when
  /// the scene is gone.
  [[nodiscard]] Ticket start(Pairs pairs = Pairs::all);
  /// start() and Ticket::wait() in one.
  Span<const Contact> detect(Pairs pairs = Pairs::all);
  /// start() and Ticket::wait_on_device() in one.
  DeviceContacts detect_on_device(Pairs pairs = Pairs::all);

  /// A detection of the query that runs is ended, and its contacts are lost. Throws as the constructor does, and Error
  /// when the scene is gone.
  void set_options(const QueryOptions& options);
  /// What was set last.
  const QueryOptions& options() const;
  /// Asked by every detection from the next one on; none lets all pairs through. It must not call the scene or its
  /// queries.
  void set_pair_filter(PairFilter filter);
  /// From the next detection on no other pairs are compared than these; an empty list, as at first, excludes none.
  /// Pairs of bodies that are not in the scene are nothing to compare.
  void set_only_pairs(Span<const BodyPair> pairs);

  /// What holds the contacts that were returned last, or told of by Ticket::on_device() last, unless the detection is
  /// repeated: they stay valid until what is returned and its copies are gone, whatever becomes of the query and its
  /// scene. Detections use other memory meanwhile. Throws Error when those contacts are not valid any more. Giving it
  /// back counts as using the scene: one thread at a time.
  std::shared_ptr<const void> hold_contacts();

  /// Where the scene has a communicator: the contacts that all ranks' last detections found, in order, which all of
  /// them ask for together; else those that were returned last. Throws Error when those are not valid any more, or on
  /// the device.
  std::vector<Contact> gather_contacts();

  /// Of the last detection that was waited for, and of this rank's part of it.
  const Statistics& statistics() const;
  /// Which stages that detection ran or left out, and why.
  std::vector<StageReport> explain() const;

 private:
  detail::QueryCore& core() const;

  std::shared_ptr<detail::QueryCore> core_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
