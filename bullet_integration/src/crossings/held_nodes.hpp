#pragma once

#include <unordered_set>
#include <vector>

#include "crossings/crossings_of_kind.hpp"

namespace softcd::bullet {

/// Nodes that stay where the step began, where no node crossed anything. This response always ends the search, because
/// the set only grows. The nodes keep the velocities of the earlier responses, so that holding them removes no
/// momentum. Only this step's motion is lost.
class HeldNodes {
 public:
  /// `kind` and `constrained` must outlive it.
  HeldNodes(const CrossingsOfKind& kind, const ConstrainedNodes& constrained)
      : kind_(kind), constrained_(constrained) {}

  bool empty() const { return nodes_.empty(); }
  std::size_t size() const { return nodes_.size(); }

  /// Holds the impacts' nodes. Returns false if all nodes that can be held are held already. Only the app, or the
  /// anchors' objects, could prevent the remaining impacts.
  bool add(const std::vector<Impact>& impacts);
  /// Holds all nodes of the impacts' bodies. Returns false as add() does.
  bool add_bodies(const std::vector<Impact>& impacts);
  /// Moves the held nodes' ends back. Call it after CrossingsOfKind::move_end.
  void put_back() const;

 private:
  bool add(btSoftBody::Node& node);

  const CrossingsOfKind& kind_;
  const ConstrainedNodes& constrained_;
  std::unordered_set<btSoftBody::Node*> nodes_;
};

}  // namespace softcd::bullet
