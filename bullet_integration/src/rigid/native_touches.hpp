#pragma once

#include <map>
#include <utility>
#include <vector>

#include "rigid/rigid_contact_writer.hpp"

namespace softcd::bullet {

/// The contacts of soft bodies with rigid objects that Bullet's own tests have found in a step.
class NativeTouches {
 public:
  void clear();
  void read(btSoftBody& body);

  /// Whether the node has a contact with the touch's object that pushes it to the same side.
  bool hold(const btSoftBody::Node& node, const RigidTouch& touch) const;
  /// Whether the face has one, or all of its nodes that have a weight are kept off in nearly the touch's direction, so
  /// that what is between them is, too.
  bool hold(const btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch) const;

  /// What stands in the way of a touch that they do not hold: contacts of the node with the object, of classic worlds,
  /// that push through it. Bullet takes those from the end of a step, where what is fast has passed already. Those of
  /// the deformable world have the normal of the start: one that differs is of another side of the object, around which
  /// the body is bent, and without it the object sinks in.
  void doubt(const btSoftBody::Node& node, const btCollisionObject& object);
  /// Takes what is doubted out of Bullet's arrays.
  void remove_doubted();

 private:
  struct Entry {
    btSoftBody* body;
    bool is_classic;  ///< in m_rcontacts
    int index;
    btVector3 normal;
  };
  using Key = std::pair<const void*, const btCollisionObject*>;
  template <class RigidContacts, class Feature>
  void add(btSoftBody& body, const RigidContacts& contacts, Feature feature, bool is_classic);
  bool has_within(const void* feature, const RigidTouch& touch, btScalar least_cosine) const;

  std::multimap<Key, Entry> entries_;
  std::vector<Entry> doubted_;
};

}  // namespace softcd::bullet
