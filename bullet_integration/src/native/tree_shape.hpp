#pragma once

#include <utility>
#include <vector>

#include "softcd/core/types.hpp"

/// The shape of the trees that Bullet builds for the nodes and faces of soft bodies (btSoftBody::initializeFaceTree).
/// Bullet's test with rigid objects appends contacts in the order of these trees, and its solver depends on that order.
namespace softcd::bullet {

/// For each of some things the places of its neighbours.
class NeighbourLists {
 public:
  /// `pairs` are of neighbours. Each list has the order of the pairs.
  NeighbourLists(int count, Span<const std::pair<int, int>> pairs);

  int count() const { return static_cast<int>(first_.size()) - 1; }
  Span<const int> of(int place) const;
  /// Sorts each list. Duplicates go.
  void sort();

 private:
  std::vector<int> first_;  ///< one more than there are things
  std::vector<int> neighbours_;
};

/// Returns whether every thing can be reached from every other one, from neighbour to neighbour.
bool is_connected(const NeighbourLists& lists);

/// Children of a tree's inner nodes, each after its own children: the n-th inner node is number lists.count() + n.
using TreeShape = std::vector<std::pair<int, int>>;

/// Joins, round by round, each tree with its first neighbour that is not joined yet, as Bullet does. Where that leads
/// nowhere (Bullet would never end) or is slow, joins trees in their order. Takes time n log n.
TreeShape tree_shape(NeighbourLists lists);

}  // namespace softcd::bullet
