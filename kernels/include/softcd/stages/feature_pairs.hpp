#pragma once

#include <cstdint>

#include "softcd/math/time_of_impact.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/stages/bounding_volumes.hpp"

namespace softcd {

/// Number of bits set among the lowest three.
SOFTCD_HD constexpr std::uint32_t count_bits3(std::uint32_t bits) {
  return (bits & 1U) + ((bits >> 1) & 1U) + ((bits >> 2) & 1U);
}

/// Index of the n-th set bit (n from 0) among the lowest three, of which more than n are set.
SOFTCD_HD constexpr int nth_bit3(std::uint32_t bits, std::uint32_t n) {
  const std::uint32_t first = bits & 1U;
  if (first > n) return 0;
  return first + ((bits >> 1) & 1U) > n ? 1 : 2;
}

/// Two triangles that may touch, and the features of each that the pair has to test: bits as Ownership.
struct FeatureWork {
  std::uint32_t a, b;
  std::uint32_t owned_a, owned_b;
  float growth_a, growth_b;

  SOFTCD_HD std::uint32_t vertices_a() const { return count_bits3(owned_a); }
  SOFTCD_HD std::uint32_t vertices_b() const { return count_bits3(owned_b); }
  SOFTCD_HD std::uint32_t edges_a() const { return count_bits3(owned_a >> 3U); }
  SOFTCD_HD std::uint32_t edges_b() const { return count_bits3(owned_b >> 3U); }
  SOFTCD_HD std::uint32_t part_count() const { return vertices_a() + vertices_b() + edges_a() * edges_b(); }
};

/// Expands a pair of triangles into the vertex-triangle and edge-edge candidates that the two own (R-triangles), of the
/// kinds that both bodies want. A part is one such candidate; it is kept unless the features share a vertex (they are
/// always in contact), or are kept apart by their boxes over the step, by the 18-DOPs at its two ends, or, in
/// T as the narrow phase, by the signs of the coplanarity cubic.
template <class T>
struct ExpandPair {
  using Item = FeatureWork;

  SceneView scene;
  const TriangleShape* shapes;
  const std::uint64_t* pairs;

  SOFTCD_HD FeatureWork load_item(std::uint32_t i) const {
    const auto a = static_cast<std::uint32_t>(pairs[i] >> 32);
    const auto b = static_cast<std::uint32_t>(pairs[i]);
    const TriangleShape shape_a = shapes[a];
    const TriangleShape shape_b = shapes[b];
    const std::uint32_t wanted = shape_a.flags & shape_b.flags;
    const std::uint32_t kinds =
        ((wanted & kWantsVertexTriangle) != 0U ? 7U : 0U) | ((wanted & kWantsEdgeEdge) != 0U ? 56U : 0U);
    return {a, b, shape_a.flags & kinds, shape_b.flags & kinds, shape_a.growth, shape_b.growth};
  }

  template <class VertexTriangles, class EdgeEdges>
  SOFTCD_HD void operator()(const FeatureWork& work, std::uint32_t part, VertexTriangles& vertex_triangles,
                            EdgeEdges& edge_edges) const {
    const float margin = outward_up(work.growth_a + work.growth_b);
    const std::uint32_t vertices_a = work.vertices_a();
    const std::uint32_t vertices = vertices_a + work.vertices_b();
    if (part < vertices_a) {
      test_vertex(work.a, nth_bit3(work.owned_a, part), work.b, margin, vertex_triangles);
    } else if (part < vertices) {
      test_vertex(work.b, nth_bit3(work.owned_b, part - vertices_a), work.a, margin, vertex_triangles);
    } else {
      const std::uint32_t edges_b = work.edges_b();
      test_edges(work.a, nth_bit3(work.owned_a >> 3U, (part - vertices) / edges_b), work.b,
                 nth_bit3(work.owned_b >> 3U, (part - vertices) % edges_b), margin, edge_edges);
    }
  }

