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

/// Which soft bodies collide with themselves. Bullet's classic soft worlds have no such test. A body's margin should
/// then be at most a quarter of its edges' rest length: features that are closer than twice the margin at rest would
/// push each other all the time.
enum class SelfCollision : std::uint32_t {
  flagged,  ///< bodies on which setSelfCollision(true) was called; Bullet's default is false
  all,      ///< every body
  none,
};

/// What becomes of edges that touch edges. Bullet has neither the test nor a place for such contacts. Edges are those
/// of faces, and the links of a rope: of a soft body that has neither faces nor tetrahedra. Its bending links
/// (btSoftBody::generateBendingConstraints) are none, nor is a link of a body with faces that is no side of a face.
enum class EdgeContacts : std::uint32_t {
  off,     ///< not looked for
  report,  ///< found, for edge_contacts()
  /// And given to Bullet's solver, each as two of its vertex-face contacts; so ropes touch each other, themselves and
  /// cloths. Links of ropes touch edges of rigid meshes, too (Settings::rigid_meshes). A link stands in Bullet's
  /// contacts as a face that is none of the body's m_faces, whose third node has no weight.
  respond,
};

/// Which of a node's contacts with the faces of one body, of those within its margin, Bullet's solver is given.
enum class Contacts : std::uint32_t {
  all,  ///< Bullet's rule: a node over an edge has two, over a corner some six, of the same normal
  /// One for each place where the body's surface is nearest to the node: a contact at an edge or a corner of its face
  /// goes where a face there is nearer, or as near and before it in the body's array, with a normal less than a right
  /// angle from its own. So one stays for each layer, wall of a fold or side of a valley that the node is between, the
  /// nearest among them. What stays answers for what went: in the deformable world with its springs, in the classic
  /// ones with its friction and its push. There what cannot close goes, too: what would not come within both bodies'
  /// margins if both sides moved twice as far towards each other as in this step. Of contacts of edges of two bodies,
  /// the classic worlds give those where no face at either edge leads nearer to the other edge, and no end of an edge,
  /// which has contacts of its own, is nearest. Contacts of edges within a body, and in the deformable world, are all
  /// given.
  closest_feature,
  automatic,  ///< closest_feature in classic worlds with `dcd`, all elsewhere
};

/// Which features of soft bodies touch convex rigid shapes: boxes, hulls, spheres, capsules, cylinders, cones and
/// whatever else is a btConvexShape, by itself or in compounds, of rigid bodies, links of multibodies and plain
/// collision objects.
enum class ConvexShapes : std::uint32_t {
  nodes,            ///< Bullet's own test alone: what is smaller than a face passes between its nodes
  faces_and_edges,  ///< corners and edges of the shapes, too, on faces and edges
};

/// What becomes of a step in which softcd fails: with an Error, or std::bad_alloc.
enum class OnError : std::uint32_t {
  /// The step goes on with Bullet's own detection, which has no contacts of edges nor, in classic worlds, within
  /// bodies;
  /// or without the look at crossings. A warning says so, once for each detector, which counts such steps.
  fall_back,
  /// The exception passes through Bullet's functions and leaves the world's step in the middle.
  throw_error,
};

/// What WorldDetection::body_contacts() tells.
enum class ReadOut : std::uint32_t {
  off,       ///< nothing, at no cost
  contacts,  ///< who touches whom, and where
  /// And what the solver answered. In classic worlds Bullet's soft bodies are solved twice for that, the first time
  /// without effect. In the deformable world contacts between soft bodies are answered one at a time, in an order drawn
  /// by the world instead of the one that Bullet draws.
  impulses,
};

/// What body_contacts() is for one step (of several that stepSimulation may take), compared with the step before.
using BodyContactsCallback = std::function<void(const std::vector<BodyPairContacts>&)>;

