#pragma once

#include <cstdint>

#include "softcd/core/contact.hpp"
#include "softcd/core/span.hpp"
#include "softcd/core/types.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// The kinds of regions, by what bounds them.
enum class RegionKind : std::uint32_t {
  closed,            ///< closed curves, or nothing where a whole surface is inside a closed body
  loop_with_border,  ///< curves together with the surface's own border
  open,              ///< nothing: the curve ends within the surface, or does not separate it
  degenerate,        ///< curves from which no side follows: an edge of three triangles, or contradicting sides
};

/// A point of an intersection curve: an edge passes through a triangle. A curve of a body with itself may end at a
/// vertex that two intersecting triangles share; both ends of the edge are then that vertex, and the triangle is one of
/// the two.
struct CurvePoint {
  Vec3d position;          ///< in world coordinates
  BodyId edge_body;        ///< the edge's body
  std::uint32_t edge[2];   ///< vertices of edge_body, the lower one first
  BodyId triangle_body;    ///< the triangle's body
  std::uint32_t triangle;  ///< index in triangle_body
  std::uint32_t unused;    ///< 0, so that no byte is undefined
};

/// A curve along which two surfaces, or a surface and itself, intersect.
struct IntersectionCurve {
  BodyId body_a;              ///< a body
  BodyId body_b;              ///< a body with the same or a higher id
  std::uint32_t first_point;  ///< index in IntersectionRegions::points
  std::uint32_t point_count;  ///< number of points, in the order of the curve
  bool is_closed;          ///< the last point is followed by the first one; else the curve ends at borders or vertices
  bool is_perturbed;       ///< some of its points exist only by the perturbation, see IntersectionRegions
  std::uint8_t unused[6];  ///< 0, so that no byte is undefined
  double length;           ///< in the positions' unit
};

/// A vertex of a region, and the way out.
struct RegionVertex {
  std::uint32_t vertex;  ///< index in the region's body
  std::uint32_t unused;  ///< 0, so that no byte is undefined
  Vec3d direction;       ///< unit vector; 0 where none is known
  double distance;       ///< to move along the direction, in the positions' unit; see IntersectionRegion
};

/// A part of a body's surface on the wrong side of another body, or of itself.
///
/// **The wrong side.** Where `other` is another body and its surface is closed, this is its inside: every vertex of the
/// region is inside, and no other vertex is. Else curves separate two sides, and the one with the smaller area counts
/// as wrong (Baraff, Witkin, Kass 2003).
///
/// **The way out.** For `closed` and `loop_with_border`, each vertex's direction and distance lead to the nearest point
/// of the other surface. For a body and itself this is the opposite region. For `open` and `degenerate` they shorten
/// the curve: the direction is opposite to the gradient of the curve's length (after Volino and Magnenat-Thalmann
/// 2006). The distances together would make the length 0 if it went on to change at this rate.
struct IntersectionRegion {
  BodyId body;                 ///< the body whose surface this is
  BodyId other;                ///< the body that it intersects; may be the same
  RegionKind kind;             ///< what bounds it
  bool is_inside;              ///< whether it is inside the closed surface of another body, decided exactly
  bool is_perturbed;           ///< whether one of its curves is
  std::uint8_t unused[2];      ///< 0, so that no byte is undefined
  std::uint32_t first_vertex;  ///< index in IntersectionRegions::vertices
  /// Number of vertices, ascending. 0 where the other surface passes through triangles without reaching a vertex.
  std::uint32_t vertex_count;
  std::uint32_t first_triangle;  ///< index in IntersectionRegions::triangles
  std::uint32_t triangle_count;  ///< number of triangles, ascending: with a vertex of the region, or along the curve
  std::uint32_t first_curve;     ///< index in IntersectionRegions::region_curves
  std::uint32_t curve_count;     ///< number of curves that bound it
  double area;                   ///< triangles count by their share of vertices in the region; 0 for `open`
  double curve_length;           ///< of these curves together
};

/// The intersections of surfaces as curves and regions, in an order that depends on meshes, positions and ids only.
///
/// **Degenerate positions.** Curves and regions are those of positions that are moved by infinitesimal amounts, first
/// each body, then each vertex. Touching or coplanar triangles so intersect properly, or not at all, and all curves are
/// closed or end at a border or a vertex. `is_perturbed` marks curves of such places, and `touching_pairs` counts pairs
/// that are apart when moved.
///
/// Segments, and triangles with a repeated vertex, have no sides and are left out.
struct IntersectionRegions {
  Span<const IntersectionRegion> regions;   ///< by body, other body, lowest triangle
  Span<const RegionVertex> vertices;        ///< of all regions
  Span<const std::uint32_t> triangles;      ///< of all regions; indices in the region's body
  Span<const std::uint32_t> region_curves;  ///< of all regions; indices in `curves`
  Span<const IntersectionCurve> curves;     ///< by bodies, then by their points' edges
  Span<const CurvePoint> points;            ///< of all curves
  std::uint64_t touching_pairs = 0;         ///< pairs of Probe::intersections() that only touch

  /// Returns whether no surface is on a wrong side.
  bool empty() const { return regions.empty(); }
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
