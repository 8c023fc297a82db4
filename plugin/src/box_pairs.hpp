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

/// A box whose lo.x is above its hi.x overlaps nothing.
constexpr bool is_empty(const Box& box) {
  return !(box.lo.x <= box.hi.x);
}

/// Pairs of boxes that overlap, call after call. Boxes stand in the leaves of a tree, whose order serves the next call
/// as well, until boxes have moved so far that it has become slow, or are others.
class BoxPairs {
 public:
  /// All pairs of one group's boxes that overlap, ascending; valid until the next call. Empty boxes overlap nothing.
  /// `groups` are empty where there is one.
  Span<const IndexPair> find(Span<const Box> boxes, Span<const std::uint32_t> groups = {});

 private:
  /// Boxes [begin, end) in the tree's order. Its halves follow it; the first node that is no part of it is `next`.
  struct Node {
    Box bounds;
    std::uint32_t begin, end, next;

    bool is_leaf() const { return end - begin <= kLeafSize; }
  };
  /// A leaf, and the first node that is no part of its group's tree.
  struct Leaf {
    std::uint32_t node, tree_end;
  };
  /// What some of the leaves have found.
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
  std::vector<std::uint32_t> groups_;  ///< that it was made of
  std::vector<std::uint32_t> order_;   ///< boxes that are not empty, one group after the other
  std::vector<Node> nodes_;
  std::vector<Leaf> leaves_;
  std::uint64_t least_visits_ = 0;  ///< by one call, since it was made
  // Of the last call:
  std::vector<Box> placed_;  ///< boxes in the tree's order
  std::vector<Found> parts_;
  std::vector<std::uint64_t> row_ends_;
  std::vector<IndexPair> pairs_;
};

}  // namespace softcd