// Part of the linker's names of all functions that take Settings, so that an application and a softcd compiled for
// different btScalars do not link, and the linker's message says what to link. Most of Bullet's own names are the same
// in both precisions.
#ifdef BT_USE_DOUBLE_PRECISION
inline namespace compiled_with_bt_use_double_precision_so_link_softcd_bullet_float64 {
#else
inline namespace compiled_without_bt_use_double_precision_so_link_softcd_bullet {
#endif

/// How softcd replaces Bullet's vertex-face detection between soft bodies and within them (fCollision::VF_SS in the
/// classic worlds, VF_DD in the deformable one). All other kinds of collision, clusters among them, stay Bullet's.
/// Exceptions of the app's own callbacks (the near callback, the log) pass through Bullet.
struct Settings {
  Backend backend = Backend::automatic;  ///< where detections are computed
  /// dcd: Bullet's own rules. Classic worlds: a node touches a face when their distance at the end of the step is less
  /// than both bodies' margins plus twice the distance that the node moves in the step, where the boxes of node and
  /// face overlap in Bullet's trees. These boxes have 1.25 times the margin, and reach ahead along the motion of three
  /// steps. Deformable world: at the start of the step, by ContactRule::slab, where such boxes overlap. ccd: the motion
  /// of the whole step is tested, so that nothing passes through however fast it is. In the classic worlds instead of
  /// the rule above: the margin does not grow with speed; in the deformable world after it. Last of all, in either,
  /// what is on its way through something (nodes through faces; with EdgeContacts::respond edges through edges, too)
  /// gets impulses, then one common motion, and then stays where it was until the next step; not under a
  /// softcd::bullet::Dispatcher alone, which warns that it cannot. Rigid triangle meshes are looked at, too (with
  /// rigid_meshes), for bodies with VF_SS or VF_DD: what they come upon is sent back or along, and pushes none of them.
  /// Only what others move, nodes without mass and meshes, can still end a step within something: see
  /// WorldDetection::crossing_answers(). Convex rigid shapes are not among it: see convex_shapes. What is through each
  /// other already when a step begins cannot be told to belong on either side: in the classic worlds such features get
  /// no contacts, and with EdgeContacts::respond nothing keeps them from coming apart. What touches then, at a distance
  /// of 0, gets no contacts in that step either (but under a Dispatcher alone), and may come apart and slide; it stays
  /// on its side where it has one: sheets in one plane have none, and may leave each other to either.
  Detection detection = Detection::dcd;
  Accuracy accuracy = Accuracy::precise;       ///< of contacts; what would pass through is looked for conservatively
  BroadPhase broad_phase = BroadPhase::exact;  ///< changes the number of tests, not the contacts
  float lambda = 0.0F;                         ///< cell size, see PipelineOptions::lambda; 0 chooses
  bool reuse_pairs = true;                     ///< what one look finds serves later ones, see QueryOptions::reuse_pairs
  SelfCollision self_collision = SelfCollision::flagged;  ///< which bodies collide with themselves
  EdgeContacts edge_contacts = EdgeContacts::off;         ///< whether edges touch edges
  Contacts contacts = Contacts::automatic;                ///< how many of a node's contacts the solver is given
  /// Bullet's solver is given a node's contact with a face of one body unless it is given so many nearer ones, or
  /// earlier with `ccd`, with that body, whose normals are less than a right angle from its own. 0: no such bound.
  std::uint32_t contacts_per_node = 0;
  /// Soft bodies against rigid triangle meshes (btBvhTriangleMeshShape, also scaled or with materials, GImpact and
  /// btHeightfieldTerrainShape; not those of multibody links): found by softcd, always on the way of a step, at the
  /// sum of both margins. Bullet collides with each triangle as with a plate 0.12 thick. False leaves them to Bullet.
  /// With dcd too, a mesh does not pass between the nodes of a soft body. In the classic worlds the last pass of ccd
  /// runs for soft bodies near meshes, whatever their flags and `edge_contacts` are; not under a Dispatcher alone. In
  /// the deformable world corners and edges of meshes have contacts with faces, at half the margin, of bodies with
  /// SDF_RDN; with SDF_RDF corners have them at the whole margin.
  bool rigid_meshes = true;
  /// faces_and_edges: softcd adds what Bullet's test of soft nodes with convex shapes leaves out, always on the way of
  /// a step: corners of the shapes against faces, their edges against edges, and nodes that the test has missed because
  /// they have passed. A contact that Bullet has found is not given twice; in classic worlds one that pushes through
  /// what it should keep off is replaced. Shapes are what Bullet takes them for: within their margin of a core, exact
  /// for boxes, hulls, spheres and capsules; cylinders and cones are inscribed with 32 corners, 0.5 % of their radius
  /// too small in between, and other round shapes up to 1.1 %. Shapes are read in every step, and may be scaled,
  /// replaced, nested in compounds or moved by the app. What does not respond to contacts (ghost objects) and planes
  /// are left alone, and so are soft bodies without faces.
  ///
  /// Classic worlds: a contact of a face goes to its nodes, by their weights, as Bullet's solver has no other; a face
  /// that turns about what it touches is slowed down by that, and body_contacts() lists it once for each node. With
  /// `ccd` contacts are solved once more when Bullet's solver has pulled at the links, and rigid bodies that meet soft
  /// ones on their way end the step where what has stopped them lets them; without, as in Bullet, they move first and
  /// are stopped in the next step, and so they are under a softcd::bullet::Dispatcher alone. Deformable world: Bullet
  /// tests faces itself, with SDF_RDF against rigid bodies and with SDF_MDF against links; then softcd adds only what
  /// is too fast for that, and nothing without these flags.
  ///
  /// Not prevented: what is through a shape already, by more than the margins, and cloths that are held and too stiff
  /// for what hits them, which Bullet's classic solver pulls back through it. With `ccd` a cloth of 4 * 4 nodes that is
  /// held at its corners kept a box of twice its mass from heights up to 1.5 m, but none of ten times; one of 6 * 6
  /// nodes kept a box of half its mass, but none of twice. Bullet's own test kept none of them. In the deformable world
  /// one of 6 * 6 nodes kept 33 of 39 boxes of ten times its mass, and 37 with `nodes`, as with Bullet alone.
  ConvexShapes convex_shapes = ConvexShapes::nodes;
  /// Deformable world only: whether filter groups, masks, ignored pairs and the near callback decide about pairs of
  /// soft bodies too. Bullet asks nobody there; the classic worlds always ask.
  bool filter_deformables = false;
  ReadOut read_out = ReadOut::off;  ///< what body_contacts() tells
  /// Called at the end of every step unless `read_out` is off; by a softcd::bullet::Dispatcher alone when it has
  /// dispatched. It may read the world, not change it.
  BodyContactsCallback on_contacts;
  OnError on_error = OnError::fall_back;  ///< what becomes of a step in which softcd fails
  /// As CollisionPipeline::set_log().
  LogCallback log;

  // Presets. Each is a value whose members can be changed further.

  /// The least time for a step: Bullet's own rules, in float, with one contact for each place where a body's surface is
  /// nearest to a node.
  static Settings fast();
  /// The default.
  static Settings balanced() { return {}; }
  /// No step makes an intersection, at whatever speed: continuous detection, responses to edges, and the corners and
  /// edges of convex shapes.
  static Settings safe();
};

inline Settings Settings::fast() {
  Settings settings;
  settings.accuracy = Accuracy::fast;
  settings.contacts = Contacts::closest_feature;
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
