#include "curve_length.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace softcd::detail {

Vec3d point_of(const CurveNode& node, Span<const Surface> surfaces) {
  const Surface& surface = surfaces[node.edge.surface];
  const Vec3d p = surface.position(node.edge.v[0]);
  if (node.is_vertex()) return p;
  const Vec3d q = surface.position(node.edge.v[1]);
  const Surface& pierced = surfaces[node.triangle.surface];
  const Triangle triangle = pierced.triangle(node.triangle.triangle);
  const Vec3d a = pierced.position(triangle.v[0]);
  const Vec3d normal = cross(pierced.position(triangle.v[1]) - a, pierced.position(triangle.v[2]) - a);
  const double from = dot(normal, p - a);
  const double to = dot(normal, q - a);
  const double share = from == to ? 0.5 : std::clamp(from / (from - to), 0.0, 1.0);
  return lerp(p, q, share);
}

double length_of(const Curve& curve, const IntersectionCurves& found, Span<const Surface> surfaces) {
  double length = 0;
  const std::size_t count = curve.nodes.size();
  for (std::size_t i = 0; i + 1 < count + (curve.is_closed ? 1 : 0); ++i) {
    const Vec3d from = point_of(found.nodes[curve.nodes[i]], surfaces);
    const Vec3d to = point_of(found.nodes[curve.nodes[(i + 1) % count]], surfaces);
    length += std::sqrt(squared_norm(to - from));
  }
  return length;
}

namespace {

Vec3d unit(Vec3d v) {
  const double length = std::sqrt(squared_norm(v));
  return length > 0 ? (1.0 / length) * v : Vec3d{0, 0, 0};
}

/// Returns the weights of a point in a triangle's plane, or thirds where the triangle has no area.
std::array<double, 3> weights_of(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d normal = cross(b - a, c - a);
  const double squared = squared_norm(normal);
  if (!(squared > 0)) return {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0};
  const double second = std::clamp(dot(cross(p - a, c - a), normal) / squared, 0.0, 1.0);
  const double third = std::clamp(dot(cross(b - a, p - a), normal) / squared, 0.0, 1.0 - second);
  return {1.0 - second - third, second, third};
}

}  // namespace

std::vector<LengthGradient> length_gradient(const Curve& curve, const IntersectionCurves& found,
                                            Span<const Surface> surfaces) {
  std::vector<LengthGradient> parts;
  const std::size_t count = curve.nodes.size();
  for (std::size_t i = 0; i < count; ++i) {
    const CurveNode& node = found.nodes[curve.nodes[i]];
    const Vec3d p = point_of(node, surfaces);
    // The sum of the unit vectors along the curve: the point moves by d, and the length grows by -(along . d).
    Vec3d along{0, 0, 0};
    if (i > 0 || curve.is_closed)
      along = unit(point_of(found.nodes[curve.nodes[(i + count - 1) % count]], surfaces) - p);
    if (i + 1 < count || curve.is_closed) {
      along = along + unit(point_of(found.nodes[curve.nodes[(i + 1) % count]], surfaces) - p);
    }
    const Surface& of_edge = surfaces[node.edge.surface];
    if (node.is_vertex()) {
      parts.push_back({node.edge.surface, node.edge.v[0], -along});
      continue;
    }
    const Vec3d from = of_edge.position(node.edge.v[0]);
    const Vec3d to = of_edge.position(node.edge.v[1]);
    const Surface& of_triangle = surfaces[node.triangle.surface];
    const Triangle triangle = of_triangle.triangle(node.triangle.triangle);
    const Vec3d a = of_triangle.position(triangle.v[0]);
    const Vec3d b = of_triangle.position(triangle.v[1]);
    const Vec3d c = of_triangle.position(triangle.v[2]);
    const Vec3d normal = unit(cross(b - a, c - a));
    const Vec3d edge = unit(to - from);
    const double slope = dot(normal, edge);
    constexpr double kFlattest = 1e-6;  // the point of a flatter edge moves too fast for a linear estimate
    if (!(std::abs(slope) > kFlattest)) continue;
    // If the edge moves by u and the triangle by w, then d = u - edge (normal . (u - w)) / slope.
    const Vec3d by_triangle = (-dot(along, edge) / slope) * normal;
    const Vec3d by_edge = -along - by_triangle;
    const double length = std::sqrt(squared_norm(to - from));
    const double share = length > 0 ? std::clamp(dot(p - from, edge) / length, 0.0, 1.0) : 0.5;
    parts.push_back({node.edge.surface, node.edge.v[0], (1.0 - share) * by_edge});
    parts.push_back({node.edge.surface, node.edge.v[1], share * by_edge});
    const std::array<double, 3> weights = weights_of(p, a, b, c);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      parts.push_back({node.triangle.surface, triangle.v[corner], weights[corner] * by_triangle});
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const LengthGradient& a, const LengthGradient& b) {
    return std::pair(a.surface, a.vertex) < std::pair(b.surface, b.vertex);
  });
  std::vector<LengthGradient> sums;
  for (const LengthGradient& part : parts) {
    if (!sums.empty() && sums.back().surface == part.surface && sums.back().vertex == part.vertex) {
      sums.back().gradient = sums.back().gradient + part.gradient;
    } else {
      sums.push_back(part);
    }
  }
  return sums;
}

}  // namespace softcd::detail
