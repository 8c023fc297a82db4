#include "box_pairs.hpp"

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>

namespace softcd {
namespace {

float component(Vec3f v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/// Boxes divided in halves by where they begin, until few are left.
class BoxTree {
 public:
  explicit BoxTree(const std::vector<Box>& boxes) : boxes_(boxes) {
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (boxes[i].lo.x <= boxes[i].hi.x) order_.push_back(i);
    }
    if (!order_.empty()) divide(0, order_.size());
  }

  /// Indices of the boxes that are not empty.
  const std::vector<std::uint32_t>& order() const { return order_; }

  template <class F>
  void for_each_overlapping(const Box& box, const F& f) const {
    for (std::size_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      const bool meets = overlap(box, node.bounds);
      if (meets && node.size() <= kLeafSize) {
        for (std::size_t k = node.begin; k < node.end; ++k) {
          if (overlap(box, boxes_[order_[k]])) f(order_[k]);
        }
      }
      i = meets ? i + 1 : node.next;
    }
  }

 private:
  static constexpr std::size_t kLeafSize = 4;

  /// Boxes order_[begin] to order_[end - 1]. Its halves follow it; the first node that is no part of it is `next`.
  struct Node {
    Box bounds;
    std::size_t begin, end, next;

    std::size_t size() const { return end - begin; }
  };

  void divide(std::size_t begin, std::size_t end) {
    const std::size_t index = nodes_.size();
    Box bounds = boxes_[order_[begin]];
    Box corners = box_of(bounds.lo);
    for (std::size_t k = begin + 1; k < end; ++k) {
      bounds = merged(bounds, boxes_[order_[k]]);
      corners = merged(corners, box_of(boxes_[order_[k]].lo));
    }
    nodes_.push_back({bounds, begin, end, 0});
    if (end - begin > kLeafSize) {
      const Vec3f spread = corners.hi - corners.lo;
      const int axis = spread.x >= spread.y && spread.x >= spread.z ? 0 : spread.y >= spread.z ? 1 : 2;
      const std::size_t middle = begin + (end - begin) / 2;
      const auto at = [&](std::size_t k) { return order_.begin() + static_cast<std::ptrdiff_t>(k); };
      std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
        return component(boxes_[a].lo, axis) < component(boxes_[b].lo, axis);
      });
      divide(begin, middle);
      divide(middle, end);
    }
    nodes_[index].next = nodes_.size();
  }

  const std::vector<Box>& boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<IndexPair> overlapping_pairs(const std::vector<Box>& boxes) {
  constexpr std::size_t kGrain = 256;
  const BoxTree tree(boxes);
  const std::vector<std::uint32_t>& order = tree.order();
  tbb::enumerable_thread_specific<std::vector<IndexPair>> parts;
  const auto find_pairs = [&](const tbb::blocked_range<std::size_t>& range) {
    std::vector<IndexPair>& found = parts.local();
    for (std::size_t k = range.begin(); k < range.end(); ++k) {
      const std::uint32_t i = order[k];
      tree.for_each_overlapping(boxes[i], [&](std::uint32_t j) {
        if (i < j) found.emplace_back(i, j);
      });
    }
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), kGrain), find_pairs);
  std::vector<IndexPair> pairs;
  for (const std::vector<IndexPair>& part : parts) pairs.insert(pairs.end(), part.begin(), part.end());
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace softcd
