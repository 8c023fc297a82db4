#pragma once

#include <vector>

#include "intersection_curves.hpp"
#include "softcd/intersection_regions.hpp"

namespace softcd::detail {

/// A region before its vertices have a way out.
struct FoundRegion {
  std::uint32_t surface = 0, other = 0;  ///< numbers of bodies
  RegionKind kind = RegionKind::closed;
  bool is_inside = false;
  std::vector<std::uint32_t> vertices, triangles, curves;  ///< ascending, each once
  /// Triangles of the surface along the curves' other traces, where a body intersects itself.
  std::vector<std::uint32_t> opposite;
  double area = 0;
};

/// A surface, and the other one, or itself, that it may intersect: numbers of bodies.
struct SurfacePair {
  std::uint32_t surface, other;

  friend auto operator<=>(const SurfacePair&, const SurfacePair&) = default;
};

/// Returns the pairs that may have regions without a curve: the first surface reaches into the box of the second, which
/// is closed. Ascending.
std::vector<SurfacePair> pairs_within_boxes(Span<const Surface> surfaces);

/// Finds all regions, by surface, other surface and lowest triangle. `without_curves` are pairs that may have regions
/// without a curve, ascending.
std::vector<FoundRegion> find_regions(Span<const Surface> surfaces, const IntersectionCurves& found,
                                      Span<const SurfacePair> without_curves);

/// Returns the point of a node on its edge, relative to the scene's origin.
Vec3d point_of(const CurveNode& node, Span<const Surface> surfaces);

/// A vertex's part of the gradient of a curve's length.
struct LengthGradient {
  std::uint32_t surface, vertex;
  Vec3d gradient;
};

/// Returns the gradient of a curve's length for the vertices of its edges and triangles, each once, ascending.
std::vector<LengthGradient> length_gradient(const Curve& curve, const IntersectionCurves& found,
                                            Span<const Surface> surfaces);

double length_of(const Curve& curve, const IntersectionCurves& found, Span<const Surface> surfaces);

}  // namespace softcd::detail
