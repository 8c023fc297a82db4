#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <tuple>
#include <vector>

#include "box_pairs.hpp"
#include "intersection_curves.hpp"
#include "softcd/math/box.hpp"

namespace softcd::detail {

/// Disjoint sets of vertices, each named by its lowest vertex.
class VertexSets {
 public:
  explicit VertexSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0U); }

  std::uint32_t find(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Returns the box of a surface's faces.
Box box_of_surface(const Surface& surface);

/// A surface, and the other one, or itself, that it may intersect: numbers of bodies.
struct SurfacePair {
  std::uint32_t surface, other;

  friend bool operator==(const SurfacePair&, const SurfacePair&) = default;
  friend bool operator<(const SurfacePair& a, const SurfacePair& b) {
    return std::tie(a.surface, a.other) < std::tie(b.surface, b.other);
  }
};

/// The connected parts of surfaces, kept as long as no mesh changes.
class SurfaceParts {
 public:
  /// Forgets all parts if the revision of the meshes is another one than at the last call.
  void follow(std::uint64_t revision);
  /// Returns the pairs that may have regions without a curve: a part of the first surface is within the box of the
  /// second, which is closed. Ascending.
  std::vector<SurfacePair> pairs_within_boxes(Span<const Surface> surfaces, const ProbeBodies& asked);

 private:
  /// The part of each vertex; numbered in the order of their first vertices, kNoIndex without a triangle.
  using PartOfVertex = std::vector<std::uint32_t>;
  const PartOfVertex& parts_of(const Surface& surface);

  BoxPairs box_pairs_;
  std::uint64_t revision_ = 0;
  std::map<std::uint32_t, PartOfVertex> parts_;  ///< by ids of bodies
};

}  // namespace softcd::detail
