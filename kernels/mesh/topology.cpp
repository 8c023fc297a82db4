#include "softcd/mesh/topology.hpp"

#include <algorithm>
#include <numeric>

#include "softcd/core/parallel.hpp"
#include "softcd/mesh/neighbour_lister.hpp"
#include "softcd/mesh/patches.hpp"

namespace softcd {
namespace {

constexpr std::uint32_t kTrianglesAtOnce = 4096;

/// Calls visit(v) for the triangle's vertices, each once.
template <class Visit>
void for_each_vertex(const Triangle& triangle, Visit visit) {
  for (int corner = 0; corner < 3; ++corner) {
    const std::uint32_t v = triangle.v[corner];
    if (std::find(triangle.v, triangle.v + corner, v) == triangle.v + corner) visit(v);
  }
}

/// The triangles of each vertex, in ascending order.
class VertexTriangles {
 public:
  explicit VertexTriangles(const MeshView& mesh) : first_vertex_(mesh.first_vertex), first_(mesh.vertex_count + 1, 0) {
    for (const Triangle& triangle : mesh.triangles) {
      for_each_vertex(triangle, [&](std::uint32_t v) { ++first_[v - first_vertex_ + 1]; });
    }
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    triangles_.resize(first_.back());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for_each_vertex(mesh.triangles[t], [&](std::uint32_t v) { triangles_[next[v - first_vertex_]++] = t; });
    }
  }

  /// Returns the places of a vertex's triangles in the mesh.
  Span<const std::uint32_t> of(std::uint32_t v) const {
    const std::uint32_t* const first = first_.data() + (v - first_vertex_);
    return {triangles_.data() + first[0], static_cast<std::size_t>(first[1] - first[0])};
  }
  template <class Visit>
  void for_each_triangle_of(std::uint32_t v, Visit visit) const {
    const Span<const std::uint32_t> triangles = of(v);
    std::for_each(triangles.begin(), triangles.end(), visit);
  }

 private:
  std::uint32_t first_vertex_;
  std::vector<std::uint32_t> first_, triangles_;
};

FeatureEnds ends_of(const NeighbourFeatures& features) {
  return {static_cast<std::uint32_t>(features.vertex_triangle.size()),
          static_cast<std::uint32_t>(features.edge_edge.size())};
}

/// An edge of segments that no triangle has, with the first of its segments.
struct SegmentEdge {
  std::uint64_t key;
  std::uint32_t segment;
  std::uint32_t edge = kNoIndex;
};

/// Returns the edges that only segments have, with ascending, distinct keys. `keys` are the keys of the triangles'
/// edges, ascending.
std::vector<SegmentEdge> edges_of_segments(Span<const Segment> segments, const std::vector<std::uint64_t>& keys) {
  std::vector<SegmentEdge> edges;
  for (std::uint32_t s = 0; s < segments.size(); ++s) {
    const auto [a, b] = segments[s].v;
    if (a != b && !std::binary_search(keys.begin(), keys.end(), edge_key(a, b))) edges.push_back({edge_key(a, b), s});
  }
  const auto order = [](const SegmentEdge& a, const SegmentEdge& b) {
    return a.key != b.key ? a.key < b.key : a.segment < b.segment;
  };
  std::sort(edges.begin(), edges.end(), order);
  const auto is_same = [](const SegmentEdge& a, const SegmentEdge& b) { return a.key == b.key; };
  edges.erase(std::unique(edges.begin(), edges.end(), is_same), edges.end());
  return edges;
}

/// Adds the edges of segments to the topology. `keys` are the keys of its edges, ascending.
void add_segments(Span<const Segment> segments, const std::vector<std::uint64_t>& keys, Topology& topology) {
  std::vector<SegmentEdge> added = edges_of_segments(segments, keys);
  for (std::uint32_t s = 0; s < segments.size(); ++s) {
    const auto [a, b] = segments[s].v;
    const std::uint64_t key = edge_key(a, b);
    const auto known = std::lower_bound(keys.begin(), keys.end(), key);
    std::uint32_t edge = kNoIndex;
    if (known != keys.end() && *known == key) {
      edge = static_cast<std::uint32_t>(known - keys.begin());
    } else if (a != b) {
      SegmentEdge& own = *std::lower_bound(added.begin(), added.end(), key,
                                           [](const SegmentEdge& each, std::uint64_t k) { return each.key < k; });
      if (own.segment == s) {
        own.edge = static_cast<std::uint32_t>(topology.edges.size());
        topology.edges.push_back({{std::min(a, b), std::max(a, b)}});
      }
      edge = own.edge;
    }
    topology.triangles.push_back({{a, b, b}});
    topology.triangle_edges.push_back({{edge, kNoIndex, edge}});
  }
  topology.segment_count = static_cast<std::uint32_t>(segments.size());
}

}  // namespace

