#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/span.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Three vertex indices. Repeated vertices are legal: the triangle then collides as the segment
/// or the point that it is.
struct Triangle {
  std::uint32_t v[3];  ///< each below the vertex count of its body
};

/// Whether `v` is one of the three.
SOFTCD_HD constexpr bool has_vertex(const Triangle& triangle, std::uint32_t v) {
  return (v == triangle.v[0]) | (v == triangle.v[1]) | (v == triangle.v[2]);
}

/// Whether two triangles of one mesh have a vertex in common.
SOFTCD_HD constexpr bool share_vertex(const Triangle& a, const Triangle& b) {
  const bool has_first = has_vertex(b, a.v[0]);
  const bool has_second = has_vertex(b, a.v[1]);
  const bool has_third = has_vertex(b, a.v[2]);
  return has_first | has_second | has_third;
}

/// Two vertex indices: a part of a rope, or of a hair, by itself. Equal ones are legal: the segment then collides as
/// the vertex that it is.
struct Segment {
  std::uint32_t v[2];  ///< each below the vertex count of its body
};

/// Two vertex indices, v[0] < v[1].
struct Edge {
  std::uint32_t v[2];  ///< each below the vertex count of its body
};

/// What a vertex may touch. Two features may touch where some vertex of the one and some vertex of the other have
/// (a.group & b.mask) and (b.group & a.mask): what all vertices of a triangle are kept from, the triangle is.
struct VertexFilter {
  std::uint32_t group = 1;           ///< bits of what it is; 1 in bodies without filters
  std::uint32_t mask = 0xFFFFFFFFu;  ///< bits of what it may touch
};

/// Which features touch.
enum class ContactKind : std::uint8_t {
  vertex_triangle = 0,  ///< a vertex and a triangle
  edge_edge = 1,        ///< two edges
};

/// What is compared: positions at t1 (discrete), or straight-line motion from t0 to t1 (continuous).
enum class Detection : std::uint32_t { dcd, ccd };

/// When a vertex and a triangle are in contact in a discrete detection. Edges always go by their distance.
enum class ContactRule : std::uint32_t {
  distance,  ///< at most a margin apart
  /// Bullet's rule for deformable bodies (proximityTest in btSoftBodyInternals.h): the vertex is at most a margin from
  /// the triangle's plane, and its projection's barycentric coordinates lie in [-d, 1 + d], d = margin / sqrt(area). Of
  /// that only what is at most sqrt(5) margins from the triangle: all of it, unless an edge's square exceeds four times
  /// the area. A triangle without area goes by its distance.
  slab,
};

/// How candidate triangle pairs are found, none of which is ever lost; see docs/inside/grid.md.
enum class BroadPhase : std::uint32_t {
  exact,    ///< virtual subdivision with exact control bits
  uniform,  ///< one grid sized by the largest triangle, no subdivision: many more tests
};

/// The narrow phase's arithmetic, and what it promises: `fast` and `precise` for the positions as the detector has them
/// (see Positions), `conservative` for those that it was given. S is the sum of the largest components of three of the
/// features' edges and distances. docs/accuracy.md has the reasons and measurements.
enum class Accuracy : std::uint32_t {
  /// Coplanarity cubic and proximity in float32. What touches during a step is found, as a rule early; so is what
  /// passes by within 4e-6 S, or all but touches for longer than a bound on work allows to follow.
  fast,
  /// Both in float64, with 8e-15 S instead of 4e-6 S; times of impact are not late. In a continuous detection a
  /// positive margin is looked for at the step's ends and where the features are coplanar, not in between.
  precise,
  /// In float64, with roundings bounded against "no contact", for positions as they were given, in double too.
  /// Continuous: whatever comes within the margin during the step is found, at a time of impact that is not late. What
  /// is found comes within the margin, a millionth of it and 2e-14 S, but for the unsettled contacts, which are marked
  /// (Contact::is_unsettled): the bound on work was reached first. Discrete: whatever is within the margin is found.
  conservative,
  /// `conservative` where positions of some body are double, and in a continuous detection with margins; else
  /// `precise`.
  automatic,
};

/// Bits of Ownership: which vertices and edges of a triangle this triangle owns (R-triangles,
/// Curtis, Tamstorf, Manocha 2008). Bit i is vertex v[i], bit 3 + i is the edge v[i], v[(i + 1) % 3].
using Ownership = std::uint8_t;

/// Set beside what a segment owns: it has no face that vertices could touch.
constexpr std::uint32_t kSegment = 0x40u;

/// Set instead of any bit of Ownership for a triangle that takes no part: one of its vertices is not finite.
constexpr std::uint32_t kLeftOut = 0x80u;

/// No vertex, triangle, edge or body.
constexpr std::uint32_t kNoIndex = 0xFFFFFFFFu;

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
