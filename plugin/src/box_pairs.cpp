#include "box_pairs.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "softcd/core/parallel.hpp"

namespace softcd {
namespace {

/// Fewer boxes take less time than waking other threads.
constexpr std::size_t kManyBoxes = 8192;
constexpr std::size_t kLeavesOfPart = 512;

float component(Vec3f v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

}  // namespace

Span<const IndexPair> BoxPairs::find(Span<const Box> boxes, Span<const std::uint32_t> groups) {
  const bool is_known = is_arranged_ && std::equal(groups_.begin(), groups_.end(), groups.begin(), groups.end());
  if (!is_known || !place(boxes)) arrange(boxes, groups);
  bound_nodes();
  const std::uint64_t visits = find_in_leaves();
  least_visits_ = std::min(least_visits_, visits);
  is_arranged_ = visits <= least_visits_ + least_visits_ / 2;
  put_in_order(boxes.size());
  return pairs_;
}

/// Returns whether the tree has exactly the boxes that are not empty.
bool BoxPairs::place(Span<const Box> boxes) {
  const auto count = static_cast<std::size_t>(
      std::count_if(boxes.begin(), boxes.end(), [](const Box& box) { return !is_empty(box); }));
  if (count != order_.size()) return false;
  placed_.resize(count);
  bool is_complete = true;
  for (std::size_t k = 0; k < count && is_complete; ++k) {
    is_complete = order_[k] < boxes.size();
    if (!is_complete) break;
    placed_[k] = boxes[order_[k]];
    is_complete = !is_empty(placed_[k]);
  }
  return is_complete;
}

/// Divides each group's boxes in halves, by their lower coordinates, until few are left.
void BoxPairs::arrange(Span<const Box> boxes, Span<const std::uint32_t> groups) {
  is_arranged_ = false;
  groups_.assign(groups.begin(), groups.end());
  order_.clear();
  nodes_.clear();
  leaves_.clear();
  least_visits_ = std::numeric_limits<std::uint64_t>::max();
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    if (!is_empty(boxes[i])) order_.push_back(i);
  }
  const auto group_of = [&](std::size_t k) { return groups_.empty() ? 0U : groups_[order_[k]]; };
  if (!groups_.empty()) {
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return groups_[a] != groups_[b] ? groups_[a] < groups_[b] : a < b;
    });
  }
  for (std::uint32_t begin = 0, end = 0; begin < order_.size(); begin = end) {
    while (end < order_.size() && group_of(end) == group_of(begin)) ++end;
    divide(boxes, begin, end);
    const std::size_t first_leaf = leaves_.size();
    append_nodes(begin, end);
    for (std::size_t i = first_leaf; i < leaves_.size(); ++i) {
      leaves_[i].tree_end = static_cast<std::uint32_t>(nodes_.size());
    }
  }
  place(boxes);
}

void BoxPairs::divide(Span<const Box> boxes, std::uint32_t begin, std::uint32_t end) {
  if (end - begin <= kLeafSize) return;
  Box corners = box_of(boxes[order_[begin]].lo);
  for (std::uint32_t k = begin + 1; k < end; ++k) corners = merged(corners, box_of(boxes[order_[k]].lo));
  const Vec3f spread = corners.hi - corners.lo;
  const int axis = spread.x >= spread.y && spread.x >= spread.z ? 0 : spread.y >= spread.z ? 1 : 2;
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::uint32_t k) { return order_.begin() + k; };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return component(boxes[a].lo, axis) < component(boxes[b].lo, axis);
  });
  const auto divide_first = [&] { divide(boxes, begin, middle); };
  const auto divide_second = [&] { divide(boxes, middle, end); };
  if (end - begin > kManyBoxes) {
    parallel::invoke(divide_first, divide_second);
  } else {
    divide_first();
    divide_second();
  }
}

