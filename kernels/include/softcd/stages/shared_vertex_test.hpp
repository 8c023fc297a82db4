#pragma once

#include <cstdint>

#include "softcd/math/closest_point.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/mesh/scene_view.hpp"

namespace softcd {

/// Decides about triangles with a vertex in common. Their volumes overlap wherever they are: of n triangles around one
/// vertex all n^2 / 2 pairs.
///
/// Features with a common vertex are no candidates. Of two others, one of each triangle, at least one lacks the vertex
/// that the triangles share. It lies in its triangle's edge opposite to that vertex. Hence the triangles can be in
/// contact only where the opposite edge of one comes near the other. Triangles that share two vertices always do.
template <bool kSwept>
struct SharedVertexTest {
  SceneView scene;

  /// Whether features of the two, which share a vertex, may be `distance` (0 or more) or less apart.
  SOFTCD_HD_SELDOM bool may_touch(const Triangle& a, const Triangle& b, float distance) const {
    OppositeEdges t1 = load(scene.x_t1, a, b);
    OppositeEdges t0 = kSwept ? load(scene.x_t0, a, b) : t1;
    const float extent = larger(t0.extent(), t1.extent());
    const float scale = safe_scale(extent);
    t0 = t0.scaled(scale);
    t1 = t1.scaled(scale);
    // Differences of coordinates, their products with a direction, the sums and the direction's length add up to less.
    constexpr float kHeightError = 32.0F * epsilon<float>();
    const float rounding = kHeightError * (scale * extent);
    const float scaled_distance = outward_up(scale * distance + rounding);
    return !certainly_apart(t0.a, t0.b, t1.a, t1.b, scaled_distance) ||
           !certainly_apart(t0.b, t0.a, t1.b, t1.a, scaled_distance);
  }

 private:
  struct Segment {
    Vec3f x[2];

    SOFTCD_HD Vec3f sum() const { return x[0] + x[1]; }
    SOFTCD_HD float extent() const { return larger(max_norm(x[0]), max_norm(x[1])); }
    SOFTCD_HD Segment scaled(float scale) const { return {{scale * x[0], scale * x[1]}}; }
  };

  /// The edges of both triangles at one time, relative to the shared vertex.
  struct OppositeEdges {
    Segment a, b;

    SOFTCD_HD float extent() const { return larger(a.extent(), b.extent()); }
    SOFTCD_HD OppositeEdges scaled(float scale) const { return {a.scaled(scale), b.scaled(scale)}; }
  };

  static SOFTCD_HD Segment opposite_edge(const Vec3f* x, const Triangle& t, int corner) {
    const Vec3f origin = x[t.v[corner]];
    return {{x[t.v[(corner + 1) % 3]] - origin, x[t.v[(corner + 2) % 3]] - origin}};
  }

  static SOFTCD_HD OppositeEdges load(const Vec3f* x, const Triangle& a, const Triangle& b) {
    const int of_a = has_vertex(b, a.v[0]) ? 0 : (has_vertex(b, a.v[1]) ? 1 : 2);
    const std::uint32_t shared = a.v[of_a];
    const int of_b = b.v[0] == shared ? 0 : (b.v[1] == shared ? 1 : 2);
    return {opposite_edge(x, a, of_a), opposite_edge(x, b, of_b)};
  }

  /// Whether the edge stays more than `distance` away from the triangle with this `base` along one direction, the same
  /// at both ends of the step. It leads from the triangle's median to the middle of the edge, half-way through.
  static SOFTCD_HD bool certainly_apart(const Segment& edge_t0, const Segment& base_t0, const Segment& edge_t1,
                                        const Segment& base_t1, float distance) {
    const Vec3f middle = edge_t0.sum() + edge_t1.sum();
    const Vec3f median = base_t0.sum() + base_t1.sum();
    const Vec3f direction = unit_vector(middle - detail::nearest_on_segment(middle, median) * median);
    return lies_beyond(edge_t1, base_t1, direction, distance) &&
           (!kSwept || lies_beyond(edge_t0, base_t0, direction, distance));
  }

  /// Returns false if the direction is not a number. The shared vertex is at 0.
  static SOFTCD_HD bool lies_beyond(const Segment& edge, const Segment& base, Vec3f direction, float distance) {
    const float lowest = smaller(dot(direction, edge.x[0]), dot(direction, edge.x[1]));
    const float highest = larger(0.0F, larger(dot(direction, base.x[0]), dot(direction, base.x[1])));
    return lowest - highest > distance;
  }
};

}  // namespace softcd
