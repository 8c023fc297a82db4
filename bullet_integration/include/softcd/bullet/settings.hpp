#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "LinearMath/btScalar.h"
#include "softcd/bullet/body_contacts.hpp"
#include "softcd/softcd.hpp"
#include "softcd/version.hpp"

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Which soft bodies collide with themselves; Bullet's classic soft worlds have no such test. A body's margin should
/// then be at most a quarter of its edges' rest length. In classic worlds a node and a face that are closer than twice
/// the margin at rest push each other all the time.
enum class SelfCollision : std::uint32_t {
  flagged,  ///< bodies on which setSelfCollision(true) was called; Bullet's default is false
  all,      ///< every body
  none,
};

/// Whether edges touch edges; Bullet has no such test and no such contacts. Edges are the sides of faces, and the links
/// of ropes, which are soft bodies with neither faces nor tetrahedra. Bending links are not edges.
enum class EdgeContacts : std::uint32_t {
  off,     ///< not detected
  report,  ///< detected, for edge_contacts() only
  /// Detected and given to Bullet's solver, each as two vertex-face contacts. Ropes then touch each other, themselves,
  /// cloths and edges of rigid meshes. In these contacts a link appears as a face outside of m_faces, whose third node
  /// has no weight.
  respond,
  automatic,  ///< respond in the deformable world, off in classic worlds
};

/// Which of a node's contacts with the faces of one body Bullet's solver gets.
enum class Contacts : std::uint32_t {
  all,  ///< all within the margin: a node over an edge has two, over a corner about six, with the same normal
  /// In classic worlds one for each place where the body's surface is nearest to the node, such as each layer of a
  /// fold. The kept contact carries the push and friction of those dropped. The choice is also made among contacts of
  /// edges. In the deformable world all: fewer contacts would hold less. docs/use/bullet.md has the rule.
  closest_feature,
  automatic,  ///< closest_feature with Detection::dcd, otherwise all
};

/// Which features of soft bodies touch convex rigid shapes: any btConvexShape, alone or in a compound, of a rigid body,
/// a multibody link or a plain collision object.
enum class ConvexShapes : std::uint32_t {
  nodes,            ///< nodes, by Bullet's own test: a shape smaller than a face passes between its nodes
  faces_and_edges,  ///< also faces and edges, against corners and edges of the shapes
};

/// Which soft bodies that intersect each other, themselves or rigid triangle meshes (`rigid_meshes`) are moved apart.
/// Parts on the wrong side then get no contacts with the body that they intersect. A closed body that is inside another
/// one without touching it stays there. Convex shapes are left to Bullet's contacts. docs/use/bullet.md has the rules.
enum class Untangle : std::uint32_t {
  off,
  later,  ///< those that did not intersect when both were first in the world
  all,    ///< those that intersect from the start, and those with filters, too
  /// Parts the bodies that `later` parts. With `dcd` it also parts bodies that intersect from the start: soft bodies
  /// and rigid meshes in all worlds, soft bodies in classic worlds. In the deformable world Bullet's contacts hold such
  /// soft bodies at rest.
  automatic,
};

/// The response to a step in which softcd fails with an Error or std::bad_alloc.
enum class OnError : std::uint32_t {
  /// The step continues with Bullet's own detection, without contacts of edges and, in classic worlds, within bodies;
  /// or without the last pass. Each detector warns once, and counts such steps.
  fall_back,
  /// The exception passes through Bullet and ends the step in the middle.
  throw_error,
};

/// The amount that WorldDetection::body_contacts() reports.
enum class ReadOut : std::uint32_t {
  off,       ///< nothing, at no cost
  contacts,  ///< which bodies touch, and where
  /// Also impulses. Classic worlds then solve soft bodies twice, the first time without effect. The deformable world
  /// solves contacts between soft bodies one at a time, in a shuffled order of its own.
  impulses,
};

/// Receives the contacts of one step, as body_contacts() returns them, compared with the step before.
using BodyContactsCallback = std::function<void(const std::vector<BodyPairContacts>&)>;