/// Appends the nodes of boxes that divide() has divided.
void BoxPairs::append_nodes(std::uint32_t begin, std::uint32_t end) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({Box{}, begin, end, 0});
  if (nodes_.back().is_leaf()) {
    leaves_.push_back({index, 0});
  } else {
    const std::uint32_t middle = begin + (end - begin) / 2;
    append_nodes(begin, middle);
    append_nodes(middle, end);
  }
  nodes_[index].next = static_cast<std::uint32_t>(nodes_.size());
}

void BoxPairs::bound_nodes() {
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (node.is_leaf()) {
      node.bounds = std::accumulate(placed_.begin() + node.begin + 1, placed_.begin() + node.end, placed_[node.begin],
                                    [](const Box& a, const Box& b) { return merged(a, b); });
    } else {
      const Node& first_half = nodes_[i + 1];
      node.bounds = merged(first_half.bounds, nodes_[first_half.next].bounds);
    }
  }
}

/// Finds the pairs of all leaves. Returns the number of visited nodes.
std::uint64_t BoxPairs::find_in_leaves() {
  const std::size_t part_count = (leaves_.size() + kLeavesOfPart - 1) / kLeavesOfPart;
  parts_.resize(part_count);
  const auto find_part = [this](std::size_t part) {
    Found& found = parts_[part];
    found.pairs.clear();
    found.visits = 0;
    const std::size_t end = std::min(leaves_.size(), (part + 1) * kLeavesOfPart);
    for (std::size_t i = part * kLeavesOfPart; i < end; ++i) find_from(leaves_[i], found);
  };
  if (order_.size() < kManyBoxes) {
    for (std::size_t part = 0; part < part_count; ++part) find_part(part);
  } else {
    parallel::for_each(part_count, find_part);
  }
  return std::accumulate(parts_.begin(), parts_.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const Found& found) { return sum + found.visits; });
}

/// Finds pairs within the leaf, and with leaves behind it.
void BoxPairs::find_from(const Leaf& leaf, Found& found) const {
  const Node& from = nodes_[leaf.node];
  const auto append_if = [&](std::uint32_t k, std::uint32_t m) {
    if (!overlap(placed_[k], placed_[m])) return;
    found.pairs.emplace_back(std::min(order_[k], order_[m]), std::max(order_[k], order_[m]));
  };
  for (std::uint32_t k = from.begin; k < from.end; ++k) {
    for (std::uint32_t m = k + 1; m < from.end; ++m) append_if(k, m);
  }
  for (std::uint32_t i = leaf.node + 1; i < leaf.tree_end;) {
    const Node& node = nodes_[i];
    ++found.visits;
    const bool meets = overlap(from.bounds, node.bounds);
    for (std::uint32_t k = from.begin; meets && node.is_leaf() && k < from.end; ++k) {
      if (!overlap(placed_[k], node.bounds)) continue;
      for (std::uint32_t m = node.begin; m < node.end; ++m) append_if(k, m);
    }
    i = meets ? i + 1 : node.next;
  }
}

/// Sorts the pairs: a counting sort by the first box, then a sort of the few pairs of each first box.
void BoxPairs::put_in_order(std::size_t box_count) {
  row_ends_.assign(box_count + 1, 0);
  for (const Found& found : parts_) {
    for (const IndexPair& pair : found.pairs) ++row_ends_[pair.first + 1];
  }
  std::partial_sum(row_ends_.begin(), row_ends_.end(), row_ends_.begin());
  pairs_.resize(row_ends_.back());
  for (const Found& found : parts_) {
    for (const IndexPair& pair : found.pairs) pairs_[row_ends_[pair.first]++] = pair;
  }
  IndexPair* begin = pairs_.data();
  for (std::size_t i = 0; i < box_count; ++i) {
    IndexPair* const end = pairs_.data() + row_ends_[i];
    if (end - begin > 1) std::sort(begin, end);
    begin = end;
  }
}

}  // namespace softcd
