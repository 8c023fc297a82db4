#pragma once

#include <cstdint>
#include <vector>

#include "intersection_curves.hpp"

namespace softcd::detail {

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

/// Returns the length of the polygon through a curve's points.
double length_of(const Curve& curve, const IntersectionCurves& found, Span<const Surface> surfaces);

}  // namespace softcd::detail
