#pragma once

#include <vector>

#include "bodies/node_ends.hpp"
#include "bodies/rigid_placement.hpp"
#include "contacts/contact_notes.hpp"
#include "rigid/rigid_contact_writer.hpp"

namespace softcd::bullet {

/// Returns whether the body's contacts with rigid objects belong into the deformable world's arrays. The body's flags
/// decide, not the world.
bool has_deformable_contacts(const btSoftBody& body);

/// Returns whether the node may have contacts with rigid objects.
bool takes_node_contacts(const btSoftBody& body, const btSoftBody::Node& node);

/// Returns the box around the nodes' positions at both ends of the step, enlarged by `margin`. The body has nodes.
Bounds swept_box(const btSoftBody& body, btScalar margin);

/// Returns the point with these weights of the face's nodes, at one end of the step.
btVector3 point_on(const btSoftBody::Face& face, const btVector3& weights, NodePosition position);
/// Returns the weights of the face's nodes for a point between two of the body's nodes that both are the face's.
btVector3 weights_on_edge(const btSoftBody::Face& face, const btSoftBody& body, const std::uint32_t* nodes,
                          const float* weights);

btVector3 weighted_point(const std::vector<Vec3d>& x, const std::uint32_t* vertices, const float* weights, int count);

/// The contacts of soft bodies with rigid objects in a step, until write() puts all of them into Bullet's arrays.
class RigidTouches {
 public:
  struct FaceTouch {
    btSoftBody* body;
    btSoftBody::Face* face;
    btVector3 weights;
    RigidTouch touch;
  };

  void clear();
  void add(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch);
  /// Adds a point of a face. `weights` are those of the face's nodes and sum to 1.
  void add(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch);

  /// Reserves memory for write(), which then throws nothing. Throws std::bad_alloc.
  void prepare_to_write(bool keeps_notes);
  /// Writes the contacts into m_rcontacts, or m_nodeRigidContacts and m_faceRigidContacts.
  void write();
  /// Returns the notes of write().
  const ContactNotes& notes() const { return notes_; }
  void forget_notes() { notes_.reset(0); }

 private:
  struct NodeTouch {
    btSoftBody* body;
    btSoftBody::Node* node;
    RigidTouch touch;
  };
  /// `distance` is that between the soft body and the place to which the solver moves it.
  void note(const btSoftBody& body, ContactArray array, int count_before, int count, const RigidTouch& touch,
            btScalar distance);

  std::vector<NodeTouch> node_touches_;
  std::vector<FaceTouch> face_touches_;
  bool keeps_notes_ = false;
  ContactNotes notes_;
};

}  // namespace softcd::bullet
