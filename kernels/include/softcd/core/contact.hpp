#pragma once

#include <cstdint>

#include "softcd/core/types.hpp"
#include "softcd/version.hpp"

namespace softcd {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// Identifies a body for as long as it is in its scene. Ids of removed bodies are not reused.
struct BodyId {
  std::uint32_t value = kNoIndex;  ///< kNoIndex for no body

  friend constexpr bool operator==(BodyId a, BodyId b) { return a.value == b.value; }
  friend constexpr bool operator!=(BodyId a, BodyId b) { return a.value != b.value; }
  friend constexpr bool operator<(BodyId a, BodyId b) { return a.value < b.value; }
};

/// Two features in contact. Indices count within their own body. Aligned so that it moves in 8-byte pieces.
struct alignas(8) Contact {
  ContactKind kind;  ///< which features touch
  /// True where continuous `conservative` detection reached its bound on work before it could decide. The features may
  /// then stay farther apart than their margin.
  bool is_unsettled;
  std::uint16_t unused;  ///< 0, so that no byte is undefined
  BodyId body_a;         ///< the vertex's body, or the first edge's
  BodyId body_b;         ///< the triangle's body, or the second edge's
  /// The vertex's index and the triangle's, or the two edges' indices.
  ///
  /// A body numbers its edges as follows:
  /// - First come the edges of its triangles, sorted by their vertex pairs (lower vertex first, then the higher one).
  /// - Then come its segments, in the given order. A segment that is also a triangle's edge is not numbered again.
  ///
  /// In a body without triangles, segment i is edge i. When some triangles of a body change, the remaining edges keep
  /// their indices. New edges take any free index or follow at the end; `vertices` says which edge it is.
  std::uint32_t feature_a;
  std::uint32_t feature_b;  ///< the same for body_b
  /// Vertex-triangle: the vertex, then the triangle's three. Edge-edge: the first edge (lower vertex first), then the
  /// second. The first edge is the smaller by (body, feature).
  std::uint32_t vertices[4];
  /// The point on each feature: vertex-triangle {1, w0, w1, w2}, edge-edge {u0, u1, w0, w1}. Each side sums to 1.
  float weights[4];
  /// Unit vector from side b's point towards side a's. In CCD it points to the side that a came from.
  Vec3f normal;
  float distance;        ///< between the two points at time_of_impact; unit: the positions'
  float time_of_impact;  ///< in [0, 1], t0 to t1; 1 for a discrete detection
};

/// Counters on the device of a detection that leaves its contacts there.
struct ContactCounts {
  std::uint64_t contacts;  ///< number of contacts found; those beyond the list's capacity are not stored
  /// 1: all contacts are stored, in order. 0: a list was too short, or a prediction was wrong. The stored contacts are
  /// then useless, and waiting for the detection repeats it.
  std::uint32_t is_complete;
  std::uint32_t unused;  ///< 0
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
