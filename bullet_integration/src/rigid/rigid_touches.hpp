#pragma once

#include <vector>

#include "bodies/node_ends.hpp"
#include "contacts/contact_notes.hpp"
#include "rigid/rigid_contact_writer.hpp"
#include "rigid/rigid_placement.hpp"

namespace softcd::bullet {

/// Which of Bullet's arrays its contacts with rigid objects belong into is the body's own affair.
bool has_deformable_contacts(const btSoftBody& body);

/// Whether contacts of the node with rigid objects are asked for.
bool takes_node_contacts(const btSoftBody& body, const btSoftBody::Node& node);

/// Of everything that the body's nodes meet in the step. It has nodes.
RigidBox swept_box(const btSoftBody& body, btScalar margin);

/// Returns the point with these weights of the face's nodes, at one end of the step.
btVector3 point_on(const btSoftBody::Face& face, const btVector3& weights, NodePosition position);
/// Returns the weights of the face's nodes for a point between two of the body's nodes that both are the face's.
btVector3 weights_on_edge(const btSoftBody::Face& face, const btSoftBody& body, const std::uint32_t* nodes,
                          const float* weights);

btVector3 weighted_point(const std::vector<Vec3d>& x, const std::uint32_t* vertices, const float* weights, int count);

/// Where soft bodies touch rigid objects in a step, until all of it is written into Bullet's arrays at once.
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
  /// `weights` of the face's nodes, which sum to 1.
  void add(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch);

  /// Before write(), which then throws nothing. Throws std::bad_alloc.
  void prepare_to_write(bool keeps_notes);
  /// Puts them into m_rcontacts, or m_nodeRigidContacts and m_faceRigidContacts.
  void write();
  /// What write() noted.
  const ContactNotes& notes() const { return notes_; }
  void forget_notes() { notes_.reset(0); }

 private:
  struct NodeTouch {
    btSoftBody* body;
    btSoftBody::Node* node;
    RigidTouch touch;
  };
  /// `distance` is between the soft body and where the solver wants it to be.
  void note(const btSoftBody& body, ContactArray array, int count_before, int count, const RigidTouch& touch,
            btScalar distance);

  std::vector<NodeTouch> node_touches_;
  std::vector<FaceTouch> face_touches_;
  bool keeps_notes_ = false;
  ContactNotes notes_;
};

}  // namespace softcd::bullet
