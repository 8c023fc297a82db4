#pragma once

#include "LinearMath/btVector3.h"
#include "softcd/version.hpp"

class btSoftBody;

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// A contact between two edges, for which Bullet has no type. The point on an edge is
/// weights[0] * x(nodes[0]) + weights[1] * x(nodes[1]); weights are in [0, 1] and sum to 1.
struct EdgeContact {
  /// A point on an edge.
  struct Side {
    btSoftBody* body;     ///< in the world
    int nodes[2];         ///< in body->m_nodes
    btScalar weights[2];  ///< of these nodes at the contact
  };
  Side a;                   ///< one edge
  Side b;                   ///< the other one
  btVector3 normal;         ///< unit vector from b's point towards a's
  btScalar distance;        ///< between the two points at time_of_impact
  btScalar time_of_impact;  ///< in [0, 1] of the step; 1 for a discrete detection
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
