#pragma once

#include <cstdint>

#include "softcd/mesh/scene_view.hpp"

namespace softcd {

/// Expands a pair of triangles into the vertex-triangle and edge-edge candidates that the two own (R-triangles), of the
/// kinds that both bodies want, whose boxes over the step overlap. Features that share a vertex are always in contact
/// and left out.
struct ExpandPair {
  SceneView scene;
  const Kdop18* volumes;
  const std::uint64_t* pairs;

  template <class VertexTriangles, class EdgeEdges>
  SOFTCD_HD void operator()(std::uint32_t i, VertexTriangles& vertex_triangles, EdgeEdges& edge_edges) const {
    const auto a = static_cast<std::uint32_t>(pairs[i] >> 32);
    const auto b = static_cast<std::uint32_t>(pairs[i]);
    const SceneBody& body_a = scene.bodies[scene.triangle_body[a]];
    const SceneBody& body_b = scene.bodies[scene.triangle_body[b]];
    if (body_a.vertex_triangle && body_b.vertex_triangle) {
      expand_vertices(a, b, body_b.margin, vertex_triangles);
      expand_vertices(b, a, body_a.margin, vertex_triangles);
    }
    if (body_a.edge_edge && body_b.edge_edge) expand_edges(a, b, body_a.margin, body_b.margin, edge_edges);
  }

 private:
  template <class VertexTriangles>
  SOFTCD_HD void expand_vertices(std::uint32_t owner, std::uint32_t t, float margin_t, VertexTriangles& out) const {
    const std::uint32_t owned = scene.ownership[owner];
    if ((owned & 7U) == 0U) return;
    const Triangle triangle = scene.triangles[t];
    const Kdop18& volume = volumes[t];
    for (int corner = 0; corner < 3; ++corner) {
      if (((owned >> corner) & 1U) == 0U) continue;
      const std::uint32_t v = scene.triangles[owner].v[corner];
      if (v == triangle.v[0] || v == triangle.v[1] || v == triangle.v[2]) continue;
      const float margin = scene.vertex_margin(v);
      if (!overlap(inflated(vertex_box(scene, v), margin), volume)) continue;
      if (scene.continuous && vertex_stays_apart(v, triangle, outward_up(margin + margin_t))) continue;
      out.push((static_cast<std::uint64_t>(v) << 32) | t);
    }
  }

  template <class EdgeEdges>
  SOFTCD_HD void expand_edges(std::uint32_t a, std::uint32_t b, float margin_a, float margin_b, EdgeEdges& out) const {
    const std::uint32_t owned_a = scene.ownership[a] >> 3U;
    const std::uint32_t owned_b = scene.ownership[b] >> 3U;
    if (owned_a == 0U || owned_b == 0U) return;
    const Triangle triangle_a = scene.triangles[a];
    const Triangle triangle_b = scene.triangles[b];
    Box sides_b[3];
    for (int side = 0; side < 3; ++side) {
      sides_b[side] = inflated(
          merged(vertex_box(scene, triangle_b.v[side]), vertex_box(scene, triangle_b.v[(side + 1) % 3])), margin_b);
    }
    for (int side_a = 0; side_a < 3; ++side_a) {
      if (((owned_a >> side_a) & 1U) == 0U) continue;
      const std::uint32_t p = triangle_a.v[side_a];
      const std::uint32_t q = triangle_a.v[(side_a + 1) % 3];
      const Box box = inflated(merged(vertex_box(scene, p), vertex_box(scene, q)), margin_a);
      for (int side_b = 0; side_b < 3; ++side_b) {
        if (((owned_b >> side_b) & 1U) == 0U) continue;
        const std::uint32_t r = triangle_b.v[side_b];
        const std::uint32_t s = triangle_b.v[(side_b + 1) % 3];
        if (p == r || p == s || q == r || q == s || !overlap(box, sides_b[side_b])) continue;
        if (scene.continuous && edges_stay_apart(p, q, r, s, outward_up(margin_a + margin_b))) continue;
        const std::uint32_t edge_a = scene.triangle_edges[a].v[side_a];
        const std::uint32_t edge_b = scene.triangle_edges[b].v[side_b];
        out.push(edge_a < edge_b ? (static_cast<std::uint64_t>(edge_a) << 32) | edge_b
                                 : (static_cast<std::uint64_t>(edge_b) << 32) | edge_a);
      }
    }
  }

  SOFTCD_HD bool vertex_stays_apart(std::uint32_t v, const Triangle& t, float gap) const {
    Kdop18 vertex_t0 = empty_kdop();
    Kdop18 vertex_t1 = empty_kdop();
    Kdop18 triangle_t0 = empty_kdop();
    Kdop18 triangle_t1 = empty_kdop();
    extend(vertex_t0, scene.x_t0[v]);
    extend(vertex_t1, scene.x_t1[v]);
    for (const std::uint32_t corner : t.v) {
      extend(triangle_t0, scene.x_t0[corner]);
      extend(triangle_t1, scene.x_t1[corner]);
    }
    return apart_throughout(vertex_t0, vertex_t1, triangle_t0, triangle_t1, gap);
  }

  SOFTCD_HD bool edges_stay_apart(std::uint32_t p, std::uint32_t q, std::uint32_t r, std::uint32_t s, float gap) const {
    return apart_throughout(edge_kdop(scene.x_t0, p, q), edge_kdop(scene.x_t1, p, q), edge_kdop(scene.x_t0, r, s),
                            edge_kdop(scene.x_t1, r, s), gap);
  }

  static SOFTCD_HD Kdop18 edge_kdop(const Vec3f* x, std::uint32_t a, std::uint32_t b) {
    Kdop18 volume = empty_kdop();
    extend(volume, x[a]);
    extend(volume, x[b]);
    return volume;
  }
};

}  // namespace softcd
