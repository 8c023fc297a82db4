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

/// A report on one of a world's detectors, about the last step in which it ran. Valid as long as the world.
class SOFTCD_EXPORT DetectorReport {
 public:
  /// Made by softcd.
  explicit DetectorReport(const DetectorRecord& record) : record_(&record) {}

  /// Returns counts and times; all zeros before the first step. After a failed step, those of the last good one.
  const Statistics& statistics() const;
  /// Returns which stages ran or were skipped, and why. Before the first step it describes an empty scene; after a
  /// failed step it is empty.
  std::vector<StageReport> explain() const;
  /// Returns the backend that it has used, never `automatic`; before the first step, the one that it expects to use.
  Backend backend() const;
  /// Returns the number of steps in which it failed: see OnError.
  std::uint64_t failed_steps() const;

 private:
  const DetectorRecord* record_;
};

/// Counts of the last pass of a step, which prevents crossings: see WorldDetection::crossing_report().
struct CrossingAnswers {
  std::uint64_t impacts = 0;     ///< pairs of features that would have met
  std::uint64_t rounds = 0;      ///< number of responses, each followed by another detection
  std::uint64_t held_nodes = 0;  ///< nodes held where the step began, after impulses and common motion did not help
  /// Pairs of features that still cross: a massless or anchored node, or a kinematic mesh, has met a node that cannot
  /// give way. The log names their bodies once, by their numbers among the world's soft bodies, until they have been
  /// apart for 64 steps. Pairs of two massless bodies are not tested.
  std::uint64_t unavoidable = 0;
  /// Pairs of features that were released, with EdgeContacts::respond: faces at them already intersect when the step
  /// begins. The log names their bodies as for `unavoidable`.
  std::uint64_t excepted = 0;
  /// Kinetic energy that the responses add to nodes with mass, J. Below 0 unless something that the app moves pushes
  /// them.
  double energy = 0;
  /// Momentum that they add, kg m/s; 0 up to rounding if all nodes in the pairs are free.
  double momentum[3] = {};
};

/// Two bodies that intersect, or a soft body that intersects itself, and that Settings::untangle moves apart.
struct IntersectingBodies {
  btSoftBody* a = nullptr;               ///< a soft body of the world
  const btCollisionObject* b = nullptr;  ///< another one, the same, or a rigid object with a triangle mesh
  std::uint32_t regions = 0;  ///< parts of both surfaces on the wrong side, see Probe::intersection_regions()
  std::uint64_t steps = 0;    ///< steps since the intersection was found, this one included
  double curve_length = 0;    ///< of all curves along which the surfaces intersect, in the positions' unit
};

/// The settings of softcd in a world, and the results of the last step. Lives as long as the world, or as the
/// Dispatcher if that detects.
class SOFTCD_EXPORT WorldDetection {
 public:
  /// Made by softcd's worlds and its Dispatcher.
  WorldDetection(const WorldKind& kind, const Settings& settings);
  ~WorldDetection();
  WorldDetection(const WorldDetection&) = delete;
  WorldDetection& operator=(const WorldDetection&) = delete;

  /// Returns the current settings. EdgeContacts::automatic is replaced by the world's choice.
  const Settings& settings() const;
  /// Changes the settings from the next step on. Throws InvalidInput for settings out of range, and BackendError for a
  /// backend that is not there; the settings are then unchanged.
  void set_settings(const Settings& settings);

  /// Replaces a body's filters from the next step on. The body is in the world then; when it leaves, its filters are
  /// forgotten. A changed number of nodes also drops them, with a warning. Filters do not affect contacts that Bullet
  /// finds itself: of nodes with convex shapes, and in a step in which softcd fails. Throws InvalidInput if the number
  /// of node filters is not the number of nodes, or a value is out of range; nothing changes then.
  void set_filters(const btSoftBody& body, BodyFilters filters);

  /// Tells ray tests that the app itself has moved nodes, or changed the nodes of faces, since the last ray, without a
  /// step in between. Rays notice steps, added and removed nodes and faces, and Bullet's functions that move bodies
  /// (translate(), updateBounds()).
  void forget_ray_positions();

  /// Reports on contacts between and within soft bodies: vertices with faces, and edges (Settings::edge_contacts).
  DetectorReport contact_report() const;
  /// Reports on the last pass of a step: all crossings with Detection::ccd, and crossings of rigid meshes with
  /// Detection::dcd (Settings::rigid_meshes). A Dispatcher under a world of Bullet's own class has no such pass. The
  /// pass detects several times; the report is about its last detection.
  DetectorReport crossing_report() const;
  /// Returns the counts of the last pass; all zeros if nothing would have crossed, or if the pass failed.
  CrossingAnswers crossing_answers() const;
  /// Returns the pairs of bodies that the last step was moving apart (Settings::untangle), as they were when it began.
  /// A pair that came apart is missing, and one that was given up for a while. The pointers are valid as long as the
  /// bodies, the reference until the next step.
  const std::vector<IntersectingBodies>& intersecting_bodies() const;
  /// Reports on contacts with rigid triangle meshes (Settings::rigid_meshes). The detector runs in steps in which boxes
  /// of such a pair overlap.
  DetectorReport rigid_mesh_report() const;
  /// Reports on contacts with convex shapes (ConvexShapes::faces_and_edges). The detector runs in steps in which boxes
  /// of such a pair overlap. The solver gets only some of the contacts found.
  DetectorReport convex_shape_report() const;

  /// Returns the edge contacts of the last step (Settings::edge_contacts). Empty before the first step and after a
  /// failed one.
  const std::vector<EdgeContact>& edge_contacts() const;

  /// Returns all contacts that Bullet's solver got in the last step, by pairs of bodies (Settings::read_out). It covers
  /// soft bodies with each other, with themselves and with rigid objects, whether softcd or Bullet found the contact;
  /// not contacts of clusters. Of several steps in one stepSimulation, it describes the last.
  ///
  /// `begun`, `persists`, `ended` and `is_new` compare with the previous call of this function. Only
  /// Settings::on_contacts sees contacts that come and go between two calls. Features are identified by their numbers:
  /// after a change of topology the pair persists, but its contacts may seem to end and begin. Bodies are identified by
  /// address and proxy number. btAxisSweep3 reuses proxy numbers, so that a removed body and a new one at its address
  /// may seem to be one.
  ///
  /// A sleeping body keeps the contacts with which it fell asleep. Empty if `read_out` is off, before the first step,
  /// and after a step that had too little memory for it. The reference is valid until the next call or step, the
  /// pointers as long as the bodies. Throws std::bad_alloc.
  const std::vector<BodyPairContacts>& body_contacts();

 private:
  friend class bullet::AttachedWorld;
  friend class Dispatcher;
  friend class DeformableWorld;
  template <class BulletWorld>
  friend class SoftWorld;

  std::unique_ptr<WorldQueries> queries_;
};

/// Builds a body's face tree, in O(n log n) time. Call it for a body that leaves a world of softcd's, or a Dispatcher,
/// for a world of Bullet's own: Bullet finds vertex-face contacts by this tree and builds it only when topology
/// changes. softcd's worlds call it for the bodies in them when they are destroyed.
SOFTCD_EXPORT void give_face_tree(btSoftBody& body);

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
