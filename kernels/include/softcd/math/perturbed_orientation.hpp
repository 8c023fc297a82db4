#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "softcd/math/intersection.hpp"

/// Finds the side of a plane on which a point lies, as if every coordinate were moved by an infinitesimal number of its
/// own: simulation of simplicity (Edelsbrunner and Muecke 1990). Different vertices are then never coplanar, so no case
/// is degenerate, and all results belong to one geometry.
///
/// Each body is first translated as a whole, then each vertex is moved by less. Bodies that touch are thus apart or
/// overlap along the whole of a common face. Lower bodies and lower vertices move by more, and x by more than y and z.
namespace softcd {

/// A vertex for perturbed_side(). No two vertices of a scene have the same body and index.
struct PerturbedPoint {
  Vec3d x;
  std::uint32_t body;
  std::uint32_t vertex;
};

/// The side of a plane: never 0.
struct PerturbedSide {
  int side;           ///< 1 or -1
  bool is_perturbed;  ///< the points are coplanar, and only the perturbation decides
};

namespace detail {

/// The infinitesimals of one coordinate in a product: 0 is none, 1 + b the translation of body b, 3 + i the motion of
/// point i. Each product has at most one for each axis, as the determinant is linear in each axis.
using PerturbedAxes = std::array<std::uint8_t, 3>;

constexpr std::size_t kPerturbedProducts = 7 * 7 * 7 - 1;

/// Returns all products of infinitesimals, the largest first. Infinitesimal k is e to the power of 2^k, so that a
/// product is as large as its binary number of infinitesimals is low.
constexpr std::array<PerturbedAxes, kPerturbedProducts> perturbed_products() {
  std::array<std::pair<std::uint32_t, PerturbedAxes>, kPerturbedProducts> products{};
  std::size_t count = 0;
  for (std::uint8_t x = 0; x < 7; ++x) {
    for (std::uint8_t y = 0; y < 7; ++y) {
      for (std::uint8_t z = 0; z < 7; ++z) {
        const PerturbedAxes axes{x, y, z};
        std::uint32_t size = 0;
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
          if (axes[axis] > 0) size |= 1U << (3 * (axes[axis] - 1U) + axis);
        }
        if (size != 0) products[count++] = {size, axes};
      }
    }
  }
  std::sort(products.begin(), products.end());
  std::array<PerturbedAxes, kPerturbedProducts> sorted{};
  for (std::size_t i = 0; i < kPerturbedProducts; ++i) sorted[i] = products[i].second;
  return sorted;
}

inline constexpr std::array<PerturbedAxes, kPerturbedProducts> kPerturbedProductsBySize = perturbed_products();

/// Returns the side of four coplanar points. The coefficient of a product is the determinant in which the axes' columns
/// are replaced by those of their infinitesimals: 1 for the points that it moves, else 0.
inline int side_by_perturbation(const std::array<PerturbedPoint, 4>& points) {
  std::array<std::uint32_t, 4> rank{};  // of the points, lower ones first
  std::array<bool, 4> is_of_second{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (const PerturbedPoint& other : points) {
      const bool is_lower =
          other.body < points[i].body || (other.body == points[i].body && other.vertex < points[i].vertex);
      rank[i] += is_lower ? 1U : 0U;
      is_of_second[i] |= other.body < points[i].body;
    }
  }
  for (const PerturbedAxes& axes : kPerturbedProductsBySize) {
    std::array<Vec3d, 4> x{};
    for (std::size_t i = 0; i < 4; ++i) {
      x[i] = points[i].x;
      for (int axis = 0; axis < 3; ++axis) {
        const std::uint32_t infinitesimal = axes[static_cast<std::size_t>(axis)];
        if (infinitesimal == 0) continue;
        const bool is_moved =
            infinitesimal < 3 ? is_of_second[i] == (infinitesimal == 2) : rank[i] == infinitesimal - 3;
        x[i] = with_coordinate(x[i], axis, is_moved ? 1.0 : 0.0);
      }
    }
    if (const int side = orientation(x[0], x[1], x[2], x[3]); side != 0) return side;
  }
  return 1;  // Not reached: three motions along different axes have the coefficient 1 or -1.
}

}  // namespace detail

/// Returns the sign of orientation(), with the perturbation where that is 0. The points must be different vertices of
/// at most two bodies.
inline PerturbedSide perturbed_side(const PerturbedPoint& a, const PerturbedPoint& b, const PerturbedPoint& c,
                                    const PerturbedPoint& d) {
  const int side = orientation(a.x, b.x, c.x, d.x);
  if (side != 0) return {side, false};
  return {detail::side_by_perturbation({a, b, c, d}), true};
}

}  // namespace softcd
