#pragma once

#include <unordered_set>
#include <vector>

#include "crossings/crossings_of_kind.hpp"

namespace softcd::bullet {

/// Nodes that stay where the step began, where no node passed through anything: the answer that ends the search for
/// one, as they only become more. Their velocities are those of the answers before, so that holding them takes no
/// momentum; only the way of this step is given up.
class HeldNodes {
 public:
  /// `kind` and `constrained` outlive it.
  HeldNodes(const CrossingsOfKind& kind, const ConstrainedNodes& constrained)
      : kind_(kind), constrained_(constrained) {}

  bool empty() const { return nodes_.empty(); }
  std::size_t size() const { return nodes_.size(); }

  /// Holds the impacts' nodes. False when all are held already that nobody else moves: the rest only whoever moves
  /// nodes without mass and anchors could prevent.
  bool add(const std::vector<Impact>& impacts);
  /// And all other nodes of the impacts' bodies.
  bool add_bodies(const std::vector<Impact>& impacts);
  /// Brings the nodes back, after CrossingsOfKind::move_end.
  void put_back() const;

 private:
  bool add(btSoftBody::Node& node);

  const CrossingsOfKind& kind_;
  const ConstrainedNodes& constrained_;
  std::unordered_set<btSoftBody::Node*> nodes_;
};

}  // namespace softcd::bullet
