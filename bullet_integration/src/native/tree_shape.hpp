#pragma once

#include <utility>
#include <vector>

#include "softcd/core/types.hpp"

/// The shape of the trees that Bullet builds for the nodes and faces of soft bodies (btSoftBody::initializeFaceTree).
/// Bullet's test with rigid objects appends contacts in the order of these trees, and its solver depends on that order.
namespace softcd::bullet {

/// Lists the places of the neighbours of each element.
class NeighbourLists {
 public:
  /// Each of `pairs` joins two neighbours. Each list has the order of the pairs.
  NeighbourLists(int count, Span<const std::pair<int, int>> pairs);

  int count() const { return static_cast<int>(first_.size()) - 1; }
  Span<const int> of(int place) const;
  /// Sorts each list and removes duplicates.
  void sort();

 private:
  std::vector<int> first_;  ///< one more than there are elements
  std::vector<int> neighbours_;
};

/// Returns whether every thing can be reached from every other one, from neighbour to neighbour.
bool is_connected(const NeighbourLists& lists);

/// The children of a tree's inner nodes. The n-th inner node has number lists.count() + n, and comes after its own
/// children.
using TreeShape = std::vector<std::pair<int, int>>;

/// Joins each tree with its first neighbour that is not joined yet, round by round, as Bullet does. If no neighbours
/// are left (Bullet would never end), or after many rounds, joins trees in their order. Takes time n log n.
TreeShape tree_shape(NeighbourLists lists);

}  // namespace softcd::bullet
