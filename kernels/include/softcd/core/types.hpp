#pragma once

#include <cstdint>

#include "softcd/core/host_device.hpp"
#include "softcd/core/span.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Three vertex indices. Repeated vertices are legal: the triangle then collides as the segment or point that it is.
struct Triangle {
  std::uint32_t v[3];  ///< each below the vertex count of its body
};

/// Two vertex indices: a part of a rope or hair that belongs to no triangle. Equal indices are legal: the segment then
/// collides as a vertex.
struct Segment {
  std::uint32_t v[2];  ///< each below the vertex count of its body
};

/// Filter bits of a vertex. Vertices a and b may touch when (a.group & b.mask) and (b.group & a.mask). Two features may
/// touch when some vertex of the one and some vertex of the other may. A filter that holds for all vertices of a
/// triangle thus holds for the triangle.
struct VertexFilter {
  std::uint32_t group = 1;           ///< the groups that the vertex is in; 1 in bodies without filters
  std::uint32_t mask = 0xFFFFFFFFu;  ///< the groups that it may touch
};

/// The kind of touching features.
enum class ContactKind : std::uint8_t {
  vertex_triangle = 0,  ///< a vertex and a triangle
  edge_edge = 1,        ///< two edges
};

/// The compared motion: positions at one end of the step (dcd), or the straight path from t0 to t1 (ccd).
enum class Detection : std::uint32_t { dcd, ccd };

/// The rule by which a vertex and a triangle are in contact in a discrete detection. Edges are always compared by
/// distance.
enum class ContactRule : std::uint32_t {
  distance,  ///< at most a margin apart
  /// Bullet's rule for deformable bodies (proximityTest in btSoftBodyInternals.h). The vertex is at most a margin from
  /// the triangle's plane, and its projection's barycentric coordinates lie in [-d, 1 + d], d = margin / sqrt(area).
  ///
  /// Only vertices at most sqrt(5) margins from the triangle count. This excludes none unless the square of an edge
  /// exceeds four times the area. A triangle without area is compared by distance.
  slab,
  /// Bullet's rule for its classic soft bodies. The distance counts, but of what is near by QueryOptions::motion_margin
  /// only what lies ahead: boxes at t1 must meet. The vertex's box reaches ahead by three times its motion from t0 to
  /// t1, the triangle's by three times the mean motion of its corners. Both are grown by twice their body's margin.
  /// Boxes that are apart by a rounding may count as meeting.
  ahead,
};

/// The search for candidate triangle pairs. No choice ever loses one; see docs/inside/grid.md.
enum class BroadPhase : std::uint32_t {
  exact,    ///< virtual subdivision with exact control bits
  uniform,  ///< one grid sized by the largest triangle, no subdivision: many more tests
};

/// The narrow phase's arithmetic, and what it guarantees. `fast` and `precise` guarantee it for the detector's
/// positions (see Positions), `conservative` for the given ones. S is the sum of the largest components of three
/// vectors: the features' edges and the distances between them. docs/measured/accuracy.md has the reasons and
/// measurements.
enum class Accuracy : std::uint32_t {
  /// Computes the coplanarity cubic and the proximity in float32. Finds all features that touch during a step, usually
  /// a little early. Also reports features that pass within 4e-6 S of each other, or nearly touch for longer than its
  /// bound on work can follow.
  fast,
  /// Computes both in float64, with 8e-15 S instead of 4e-6 S; times of impact are never late. A continuous detection
  /// checks a positive margin at the step's ends and at coplanar times, not in between.
  precise,
  /// Computes in float64, for the given positions (double ones, too), and bounds roundings so that no contact is lost.
  /// - Continuous: finds all features that come within the margin during the step, at a time of impact that is never
  ///   late. Reported features come within the margin plus a millionth of it plus 2e-14 S. Unsettled contacts are the
  ///   exception (Contact::is_unsettled): the bound on work was reached first.
  /// - Discrete: finds all features within the margin.
  conservative,
  /// Chooses `conservative` where some body has double positions, and for continuous detections with margins; else
  /// `precise`.
  automatic,
};

/// The index that stands for no vertex, triangle, edge or body.
constexpr std::uint32_t kNoIndex = 0xFFFFFFFFu;

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
