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
  /// Continuous `conservative` detection reports it because it could not tell within its bound on work; the features
  /// may stay farther apart than their margin.
  bool is_unsettled;
  std::uint16_t unused;  ///< 0, so that no byte is undefined
  BodyId body_a;         ///< the vertex's body, or the first edge's
  BodyId body_b;         ///< the triangle's body, or the second edge's
  /// Vertex and triangle index, or the two edges' indices. A body's edges are those of its triangles, in the order of
  /// their sorted vertex pairs (lower vertex first, then the higher one), and then its segments, as they were given,
  /// but for those that are among the edges already: without triangles segment i is edge i. Where some triangles of a
  /// body are changed the edges that stay keep their indices, and new ones get any that are free or follow; `vertices`
  /// tells which they are.
  std::uint32_t feature_a;
  std::uint32_t feature_b;  ///< of body_b, as feature_a
  /// Vertex-triangle: the vertex, then the triangle's three. Edge-edge: first edge (lower vertex first), then
  /// the second. The first edge is the smaller by (body, feature).
  std::uint32_t vertices[4];
  /// Where on the features: vertex-triangle {1, w0, w1, w2}, edge-edge {u0, u1, w0, w1}; each side sums to 1.
  float weights[4];
  /// Unit vector from side b's point towards side a's. With CCD it points to the side that a came from.
  Vec3f normal;
  float distance;        ///< between the two points at time_of_impact; unit: the positions'
  float time_of_impact;  ///< in [0, 1], t0 to t1; 1 for a discrete detection
};

/// What a detection that leaves its contacts on a device says of them there.
struct ContactCounts {
  std::uint64_t contacts;  ///< that were found: those beyond what there is room for are not there
  /// 1: all contacts are there, in order. 0: something did not fit, or was not as foreseen; what is there is of no use,
  /// and waiting for the detection repeats it.
  std::uint32_t is_complete;
  std::uint32_t unused;  ///< 0
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd
