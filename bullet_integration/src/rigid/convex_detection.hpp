#pragma once

#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "rigid/convex_core.hpp"
#include "rigid/native_touches.hpp"
#include "rigid/rigid_pairs.hpp"
#include "rigid/rigid_parts.hpp"
#include "rigid/rigid_touches.hpp"

namespace softcd::bullet {

/// Finds what Bullet's test of nodes with convex shapes leaves out, on the way of a step: corners of the shapes against
/// faces of soft bodies, edges against edges, and nodes that the test has missed.
class ConvexDetection {
 public:
  using Kind = NodeEnds;

  /// `ends`, `mirror` and `settings` outlive it.
  ConvexDetection(const NodeEnds& ends, WorldMirror& mirror, const Settings& settings);
  ConvexDetection(const ConvexDetection&) = delete;
  ConvexDetection& operator=(const ConvexDetection&) = delete;

  void follow_settings();
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const { return query_.explain(); }
  /// With Settings::read_out: about the contacts that the last find_contacts() wrote.
  const ContactNotes& notes() const { return touches_.notes(); }
  /// When Bullet has processed these pairs: appends what it has no contacts for to the bodies' m_rcontacts (with
  /// SDF_RS), or m_nodeRigidContacts and m_faceRigidContacts (with SDF_RD and SDF_RDN; SDF_RDF for rigid bodies,
  /// SDF_MDF for links of multibodies).
  void find_contacts(std::vector<RigidPair> pairs, btScalar time_step);
  using Meeting = std::pair<btSoftBody*, const btCollisionObject*>;
  /// Returns the pairs that the last find_contacts() has found to meet on their way, or to be in each other.
  Span<const Meeting> meetings() const { return meetings_; }

 private:
  /// A convex part of an object, numbered through the compounds that it is made of.
  using PartKey = std::pair<const btCollisionObject*, int>;
  using Shapes = RigidParts<PartKey, ConvexCore>;
  using ShapeContact = RigidContact<Shapes::Part>;
  /// A shape's id, its vertex, and the soft body's nodes there. Several pairs of triangles have it in common.
  using Place = std::tuple<std::uint32_t, std::uint32_t, const void*, const void*, const void*>;

  void require_shapes(Span<const RigidPair> pairs, btScalar time_step);
  void find_touches();
  void find_corner(const ShapeContact& found);
  void find_edge(const ShapeContact& found);
  void find_node(const ShapeContact& found);
  void add_face_touch(const ShapeContact& found, btSoftBody::Face& face, const btVector3& weights);

  const NodeEnds& ends_;
  WorldMirror& mirror_;
  const Settings& settings_;
  Query query_;
  Shapes shapes_;
  NativeTouches native_;
  std::set<Place> known_;  ///< of this step
  std::vector<Meeting> meetings_;
  RigidTouches touches_;
};

}  // namespace softcd::bullet
