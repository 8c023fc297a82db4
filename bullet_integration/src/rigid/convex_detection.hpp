#pragma once

#include <map>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "rigid/convex_core.hpp"
#include "rigid/native_touches.hpp"
#include "rigid/rigid_pairs.hpp"
#include "rigid/rigid_touches.hpp"

namespace softcd::bullet {

/// Finds what Bullet's test of nodes with convex shapes leaves out, on the way of a step: corners of the shapes against
/// faces of soft bodies, edges against edges, and nodes that the test has missed.
class ConvexDetection {
 public:
  using Kind = NodeEnds;

  /// `ends`, `mirror` and `settings` outlive it.
  ConvexDetection(const NodeEnds& ends, WorldMirror& mirror, const Settings& settings);
  ~ConvexDetection();
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
  struct Shape {
    BodyId id;
    ConvexCore core;
    const btCollisionObject* object;
    btScalar margin;
    bool is_present = false;
  };
  /// A convex part of an object, numbered through the compounds that it is made of.
  using PartKey = std::pair<const btCollisionObject*, int>;
  /// A shape's id, its vertex, and the soft body's nodes there. Several pairs of triangles have it in common.
  using Place = std::tuple<std::uint32_t, std::uint32_t, const void*, const void*, const void*>;
  struct Part {
    PartKey key;
    const btConvexShape* shape;
    btTransform shape_in_object;
  };

  static void add_parts(const btCollisionObject& object, const btCollisionShape& shape, const btTransform& place,
                        std::vector<Part>& parts);
  void synchronize_object(Span<const RigidPair> pairs, btScalar time_step);
  Shape& synchronize(const Part& part, const RigidPoses& poses);
  void remove_absent_shapes();
  void find_touches();
  void find_corner(const Contact& contact, const Shape& shape);
  void find_edge(const Contact& contact, const Shape* a);
  void find_node(const Contact& contact, const Shape& shape);
  void add_face_touch(const Shape& shape, btSoftBody& soft, btSoftBody::Face& face, const btVector3& weights,
                      RigidTouch touch);
  RigidTouch touch_of(const Contact& contact, const Shape& shape, const btSoftBody& soft, bool is_a) const;

  const NodeEnds& ends_;
  WorldMirror& mirror_;
  const Settings& settings_;
  Query query_;
  std::map<PartKey, Shape> shapes_;
  std::map<std::uint32_t, const Shape*> shapes_by_id_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted_;  ///< ids of pairs, ascending
  NativeTouches native_;
  std::set<Place> known_;  ///< of this step
  std::vector<Meeting> meetings_;
  RigidTouches touches_;
};

}  // namespace softcd::bullet