 private:
  template <int kCount>
  SOFTCD_HD PointMotion<kCount> load(const std::uint32_t (&vertices)[kCount]) const {
    PointMotion<kCount> motion{};
    for (int i = 0; i < kCount; ++i) {
      motion.t1[i] = scene.x_t1[vertices[i]];
      motion.t0[i] = scene.continuous ? scene.x_t0[vertices[i]] : motion.t1[i];
    }
    return motion;
  }

  template <int kCount>
  static SOFTCD_HD Box swept_box(const PointMotion<kCount>& points) {
    Box box = merged(box_of(points.t0[0]), box_of(points.t1[0]));
    for (int i = 1; i < kCount; ++i) box = merged(box, merged(box_of(points.t0[i]), box_of(points.t1[i])));
    return box;
  }

  static SOFTCD_HD float furthest_coordinate(const Box& box) { return larger(max_norm(box.lo), max_norm(box.hi)); }

  /// Whether two features are certain to stay further apart than `margin`.
  template <ContactKind kKind, int kCountA, int kCountB>
  SOFTCD_HD bool stay_apart(const PointMotion<kCountA>& a, const PointMotion<kCountB>& b, float margin) const {
    const Box box_a = inflated(swept_box(a), margin);
    const Box box_b = swept_box(b);
    if (!overlap(box_a, box_b)) return true;
    const float furthest = larger(furthest_coordinate(box_a), furthest_coordinate(box_b));
    if (apart_throughout(a, b, reach_of(margin, furthest))) return true;
    if (!scene.continuous) return false;
    Vec3<T> t0[4];
    Vec3<T> t1[4];
    for (int i = 0; i < 4; ++i) {
      t0[i] = vec3_cast<T>(i < kCountA ? a.t0[i < kCountA ? i : 0] : b.t0[i < kCountA ? 0 : i - kCountA]);
      t1[i] = vec3_cast<T>(i < kCountA ? a.t1[i < kCountA ? i : 0] : b.t1[i < kCountA ? 0 : i - kCountA]);
    }
    return keep_apart<kKind>(t0, t1, static_cast<T>(margin));
  }

  template <class VertexTriangles>
  SOFTCD_HD void test_vertex(std::uint32_t owner, int corner, std::uint32_t other, float margin,
                             VertexTriangles& out) const {
    const std::uint32_t v = scene.triangles[owner].v[corner];
    const Triangle t = scene.triangles[other];
    if (v == t.v[0] || v == t.v[1] || v == t.v[2]) return;
    if (stay_apart<ContactKind::vertex_triangle>(load<1>({v}), load(t.v), margin)) return;
    out.push((static_cast<std::uint64_t>(v) << 32) | other);
  }

  template <class EdgeEdges>
  SOFTCD_HD void test_edges(std::uint32_t a, int side_a, std::uint32_t b, int side_b, float margin,
                            EdgeEdges& out) const {
    const Triangle& t = scene.triangles[a];
    const Triangle& u = scene.triangles[b];
    const std::uint32_t p = t.v[side_a];
    const std::uint32_t q = t.v[side_a == 2 ? 0 : side_a + 1];
    const std::uint32_t r = u.v[side_b];
    const std::uint32_t s = u.v[side_b == 2 ? 0 : side_b + 1];
    if (p == r || p == s || q == r || q == s) return;
    if (stay_apart<ContactKind::edge_edge>(load<2>({p, q}), load<2>({r, s}), margin)) return;
    const std::uint32_t edge_a = scene.triangle_edges[a].v[side_a];
    const std::uint32_t edge_b = scene.triangle_edges[b].v[side_b];
    out.push(edge_a < edge_b ? (static_cast<std::uint64_t>(edge_a) << 32) | edge_b
                             : (static_cast<std::uint64_t>(edge_b) << 32) | edge_a);
  }
};

}  // namespace softcd
