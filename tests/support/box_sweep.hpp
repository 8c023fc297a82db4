#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <numeric>
#include <span>
#include <vector>

#include "softcd/core/vec3.hpp"

namespace softcd::test {

struct SweepBox {
  Vec3d low;
  Vec3d high;
};

inline SweepBox enclosing(std::initializer_list<Vec3d> points, double reach = 0.0) {
  SweepBox box{*points.begin(), *points.begin()};
  for (const Vec3d p : points) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  const Vec3d grow{reach, reach, reach};
  return {box.low - grow, box.high + grow};
}

inline bool overlap(const SweepBox& a, const SweepBox& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y &&
         a.low.z <= b.high.z && b.low.z <= a.high.z;
}

inline std::vector<std::uint32_t> sorted_by_low_x(std::span<const SweepBox> boxes) {
  std::vector<std::uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return boxes[a].low.x < boxes[b].low.x; });
  return order;
}

/// Calls visit(i, j) for every overlapping pair of boxes a[i], b[j], each once. It is a sweep along x, which shares
/// nothing with the detector's grid.
template <class Visit>
void for_each_overlap(std::span<const SweepBox> a, std::span<const SweepBox> b, const Visit& visit) {
  const std::vector<std::uint32_t> order_a = sorted_by_low_x(a);
  const std::vector<std::uint32_t> order_b = sorted_by_low_x(b);
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < order_a.size() && j < order_b.size()) {
    const SweepBox& box_a = a[order_a[i]];
    const SweepBox& box_b = b[order_b[j]];
    if (box_a.low.x <= box_b.low.x) {
      for (std::size_t k = j; k < order_b.size() && b[order_b[k]].low.x <= box_a.high.x; ++k) {
        if (overlap(box_a, b[order_b[k]])) visit(order_a[i], order_b[k]);
      }
      ++i;
    } else {
      for (std::size_t k = i; k < order_a.size() && a[order_a[k]].low.x <= box_b.high.x; ++k) {
        if (overlap(a[order_a[k]], box_b)) visit(order_a[k], order_b[j]);
      }
      ++j;
    }
  }
}

}  // namespace softcd::test
