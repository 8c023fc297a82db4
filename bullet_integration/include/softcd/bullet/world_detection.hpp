#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "softcd/bullet/body_contacts.hpp"
#include "softcd/bullet/body_filters.hpp"
#include "softcd/bullet/edge_contact.hpp"
#include "softcd/bullet/settings.hpp"
#include "softcd/export.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {

class AttachedWorld;
class DetectorRecord;
class WorldQueries;
struct WorldKind;

inline namespace SOFTCD_VERSION_NAMESPACE {

/// What one of a world's detectors did in the last step in which it ran. Valid as long as the world.
class SOFTCD_EXPORT DetectorReport {
 public:
  /// For softcd itself.
  explicit DetectorReport(const DetectorRecord& record) : record_(&record) {}

  /// All zeros before the first step. After a step in which it failed, of the last one before.
  const Statistics& statistics() const;
  /// Which stages ran or were left out, and why. Before the first step: of a scene without bodies. Empty after a step
  /// in which it failed.
  std::vector<StageReport> explain() const;
  /// Where it computed: never `automatic`. Before the first step where it is expected to.
  Backend backend() const;
  /// In how many steps it has failed: see OnError.
  std::uint64_t failed_steps() const;

 private:
  const DetectorRecord* record_;
};

/// What a step did so that nothing passes through anything: see WorldDetection::crossings().
struct CrossingAnswers {
  std::uint64_t impacts = 0;     ///< pairs of features that would have met
  std::uint64_t rounds = 0;      ///< of answering and looking again
  std::uint64_t held_nodes = 0;  ///< nodes that stay where the step began: neither impulses nor common motion helped
  /// Pairs that meet nonetheless: a node without mass, which the app moves, one on an anchor, or a rigid mesh that
  /// moves, and a node that has nowhere to go. The log names their bodies, by their numbers among the world's soft
  /// bodies, once until they are apart. Two bodies without any mass are not looked at: whoever moves them both is asked
  /// for nothing that could be done, and limbs that overlap at a joint would be named in every app that has such.
  std::uint64_t unavoidable = 0;
  /// Pairs that were let go, with EdgeContacts::respond: faces at them intersect already when the step begins. Named
  /// likewise.
  std::uint64_t excepted = 0;
  /// What the velocities of nodes with mass gain by the answers: kinetic energy, J, which is less than 0 where nothing
  /// that the app moves pushes them, and momentum, kg m/s, 0 but for rounding where all nodes that meet are free.
  double energy = 0;
  double momentum[3] = {};  ///< see energy
};

/// softcd in a world: its settings, and what it found in the last step. Lives as long as the world, or as the
/// Dispatcher where that detects.
class SOFTCD_EXPORT WorldDetection {
 public:
  /// For softcd's worlds and its Dispatcher. Throws as CollisionPipeline's constructor.
  WorldDetection(const WorldKind& kind, const Settings& settings);
  ~WorldDetection();
  WorldDetection(const WorldDetection&) = delete;
  WorldDetection& operator=(const WorldDetection&) = delete;

  /// What was set last.
  const Settings& settings() const;
  /// From the next step on. Throws as CollisionPipeline::set_options.
  void set_settings(const Settings& settings);

  /// From the next step on, for a soft body that is in the world then, instead of those that it had. They are forgotten
  /// when it is not in the world any more as a step begins and, with a warning, when its number of nodes has changed.
  /// Contacts that Bullet finds itself, of nodes with convex shapes or in a step in which softcd fails, do not know
  /// them. Throws InvalidInput when there are not as many as nodes, or one is out of range; nothing is changed then.
  void set_filters(const btSoftBody& body, BodyFilters filters);

  /// Call it when the app itself has moved nodes, or changed what faces join, between two ray tests of softcd's worlds
  /// that have no step between them. A ray test notices what a step does. It also notices nodes and faces that are
  /// added or removed, and bodies that Bullet's functions move, such as translate() and updateBounds().
  void forget_ray_positions();

  /// Of vertices with faces, and of edges with Settings::edge_contacts, between soft bodies and within them.
  DetectorReport contacts() const;
  /// With Detection::ccd, in all worlds but those under a softcd::bullet::Dispatcher alone: of what would pass through
  /// something in the step. With Detection::dcd in the classic ones of these worlds: of what would pass through rigid
  /// meshes (Settings::rigid_meshes). Its last look is the last of several in a step.
  DetectorReport crossings() const;
  /// Of the last step; all zeros where nothing would have met, and after one in which the look at crossings failed.
  CrossingAnswers crossing_answers() const;
  /// With Settings::rigid_meshes: of soft bodies with rigid triangle meshes. It runs in steps in which the boxes of
  /// such a pair overlap.
  DetectorReport rigid_meshes() const;
  /// With ConvexShapes::faces_and_edges: of soft bodies with convex shapes. It runs in steps in which the boxes of such
  /// a pair overlap; what it finds is more than what Bullet's solver is given.
  DetectorReport convex_shapes() const;

  /// Of the last step. Empty before the first one, after one in which the detector failed, and unless
  /// Settings::edge_contacts asks for them.
  const std::vector<EdgeContact>& edge_contacts() const;

  /// With Settings::read_out: all contacts that Bullet's solver got in the last step (of several in a call of
  /// stepSimulation), by pairs of bodies: of soft bodies with each other, within themselves and with rigid objects, by
  /// whomever they were found; not those of clusters. `begun`, `persists` and `ended` compare with the step at which
  /// this was called last, `is_new` likewise; so what comes and goes between two calls is told to
  /// Settings::on_contacts alone. Nodes and faces are told by their numbers: where a body's topology changes, the pair
  /// persists and its contacts may seem to end and begin. Bodies are told by their address and the number of their
  /// broad-phase proxy, which btDbvtBroadphase never gives twice; with btAxisSweep3 a body removed and one added at its
  /// address between two calls may seem to be one.
  ///
  /// A body that sleeps keeps the contacts that it fell asleep with. Empty where `read_out` is off, before the first
  /// step and after one in which memory did not suffice for it. The reference is valid until the next call or step; the
  /// bodies in it as long as they are. Throws std::bad_alloc.
  const std::vector<BodyPairContacts>& body_contacts();

 private:
  friend class bullet::AttachedWorld;
  friend class Dispatcher;
  friend class DeformableWorld;
  template <class BulletWorld>
  friend class SoftWorld;

  std::unique_ptr<WorldQueries> queries_;
};

/// For a body that was in a world of softcd's, or under its Dispatcher, and goes into one of Bullet's: builds its face
/// tree, in time n log n. Bullet finds vertex-face contacts by that tree, builds it but once, in time quadratic in the
/// faces, and would have built it in the world before. A body that is still in one of softcd's worlds when that world
/// goes is given one then.
SOFTCD_EXPORT void give_face_tree(btSoftBody& body);

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
