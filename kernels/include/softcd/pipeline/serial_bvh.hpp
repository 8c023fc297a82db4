#pragma once

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "softcd/stages/lbvh.hpp"

namespace softcd {

/// The hierarchy of Bvh in the host's memory, built and fitted on the calling thread. It is for a few thousand
/// triangles and single questions, for which a backend's threads and queues take longer than the answer.
class SerialBvh {
 public:
  void build(const BvhInput& input) {
    const std::uint32_t leaf_count = std::max(input.triangle_count, 2U);
    sort_leaves(input, leaf_count);
    leaves_.resize(leaf_count);
    nodes_.resize(leaf_count - 1);
    arrivals_.resize(leaf_count - 1);
    leaf_parents_.resize(leaf_count);
    const LinkNode link{keys_.data(), leaf_count, nodes_.data(), leaf_parents_.data()};
    for (std::uint32_t i = 0; i + 1 < leaf_count; ++i) link(i);
    fit_boxes(input);
    cost_when_built_ = cost();
  }

  /// Fits it to the current positions of the last build's triangles. Rebuilds it if its cost has doubled.
  void follow(const BvhInput& input) {
    fit_boxes(input);
    if (cost() > 2.0 * cost_when_built_) build(input);
  }

  BvhView view() const { return {nodes_.data(), leaves_.data()}; }
  /// Returns a box around all triangles.
  Box bounds() const { return merged(nodes_[0].boxes[0], nodes_[0].boxes[1]); }
  /// Returns the number of boxes that a ray through the bounds enters on average (MacDonald and Booth 1990).
  double cost() const {
    double area = 0.0;
    for (const BvhNode& node : nodes_) area += area_of(node.boxes[0]) + area_of(node.boxes[1]);
    const double whole = area_of(bounds());
    return whole > 0.0 ? area / whole : 0.0;
  }

 private:
  static double area_of(const Box& box) {
    if (box.lo.x > box.hi.x) return 0.0;
    const Vec3d size = vec3_cast<double>(box.hi) - vec3_cast<double>(box.lo);
    return size.x * size.y + size.y * size.z + size.z * size.x;
  }

  void sort_leaves(const BvhInput& input, std::uint32_t leaf_count) {
    keys_.resize(leaf_count);
    triangles_.resize(leaf_count);
    const KeyLeaf key_leaf{input, keys_.data(), triangles_.data()};
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order(leaf_count);
    for (std::uint32_t i = 0; i < leaf_count; ++i) {
      key_leaf(i);
      order[i] = {keys_[i], triangles_[i]};
    }
    std::sort(order.begin(), order.end());
    for (std::uint32_t i = 0; i < leaf_count; ++i) std::tie(keys_[i], triangles_[i]) = order[i];
  }

  void fit_boxes(const BvhInput& input) {
    const PlaceLeaf place{input, triangles_.data(), leaves_.data()};
    const FitBoxes fit{leaves_.data(), leaf_parents_.data(), nodes_.data(), arrivals_.data()};
    std::fill(arrivals_.begin(), arrivals_.end(), 0U);
    for (std::uint32_t i = 0; i < leaves_.size(); ++i) {
      place(i);
      fit(i);
    }
  }

  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> triangles_;  ///< of the leaves
  std::vector<BvhLeaf> leaves_;
  std::vector<BvhNode> nodes_;
  std::vector<std::uint32_t> leaf_parents_;
  std::vector<std::uint32_t> arrivals_;
  double cost_when_built_ = 0.0;
};

}  // namespace softcd
