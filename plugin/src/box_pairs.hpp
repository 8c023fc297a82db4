#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "softcd/core/span.hpp"
#include "softcd/math/box.hpp"

namespace softcd {

/// Two indices, the lower one first.
using IndexPair = std::pair<std::uint32_t, std::uint32_t>;

/// Returns whether the box is empty: lo.x is above hi.x. An empty box overlaps nothing.
constexpr bool is_empty(const Box& box) {
  return !(box.lo.x <= box.hi.x);
}

/// Finds pairs of overlapping boxes, call after call. Boxes are the leaves of a tree. Its order serves later calls,
/// until boxes have moved so far that it has become slow, or other boxes are given.
class BoxPairs {
 public:
  /// Returns all pairs of overlapping boxes within a group, ascending. Valid until the next call. Empty boxes overlap
  /// nothing. `groups` is empty where there is only one group.
  Span<const IndexPair> find(Span<const Box> boxes, Span<const std::uint32_t> groups = {});

 private:
  /// A node: boxes [begin, end) in the tree's order. Its two halves follow it. `next` is the first node behind its
  /// subtree.
  struct Node {
    Box bounds;
    std::uint32_t begin, end, next;

    bool is_leaf() const { return end - begin <= kLeafSize; }
  };
  /// A leaf, and the first node behind its group's tree.
  struct Leaf {
    std::uint32_t node, tree_end;
  };
  /// The pairs found from some of the leaves.
  struct Found {
    std::vector<IndexPair> pairs;
    std::uint64_t visits = 0;  ///< of nodes
  };

  static constexpr std::uint32_t kLeafSize = 4;

  bool place(Span<const Box> boxes);
  void arrange(Span<const Box> boxes, Span<const std::uint32_t> groups);
  void divide(Span<const Box> boxes, std::uint32_t begin, std::uint32_t end);
  void append_nodes(std::uint32_t begin, std::uint32_t end);
  void bound_nodes();
  std::uint64_t find_in_leaves();
  void find_from(const Leaf& leaf, Found& found) const;
  void put_in_order(std::size_t box_count);

  // The tree:
  bool is_arranged_ = false;
  std::vector<std::uint32_t> groups_;  ///< the groups for which the tree was made
  std::vector<std::uint32_t> order_;   ///< boxes that are not empty, group by group
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::uint64_t least_visits_ = 0;  ///< fewest visits of a call since the tree was made
  // Data of the last call:
  std::vector<Box> placed_;  ///< boxes in the tree's order
  std::vector<Found> parts_;
  std::vector<std::uint64_t> row_ends_;
  std::vector<IndexPair> pairs_;
};

}  // namespace softcd
