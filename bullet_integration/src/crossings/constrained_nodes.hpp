#pragma once

#include <unordered_map>

#include "BulletSoftBody/btSoftBody.h"

namespace softcd::bullet {

/// The directions in which Bullet's solver has said how a node moves: along normals of contacts with rigid objects, or
/// in all three where an anchor moves it.
class NodeConstraint {
 public:
  void add_direction(const btVector3& direction);
  void anchor();

  bool is_anchored() const { return is_anchored_; }
  int count() const { return count_; }
  /// Orthonormal.
  const btVector3& direction(int i) const { return directions_[i]; }
  /// What a change of velocity leaves of itself.
  btVector3 free_part(const btVector3& change) const;

 private:
  btVector3 directions_[3];
  int count_ = 0;
  bool is_anchored_ = false;
};

/// Whether others say where the node goes; `constraint` may be null.
inline bool is_moved_by_others(const btSoftBody::Node& node, const NodeConstraint* constraint) {
  return !(node.m_im > 0) || (constraint != nullptr && constraint->is_anchored());
}

/// The nodes of the deformable world with Node::m_constrained. In these directions answers to crossings leave their
/// velocities alone, so that nothing is pushed into what is rigid. In others the nodes are as movable as their mass
/// is: taken for immovable they would push what is in their way, and add energy.
class ConstrainedNodes {
 public:
  void clear() { constraints_.clear(); }
  /// Reads the body's contacts.
  void add(const btSoftBody& body);
  /// Null where the node is free. Valid until clear().
  const NodeConstraint* find(const btSoftBody::Node& node) const;

 private:
  void add_direction(const btSoftBody::Node& node, const btVector3& direction);

  std::unordered_map<const btSoftBody::Node*, NodeConstraint> constraints_;
};

}  // namespace softcd::bullet