// This namespace is part of the linker name of every function that takes Settings. An application and a softcd compiled
// for different btScalars therefore do not link, and the message says what to link. Most of Bullet's own names are the
// same in both precisions.
#ifdef BT_USE_DOUBLE_PRECISION
inline namespace compiled_with_bt_use_double_precision_so_link_softcd_bullet_float64 {
#else
inline namespace compiled_without_bt_use_double_precision_so_link_softcd_bullet {
#endif

/// Settings of softcd in a Bullet world. softcd replaces the vertex-face detection between and within soft bodies
/// (VF_SS in classic worlds, VF_DD in the deformable world). Bullet keeps all other kinds of collision, clusters among
/// them. Exceptions from the app's own callbacks (near callback, log) pass through Bullet. docs/use/bullet.md has
/// examples.
struct Settings {
  Backend backend = Backend::automatic;  ///< where detections run
  /// dcd detects contacts by Bullet's own rules, at one end of the step. ccd detects along the whole step. Its last
  /// pass stops nodes that would cross a face at any speed, and with EdgeContacts::respond edges that would cross
  /// edges. A Dispatcher under a world of Bullet's own class has no last pass. Only massless nodes and rigid meshes
  /// that the app moves can still cross a body: see WorldDetection::crossing_answers(). docs/use/bullet.md has the
  /// exact rules.
  Detection detection = Detection::dcd;
  Accuracy accuracy = Accuracy::precise;                  ///< of contacts; the last pass is always conservative
  BroadPhase broad_phase = BroadPhase::exact;             ///< changes the number of tests, not the contacts
  float cell_size_factor = 0.0F;                          ///< cell size, see QueryOptions::cell_size_factor; 0 chooses
  bool reuse_pairs = true;                                ///< caches found pairs, see QueryOptions::reuse_pairs
  SelfCollision self_collision = SelfCollision::flagged;  ///< which bodies collide with themselves
  EdgeContacts edge_contacts = EdgeContacts::automatic;   ///< whether edges touch edges
  Contacts contacts = Contacts::automatic;                ///< which of a node's contacts the solver gets
  /// Most contacts of a node with faces of one body on one side: the nearest, or with `ccd` the earliest, whose normals
  /// are less than a right angle apart. 0: no limit.
  std::uint32_t contacts_per_node = 0;
  /// Whether softcd detects contacts with rigid triangle meshes, at the sum of both margins and along the whole step:
  /// btBvhTriangleMeshShape, also scaled or with materials, GImpact and btHeightfieldTerrainShape; not meshes of
  /// multibody links. Meshes do not pass between nodes, even with `dcd`. If false, Bullet collides with each triangle
  /// as with a plate 0.12 thick.
  bool rigid_meshes = true;
  /// faces_and_edges adds contacts that Bullet's test of nodes misses: shapes' corners on faces, edges on edges, and
  /// nodes that are too fast. Not for planes, ghost objects and soft bodies without faces. docs/use/bullet.md says how
  /// it works and what it does not prevent.
  ConvexShapes convex_shapes = ConvexShapes::nodes;
  /// Which bodies that intersect are moved apart; none by a Dispatcher under a world of Bullet's own class.
  Untangle untangle = Untangle::automatic;
  /// Greatest speed, m/s, at which `untangle` moves a node. 0: 20 times the mean length of the edges that intersect
  /// triangles, a second.
  float untangle_speed = 0;
  /// Deformable world only: whether filter groups, masks, ignored pairs and the near callback apply to pairs of soft
  /// bodies. Bullet ignores them there; classic worlds always apply them.
  bool filter_deformables = false;
  ReadOut read_out = ReadOut::off;  ///< what body_contacts() reports
  /// Called at the end of every step unless `read_out` is off; by a Dispatcher alone after it has dispatched. It may
  /// read the world, but not change it.
  BodyContactsCallback on_contacts;
  OnError on_error = OnError::fall_back;  ///< what happens in a step in which softcd fails
  /// Receives warnings and messages: see Scene::set_log().
  LogCallback log;

  // Presets. Each is a value whose members can be changed further.

  /// Returns settings for the shortest step: Bullet's own rules, in float, in classic worlds with
  /// Contacts::closest_feature, and no contacts of edges.
  static Settings fast();
  /// Returns the default: discrete detection. The kind of world chooses the rest, see EdgeContacts and Contacts.
  static Settings balanced() { return {}; }
  /// Returns settings for the fewest crossings, at any speed: continuous detection, responses to edges, and corners and
  /// edges of convex shapes. A body crosses another one only if it has nowhere else to go. docs/use/limits.md says what
  /// is not prevented.
  static Settings safe();
};

inline Settings Settings::fast() {
  Settings settings;
  settings.accuracy = Accuracy::fast;
  settings.edge_contacts = EdgeContacts::off;
  settings.untangle = Untangle::off;
  return settings;
}

inline Settings Settings::safe() {
  Settings settings;
  settings.detection = Detection::ccd;
  settings.edge_contacts = EdgeContacts::respond;
  settings.convex_shapes = ConvexShapes::faces_and_edges;
  settings.contacts = Contacts::closest_feature;
  return settings;
}

}  // namespace

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
