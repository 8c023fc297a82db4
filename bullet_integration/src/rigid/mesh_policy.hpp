#pragma once

#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "contacts/contacts_of_kind.hpp"
#include "rigid/rigid_detection.hpp"

namespace softcd::bullet {

/// Contacts with rigid triangle meshes. A surface has no inside, so positions alone do not tell whether a body has
/// passed through it.
///
/// The contacts are those of nodes; of faces with SDF_RDN or SDF_RDF in the deformable world; and of links.
class MeshPolicy {
 public:
  using Shape = RigidMesh;
  using MeshContact = RigidContact<RigidMesh>;

  MeshPolicy(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& settings, RigidTouches& touches)
      : kind_(kind), mirror_(mirror), settings_(settings), touches_(touches) {}

  static QueryOptions options(const ContactsOfKind& kind, const Settings& settings);
  static bool is_on(const Settings& settings) { return settings.rigid_meshes; }
  static RigidParts<RigidMesh>& parts(RigidMirror& rigid) { return rigid.meshes; }
  static bool takes(const btSoftBody& soft) { return soft.m_nodes.size() > 0; }
  static RigidKey key_of(const RigidPair& pair) { return {BodyKey(*pair.object), pair.shape, pair.child, 0}; }

  /// Reads the mesh of these pairs. Reads it wholly if `reads_whole` returns true for one of them.
  void require(const RigidKey& key, Span<const RigidPair> pairs, btScalar time_step, const ReadsWhole& reads_whole,
               RigidParts<RigidMesh>& parts);
  void begin_contacts(Span<const NearRigidPart> near_parts, const TangledNodes* released);
  void take(const MeshContact& found);
  void end_contacts();
  void before_writing() {}

 private:
  struct NodeTouch {
    btSoftBody* soft;
    btSoftBody::Node* node;
    BodyId mesh;
    RigidTouch touch;
    btScalar depth_at_end;
  };
  struct EdgeTouch {
    btSoftBody::Face* face;  ///< at the edge, or representing the link
    RigidTouch touch;
    btVector3 weights;
    btScalar depth_at_end;
  };
  using EdgeTouches = std::vector<EdgeTouch>;

  bool is_released(const MeshContact& found) const;
  void find_node_touch(const MeshContact& found);
  void add_node_touches();
  void find_face_touch(const MeshContact& found);
  void find_edge_touch(const MeshContact& found);
  void add_corner_touches();
  void add_edge_touches();
  bool are_held(const btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch,
                btScalar least_cosine) const;

  const ContactsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  RigidTouches& touches_;
  // Members of find_contacts():
  const TangledNodes* released_ = nullptr;
  bool tests_edges_ = false;
  std::vector<NodeTouch> node_touches_;                  ///< of one node with one mesh
  std::vector<RigidTouches::FaceTouch> corner_touches_;  ///< corners of meshes on faces
  /// Touches by the body's id, the edge, and the mesh's id.
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, EdgeTouches> edge_touches_;
  /// Normals of contacts by node and object.
  std::multimap<std::pair<const btSoftBody::Node*, const btCollisionObject*>, btVector3> node_normals_;
};

using RigidMeshDetection = RigidDetection<MeshPolicy>;

}  // namespace softcd::bullet
