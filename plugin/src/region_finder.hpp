#pragma once

#include <vector>

#include "intersection_curves.hpp"
#include "softcd/intersection_regions.hpp"
#include "surface_parts.hpp"

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

/// Finds all regions, by surface, other surface and lowest triangle. `without_curves` are pairs that may have regions
/// without a curve, ascending.
std::vector<FoundRegion> find_regions(Span<const Surface> surfaces, const IntersectionCurves& found,
                                      Span<const SurfacePair> without_curves);

}  // namespace softcd::detail
