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

  /// Returns whether the node has a contact with the touch's object that pushes it to the same side.
  bool hold(const btSoftBody::Node& node, const RigidTouch& touch) const;
  /// Returns whether the face has such a contact, or all its nodes with a weight are pushed in nearly the touch's
  /// direction, and so is the surface between them.
  bool hold(const btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch) const;

  /// Marks contacts of the node with the object that work against a new touch, in classic worlds only. There Bullet
  /// takes contacts from the end of the step, when a fast node has already passed, so their normals may push through
  /// the object. Contacts of the deformable world have the normal of the step's start. One that differs belongs to
  /// another side of the object, around which the body is bent; without it the object would sink in.
  void doubt(const btSoftBody::Node& node, const btCollisionObject& object);
  /// Removes the marked contacts from Bullet's arrays.
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
