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

/// Finds contacts that Bullet's test of nodes with convex shapes misses during a step: corners of shapes on faces of
/// soft bodies, edges on edges, and missed nodes.
class ConvexDetection {
 public:
  using Kind = NodeEnds;

  /// `ends`, `mirror` and `settings` must outlive it.
  ConvexDetection(const NodeEnds& ends, WorldMirror& mirror, const Settings& settings);
  ConvexDetection(const ConvexDetection&) = delete;
  ConvexDetection& operator=(const ConvexDetection&) = delete;

  void follow_settings();
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const { return query_.explain(); }
  /// Returns notes on the contacts that the last find_contacts() wrote, if Settings::read_out is on.
  const ContactNotes& notes() const { return touches_.notes(); }
  /// Appends missing contacts of these pairs, which Bullet has processed. They go to the bodies' m_rcontacts (with
  /// SDF_RS), or to m_nodeRigidContacts and m_faceRigidContacts (with SDF_RD and SDF_RDN; SDF_RDF for rigid bodies,
  /// SDF_MDF for links of multibodies).
  void find_contacts(std::vector<RigidPair> pairs, btScalar time_step);
  using Meeting = std::pair<btSoftBody*, const btCollisionObject*>;
  /// Returns the pairs that, by the last find_contacts(), meet on their paths or intersect.
  Span<const Meeting> meetings() const { return meetings_; }

 private:
  /// Identifies a convex part of an object by its number among the simple shapes of the object's compounds.
  using PartKey = std::pair<BodyKey, int>;
  using Shapes = RigidParts<PartKey, ConvexCore>;
  using ShapeContact = RigidContact<Shapes::Part>;
  /// A shape's id, its vertex, and the soft body's nodes there. Several pairs of triangles can have the same place.
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
