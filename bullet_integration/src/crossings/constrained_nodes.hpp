#pragma once

#include <unordered_map>

#include "BulletSoftBody/btSoftBody.h"

namespace softcd::bullet {

/// The directions in which Bullet's solver prescribes a node's motion: along normals of contacts with rigid objects, or
/// in all three dimensions if an anchor moves the node.
class NodeConstraint {
 public:
  void add_direction(const btVector3& direction);
  void anchor();

  bool is_anchored() const { return is_anchored_; }
  int count() const { return count_; }
  /// Returns one of the directions, which are orthonormal.
  const btVector3& direction(int i) const { return directions_[i]; }
  /// Returns the part of a change of velocity that lies in none of the directions.
  btVector3 free_part(const btVector3& change) const;

 private:
  btVector3 directions_[3];
  int count_ = 0;
  bool is_anchored_ = false;
};

/// Returns whether responses cannot move the node: it has no mass, or an anchor moves it. `constraint` may be null.
inline bool is_moved_by_others(const btSoftBody::Node& node, const NodeConstraint* constraint) {
  return !(node.m_im > 0) || (constraint != nullptr && constraint->is_anchored());
}

/// The nodes of the deformable world with Node::m_constrained. Responses to crossings do not change their velocities in
/// the prescribed directions, so that no node is pushed into a rigid object. In other directions the nodes move by
/// their mass. If they counted as immovable, they would push other nodes away and add energy.
class ConstrainedNodes {
 public:
  void clear() { constraints_.clear(); }
  /// Reads the body's contacts and anchors.
  void add(const btSoftBody& body);
  /// Returns null if the node is free. Valid until clear().
  const NodeConstraint* find(const btSoftBody::Node& node) const;

 private:
  void add_direction(const btSoftBody::Node& node, const btVector3& direction);

  std::unordered_map<const btSoftBody::Node*, NodeConstraint> constraints_;
};

}  // namespace softcd::bullet
