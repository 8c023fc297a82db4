#pragma once

#include <unordered_map>
#include <vector>

#include "crossings/crossings_of_kind.hpp"

namespace softcd::bullet {

/// The impulse that the last pass of a step gave to a soft body because of another object, soft or rigid.
struct CrossingImpulse {
  const btSoftBody* body;
  const btCollisionObject* other;
  btVector3 on_body;
};

/// Measures the impulses of the last pass for each pair of objects. The change of a node's momentum is divided equally
/// among the objects that the node would have met.
class CrossingImpulses {
 public:
  void clear();
  /// Records that the node would have met the object.
  void add(const btSoftBody::Node& node, const btCollisionObject& other);
  /// Computes the impulses, after the pass.
  void measure(const CrossingsOfKind& kind, const AnsweredBodies& answered, btScalar time_step);

  /// Returns one impulse for each body and object that would have met.
  const std::vector<CrossingImpulse>& impulses() const { return impulses_; }

 private:
  using Objects = std::vector<const btCollisionObject*>;

  Objects all_others(const btSoftBody& body) const;

  std::unordered_map<const btSoftBody::Node*, Objects> others_;
  std::vector<CrossingImpulse> impulses_;
};

}  // namespace softcd::bullet
