#pragma once

#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "contacts/contacts_of_kind.hpp"
#include "rigid/native_touches.hpp"
#include "rigid/rigid_detection.hpp"

namespace softcd::bullet {

/// Contacts that Bullet's test of nodes with convex shapes misses during a step, in pairs that Bullet has processed:
/// corners of shapes on faces of soft bodies, edges on edges, and missed nodes. In the deformable world, contacts of
/// faces need SDF_RDF for rigid bodies, and SDF_MDF for links of multibodies.
class ConvexPolicy {
 public:
  using Shape = ConvexCore;
  using ShapeContact = RigidContact<ConvexCore>;

  ConvexPolicy(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& /*settings*/, RigidTouches& touches)
      : ends_(kind.ends), mirror_(mirror), touches_(touches) {}

  static QueryOptions options(const ContactsOfKind& kind, const Settings& settings);
  static bool is_on(const Settings& settings) { return settings.convex_shapes != ConvexShapes::nodes; }
  static RigidParts<ConvexCore>& parts(RigidMirror& rigid) { return rigid.cores; }
  static bool takes(const btSoftBody& soft) { return soft.m_faces.size() > 0; }
  /// Returns a key of the whole object.
  static RigidKey key_of(const RigidPair& pair) { return {BodyKey(*pair.object), nullptr, 0, 0}; }

  /// Reads the object's shapes. They are identified by their number among the simple shapes of the object's compounds.
  void require(const RigidKey& key, Span<const RigidPair> pairs, btScalar time_step, const ReadsWhole& reads_whole,
               RigidParts<ConvexCore>& parts);
  void begin_contacts(Span<const NearRigidPart> near_parts, const TangledNodes* released);
  void take(const ShapeContact& found);
  void end_contacts() {}
  void before_writing() { native_.remove_doubted(); }

  using Meeting = std::pair<btSoftBody*, const btCollisionObject*>;
  /// Returns the pairs that, by the step's contacts, meet on their paths or intersect.
  Span<const Meeting> meetings() const { return meetings_; }

 private:
  /// A shape's id, its vertex, and the soft body's nodes there. Several pairs of triangles can have the same place.
  using Place = std::tuple<std::uint32_t, std::uint32_t, const void*, const void*, const void*>;

  void find_corner(const ShapeContact& found);
  void find_edge(const ShapeContact& found);
  void find_node(const ShapeContact& found);
  void add_face_touch(const ShapeContact& found, btSoftBody::Face& face, const btVector3& weights);

  const NodeEnds& ends_;
  WorldMirror& mirror_;
  RigidTouches& touches_;
  NativeTouches native_;
  std::set<Place> known_;  ///< of this step
  std::vector<Meeting> meetings_;
};

using ConvexDetection = RigidDetection<ConvexPolicy>;

}  // namespace softcd::bullet
