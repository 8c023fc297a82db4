#pragma once

#include <map>
#include <utility>
#include <vector>

#include "rigid_contact_writer.hpp"

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

  /// What stands in the way of a touch that they do not hold: contacts of the node or the face with the object that
  /// push through it. Bullet looks at one end of a step, where what is fast has passed already.
  void doubt(const void* feature, const btCollisionObject& object);
  /// Takes what is doubted out of Bullet's arrays.
  void remove_doubted();

 private:
  enum class Array { classic_node, node, face };
  struct Entry {
    btSoftBody* body;
    Array array;
    int index;
    btVector3 normal;
  };
  using Key = std::pair<const void*, const btCollisionObject*>;
  template <class RigidContact>
  void add(btSoftBody& body, Array array, int index, const void* feature, const RigidContact& contact);
  bool has_within(const void* feature, const RigidTouch& touch, btScalar least_cosine) const;

  std::multimap<Key, Entry> entries_;
  std::vector<Entry> doubted_;
};

}  // namespace softcd::bullet
