#pragma once

#include <initializer_list>

#include "LinearMath/btAabbUtil2.h"
#include "bodies/node_ends.hpp"

namespace softcd::bullet {

/// A box along the axes.
struct Bounds {
  btVector3 low, high;

  void add(const btVector3& point) {
    low.setMin(point);
    high.setMax(point);
  }
  void add(const Bounds& other) {
    low.setMin(other.low);
    high.setMax(other.high);
  }
  Bounds grown(const btVector3& by) const { return {low - by, high + by}; }
  Bounds grown(btScalar by) const { return grown(btVector3(by, by, by)); }
  bool overlaps(const Bounds& other) const { return TestAabbAgainstAabb2(low, high, other.low, other.high); }
};

/// Returns the box around the nodes in these positions. The body has nodes.
inline Bounds bounds_of(const btSoftBody& body, std::initializer_list<NodePosition> positions) {
  const btVector3& first = body.m_nodes[0].*(*positions.begin());
  Bounds bounds = {first, first};
  for (const btSoftBody::Node& node : span_of(body.m_nodes)) {
    for (const NodePosition position : positions) bounds.add(node.*position);
  }
  return bounds;
}

/// Returns the box of the shape in a pose.
inline Bounds bounds_of(const btCollisionShape& shape, const btTransform& pose) {
  Bounds bounds;
  shape.getAabb(pose, bounds.low, bounds.high);
  return bounds;
}

}  // namespace softcd::bullet
