#pragma once

#include <functional>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "contacts/contacts_of_kind.hpp"
#include "contacts/tangles.hpp"
#include "rigid/rigid_mesh.hpp"
#include "rigid/rigid_pairs.hpp"
#include "rigid/rigid_parts.hpp"
#include "rigid/rigid_touches.hpp"

namespace softcd::bullet {

/// Finds the contacts of soft bodies with rigid triangle meshes along the paths of a step, whatever Settings::detection
/// is. A surface has no inside, so positions alone do not tell whether a body has passed through it.
class RigidMeshDetection {
 public:
  using Kind = ContactsOfKind;

  /// `kind`, `mirror` and `settings` must outlive it.
  RigidMeshDetection(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& settings);
  RigidMeshDetection(const RigidMeshDetection&) = delete;
  RigidMeshDetection& operator=(const RigidMeshDetection&) = delete;

  void follow_settings();
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const { return query_.explain(); }
  /// Returns notes on the contacts that the last find_contacts() wrote, if Settings::read_out is on.
  const ContactNotes& notes() const { return touches_.notes(); }
  /// Reads the meshes of these pairs near their soft bodies. Reads a mesh wholly if `reads_whole` returns true for a
  /// soft body and a part of the last step.
  using ReadsWhole = std::function<bool(const btSoftBody&, BodyId part)>;
  void read(std::vector<RigidPair> pairs, btScalar time_step, const ReadsWhole& reads_whole);
  /// Returns the pairs of the last read().
  Span<const NearRigidPart> near_parts() const { return {near_parts_.data(), near_parts_.size()}; }
  /// Appends the contacts of these pairs to the bodies' m_rcontacts (with SDF_RS), or to m_nodeRigidContacts and
  /// m_faceRigidContacts (with SDF_RD and SDF_RDN, SDF_RDF). Leaves out `released` nodes; null if there are none.
  void find_contacts(const TangledNodes* released);

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
  using MeshKey = std::tuple<BodyKey, const btCollisionShape*, int>;
  using Meshes = RigidParts<MeshKey, RigidMesh>;
  using MeshContact = RigidContact<Meshes::Part>;

  void require_mesh(const MeshKey& key, Span<const RigidPair> pairs, btScalar time_step, const ReadsWhole& reads_whole);
  bool is_released(const MeshContact& found) const;
  void find_touches();
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
  Query query_;
  Meshes meshes_;
  std::vector<NearRigidPart> near_parts_;
  const TangledNodes* released_ = nullptr;               ///< in find_contacts()
  std::vector<NodeTouch> node_touches_;                  ///< of one node with one mesh
  std::vector<RigidTouches::FaceTouch> corner_touches_;  ///< corners of meshes on faces, in this step
  /// The touches of this step by the body's id, the edge, and the mesh's id.
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, EdgeTouches> edge_touches_;
  /// Normals of contacts by node and object.
  std::multimap<std::pair<const btSoftBody::Node*, const btCollisionObject*>, btVector3> node_normals_;
  RigidTouches touches_;
};

}  // namespace softcd::bullet
