#pragma once

#include <cstdint>

#include "softcd/mesh/features.hpp"
#include "softcd/mesh/scene_view.hpp"
#include "softcd/mesh/vertex_stars.hpp"

namespace softcd {

/// The backend's copy of a scene, or, if the backend reads host memory, the scene itself; see SceneArrays.
template <class Backend>
struct SceneMirror {
  template <class T>
  using Mirror = typename Backend::template Mirror<T>;

  Mirror<Vec3f> x_t0, x_t1;
  Mirror<Vec3d> full_t0, full_t1;
  Mirror<Triangle> triangles;
  Mirror<TriangleEdges> triangle_edges;
  Mirror<Edge> edges;
  Mirror<Ownership> ownership;
  Mirror<std::uint32_t> patch_triangles;
  Mirror<std::uint32_t> triangle_body, vertex_body;
  Mirror<std::uint64_t> vertex_triangle_neighbours, edge_edge_neighbours;
  Mirror<VertexStar> stars;
  // See FeatureFilters:
  Mirror<VertexFilter> vertex_filters;
  Mirror<std::uint64_t> ring_begin;
  Mirror<std::uint32_t> ring_vertices;
  Mirror<Vec3f> x_rest;
};

}  // namespace softcd
