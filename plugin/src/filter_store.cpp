#include "filter_store.hpp"

#include <algorithm>

#include "softcd/mesh/vertex_rings.hpp"

namespace softcd {
namespace {

Vec3d position(const Positions& x, std::uint64_t vertex) {
  return x.is_double() ? position_at<double>(given(x), vertex) : position_at<float>(given(x), vertex);
}

/// Returns each body's values at its vertices' places; empty where no body has any.
template <class T>
std::vector<T> by_scene_vertex(const SceneLayout& layout, std::vector<T> Body::*values) {
  std::vector<T> all;
  for (const Body& body : layout.bodies()) {
    const std::vector<T>& of_body = body.*values;
    if (of_body.empty()) continue;
    all.resize(layout.vertex_count());
    std::copy(of_body.begin(), of_body.end(), all.begin() + body.vertices.first);
  }
  return all;
}

}  // namespace

std::vector<Vec3f> rest_positions(const Positions& x) {
  Extent extent;
  for (std::size_t v = 0; v < x.count(); ++v) extent.extend(position(x, v));
  const Vec3d middle = 0.5 * extent.lo + 0.5 * extent.hi;
  std::vector<Vec3f> positions(x.count());
  for (std::size_t v = 0; v < x.count(); ++v) positions[v] = vec3_cast<float>(position(x, v) - middle);
  return positions;
}

void FilterStore::update(const SceneLayout& layout) {
  const std::pair now(revision_, layout.revision());
  if (updated_ == now) return;
  const bool had_some = !vertices_.empty() || !ring_begin_.empty() || !x_rest_.empty();
  vertices_ = by_scene_vertex(layout, &Body::vertex_filters);
  x_rest_ = by_scene_vertex(layout, &Body::x_rest);
  list_rings(layout);
  updated_ = now;
  are_unsent_ |= had_some || !vertices_.empty() || !ring_begin_.empty() || !x_rest_.empty();
}

void FilterStore::list_rings(const SceneLayout& layout) {
  const std::vector<Body>& bodies = layout.bodies();
  ring_begin_.clear();
  ring_vertices_.clear();
  if (std::none_of(bodies.begin(), bodies.end(), [](const Body& body) { return body.excludes_rings(); })) return;
  ring_begin_.reserve(layout.vertex_count() + 1);
  for (const Body& body : bodies) {
    if (body.is_removed || !body.excludes_rings()) continue;
    const VertexRings rings = vertex_rings(layout.mesh_of(body), body.settings.neighbour_rings - 1);
    ring_begin_.resize(body.vertices.first, ring_vertices_.size());
    for (std::size_t v = 0; v + 1 < rings.begin.size(); ++v) {
      ring_begin_.push_back(ring_vertices_.size() + rings.begin[v]);
    }
    ring_vertices_.insert(ring_vertices_.end(), rings.vertices.begin(), rings.vertices.end());
  }
  ring_begin_.resize(layout.vertex_count() + 1, ring_vertices_.size());
}

}  // namespace softcd