Topology build_topology(Span<const Triangle> triangles, std::uint32_t vertex_count, Span<const Segment> segments) {
  Topology topology;
  topology.vertex_count = vertex_count;
  topology.triangles.assign(triangles.begin(), triangles.end());

  std::vector<std::uint64_t> keys;
  keys.reserve(3 * triangles.size());
  for (const Triangle& triangle : triangles) {
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t a = triangle.v[side];
      const std::uint32_t b = triangle.v[(side + 1) % 3];
      if (a != b) keys.push_back(edge_key(a, b));
    }
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());

  topology.edges.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    topology.edges.push_back({{static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)}});
  }
  topology.triangle_edges.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    TriangleEdges edges{};
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t a = triangle.v[side];
      const std::uint32_t b = triangle.v[(side + 1) % 3];
      const auto found = std::lower_bound(keys.begin(), keys.end(), edge_key(a, b));
      edges.e[side] = a == b ? kNoIndex : static_cast<std::uint32_t>(found - keys.begin());
    }
    topology.triangle_edges.push_back(edges);
  }
  if (!segments.empty()) add_segments(segments, keys, topology);
  topology.ownership = assign_ownership(view_of(topology), std::vector<std::uint8_t>(topology.triangles.size(), 0));
  topology.patches = patch_order(view_of(topology));
  return topology;
}

std::vector<Ownership> assign_ownership(const MeshView& mesh, Span<const std::uint8_t> left_out) {
  std::vector<Ownership> ownership(mesh.triangles.size(), 0);
  std::vector<bool> vertex_owned(mesh.vertex_count, false);
  std::vector<bool> edge_owned(mesh.edges.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (left_out[t] != 0) continue;
    if (t >= mesh.face_count()) ownership[t] = static_cast<Ownership>(kSegment);
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t vertex = mesh.triangles[t].v[corner] - mesh.first_vertex;
      if (!vertex_owned[vertex]) ownership[t] |= static_cast<Ownership>(1U << corner);
      vertex_owned[vertex] = true;
      const std::uint32_t side = mesh.triangle_edges[t].e[corner];
      if (side == kNoIndex) continue;
      const std::uint32_t edge = side - mesh.first_edge;
      if (!edge_owned[edge]) ownership[t] |= static_cast<Ownership>(8U << corner);
      edge_owned[edge] = true;
    }
  }
  return ownership;
}

namespace {

void list_stars(const MeshView& mesh, const VertexTriangles& triangles_of, std::vector<VertexStar>& stars) {
  stars.reserve(mesh.vertex_count);
  std::vector<Triangle> triangles;
  for (std::uint32_t v = mesh.first_vertex; v < mesh.first_vertex + mesh.vertex_count; ++v) {
    triangles.clear();
    for (const std::uint32_t t : triangles_of.of(v)) triangles.push_back(mesh.triangles[t]);
    if (!triangles.empty()) stars.push_back(star_of(v, triangles));
  }
}

}  // namespace

NeighbourFeatures neighbour_features(const MeshView& mesh, Span<const Ownership> ownership,
                                     std::vector<FeatureEnds>* ends) {
  NeighbourFeatures out;
  const VertexTriangles triangles_of(mesh);
  std::uint64_t corners_around = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const std::uint64_t count = triangles_of.of(mesh.first_vertex + v).size();
    corners_around += count * count;
  }
  out.are_listed = has_few_corners_around(corners_around, mesh.triangles.size());
  if (!out.are_listed) return out;
  list_stars(mesh, triangles_of, out.stars);

  const auto triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
  if (ends != nullptr) ends->resize(triangle_count);
  std::vector<NeighbourFeatures> parts((triangle_count + kTrianglesAtOnce - 1) / kTrianglesAtOnce);
  parallel::for_each(parts.size(), [&](std::size_t part) {
    NeighbourLister lister(mesh, ownership, parts[part]);
    const auto begin = static_cast<std::uint32_t>(part) * kTrianglesAtOnce;
    const std::uint32_t end = std::min(begin + kTrianglesAtOnce, triangle_count);
    for (std::uint32_t t = begin; t < end; ++t) {
      if ((ownership[t] & kLeftOut) == 0) for_each_neighbour(mesh, triangles_of, t, [&](auto n) { lister.add(t, n); });
      if (ends != nullptr) (*ends)[t] = ends_of(parts[part]);
    }
  });
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const FeatureEnds before = ends_of(out);
    out.vertex_triangle.insert(out.vertex_triangle.end(), parts[part].vertex_triangle.begin(),
                               parts[part].vertex_triangle.end());
    out.edge_edge.insert(out.edge_edge.end(), parts[part].edge_edge.begin(), parts[part].edge_edge.end());
    if (ends == nullptr) continue;
    const std::size_t begin = part * kTrianglesAtOnce;
    for (std::size_t t = begin; t < std::min<std::size_t>(begin + kTrianglesAtOnce, triangle_count); ++t) {
      (*ends)[t].vertex_triangle += before.vertex_triangle;
      (*ends)[t].edge_edge += before.edge_edge;
    }
  }
  return out;
}

}  // namespace softcd
