#pragma once

#include <array>
#include <cstdint>
#include <tuple>
#include <vector>

#include "softcd/core/spatial_query.hpp"
#include "softcd/math/perturbed_orientation.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/topology.hpp"

namespace softcd::detail {

/// A body's surface. Positions are in world coordinates if they are `given`, else relative to the scene's origin; one
/// of both holds for all bodies. Bodies are numbered by ascending ids, vertices and triangles within their body.
struct Surface {
  BodyId id;
  std::uint32_t number = 0;
  MeshView mesh;
  Span<const Vec3f> x;
  Span<const Vec3d> given;  ///< the positions that `x` rounds, in world coordinates; empty where all of `x` is exact
  Span<const Ownership> ownership;
  bool is_closed = false;

  Triangle triangle(std::uint32_t t) const {
    const auto& v = mesh.triangles[t].v;
    return {{v[0] - mesh.first_vertex, v[1] - mesh.first_vertex, v[2] - mesh.first_vertex}};
  }
  /// Returns whether a triangle has three vertices, all with finite positions.
  bool has_face(std::uint32_t t) const {
    const auto& v = mesh.triangles[t].v;
    return v[0] != v[1] && v[1] != v[2] && v[2] != v[0] && (ownership[t] & kLeftOut) == 0;
  }
  PerturbedPoint point(std::uint32_t v) const { return {position(v), number, v}; }
  Vec3d position(std::uint32_t v) const { return given.empty() ? vec3_cast<double>(x[v]) : given[v]; }
};

struct SurfaceEdge {
  std::uint32_t surface;  ///< number of its body
  std::uint32_t v[2];     ///< v[0] < v[1]; equal at the end of a curve in a vertex

  friend bool operator<(const SurfaceEdge& a, const SurfaceEdge& b) {
    return std::tie(a.surface, a.v[0], a.v[1]) < std::tie(b.surface, b.v[0], b.v[1]);
  }
  friend bool operator==(const SurfaceEdge& a, const SurfaceEdge& b) = default;
};

struct SurfaceTriangle {
  std::uint32_t surface, triangle;

  friend bool operator<(const SurfaceTriangle& a, const SurfaceTriangle& b) {
    return std::tie(a.surface, a.triangle) < std::tie(b.surface, b.triangle);
  }
  friend bool operator==(const SurfaceTriangle& a, const SurfaceTriangle& b) = default;
};

/// An edge that passes through a triangle.
struct CurveNode {
  SurfaceEdge edge;
  SurfaceTriangle triangle;
  std::int8_t side = 0;  ///< of edge.v[0]: 1 behind the triangle, where its normal does not point; 0 at a vertex
  bool is_perturbed = false;

  bool is_vertex() const { return edge.v[0] == edge.v[1]; }
  friend bool operator<(const CurveNode& a, const CurveNode& b) {
    return std::tie(a.edge, a.triangle) < std::tie(b.edge, b.triangle);
  }
  friend bool operator==(const CurveNode& a, const CurveNode& b) {
    return a.edge == b.edge && a.triangle == b.triangle;
  }
};

/// One of the two lines that a curve draws on surfaces.
struct Trace {
  std::uint32_t surface = 0;             ///< number of its body
  std::vector<std::uint32_t> triangles;  ///< the triangles along it; may repeat
  std::vector<std::uint32_t> nodes;      ///< nodes whose edges it crosses
  bool ends_within = false;              ///< it ends within the surface, where the other surface has a border
  bool ends_at_border = false;           ///< it ends at the surface's border
};

/// The curve along which two surfaces, or a surface and itself, intersect.
struct Curve {
  std::uint32_t surface_a = 0, surface_b = 0;  ///< surface_a <= surface_b
  std::vector<std::uint32_t> nodes;            ///< in the order of the curve
  bool is_closed = false;
  bool is_branched = false;  ///< it ends at an edge of three or more triangles
  bool is_perturbed = false;
  std::array<Trace, 2> traces;  ///< of surface_a and of surface_b
};

/// All curves of some surfaces.
struct IntersectionCurves {
  std::vector<CurveNode> nodes;  ///< ascending
  std::vector<Curve> curves;     ///< by surfaces, then by nodes
  std::uint64_t touching_pairs = 0;
};

/// Returns the side of an edge's start, and whether the edge passes through the triangle.
struct Passage {
  bool passes = false;
  int side_of_start = 0;
  bool is_perturbed = false;
};
Passage passage(const PerturbedPoint& p, const PerturbedPoint& q, const PerturbedPoint (&t)[3]);

/// Traces the curves of intersecting pairs, each given once. `surfaces` are by numbers.
IntersectionCurves trace_curves(Span<const Surface> surfaces, Span<const TriangleIntersection> pairs);

}  // namespace softcd::detail
