#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "contacts/contact_notes.hpp"
#include "softcd/core/span.hpp"

class btRigidBody;

namespace softcd::bullet {

/// The nodes that movable rigid bodies back, in the deformable world, and the responses to their soft contacts.
///
/// Bullet (btSoftBody::applyRepulsionForce) leaves a node that touches a rigid object its velocity, and pushes the
/// other side twice as hard. That is momentum from nothing if the rigid object can move: boxes on piles of cloths push
/// these through each other. Here such a node takes part. A push towards a rigid body that can move gives node and
/// rigid body one velocity, as if the node's mass were both of theirs; the rigid body *backs* the node. Nodes on
/// anchors and nodes that touch other objects stay held as in Bullet.
class BackedNodes {
 public:
  /// Gets the impulses between nodes and the rigid bodies that back them.
  class Reader {
   public:
    /// `contact` is that of the node and the rigid body, which gets the opposite of `on_node`.
    virtual void read(const ContactSource& contact, const btSoftBody::Node& node, const btVector3& on_node) = 0;

   protected:
    ~Reader() = default;
  };

  /// No node is backed.
  BackedNodes() = default;
  /// Reads the contacts of all soft bodies of a world.
  explicit BackedNodes(Span<btSoftBody* const> bodies);

  /// Responds to the body's soft contacts, to those without backed nodes by Bullet's function. Allocates nothing.
  void respond(btSoftBody& body, btScalar time_step, bool with_springs) const;
  /// Does the same for a body with one soft contact. `reader` may be null.
  void respond_to_only(btSoftBody& body, btScalar time_step, bool with_springs, Reader* reader) const;

 private:
  using SoftContact = btSoftBody::DeformableFaceNodeContact;
  struct Backing {
    const btSoftBody::Node* node;
    btRigidBody* rigid;
    btVector3 normal;       ///< away from the rigid body
    btScalar inverse_mass;  ///< of the rigid body at the node, along the normal
    ContactSource contact;
  };

  void leave_out_held_nodes(Span<btSoftBody* const> bodies);
  void keep_first_of_each_pair();
  Span<const Backing> backings_of(const btSoftBody::Node& node) const;
  bool has_backed_node(const SoftContact& contact) const;
  bool is_held(const btSoftBody::Node& node) const;
  /// The node's speed away from its rigid body.
  static btScalar speed_apart(const Backing& backing);
  /// Calls visit(node, its share of the impulse on the contact's node) for the nodes that impulses move.
  template <class NodeVisit>
  void for_each_moved(const SoftContact& contact, const btVector3& impulse, const NodeVisit& visit) const;
  /// Returns the change of the relative velocity of node and face by an impulse of 1, along its direction.
  btScalar inverse_mass(const SoftContact& contact, const btVector3& direction) const;
  void push(const SoftContact& contact, const btVector3& impulse, Reader* reader) const;
  void respond_to(const SoftContact& contact, btScalar stiffness, btScalar time_step, Reader* reader) const;

  std::vector<Backing> backings_;  ///< ordered by node
  /// The order in which a body's contacts are answered, shuffled as Bullet does. It has a number for each contact of
  /// the body with most of them; others skip the numbers that they do not have.
  std::vector<int> order_;
};

}  // namespace softcd::bullet
