#include "softcd/mesh/changing_mesh.hpp"
#include "softcd/mesh/features.hpp"

#include <algorithm>

namespace softcd {
namespace {

/// Returns whether this is the triangle's first corner at its vertex.
bool is_first(const Triangle& triangle, std::uint32_t corner) {
  const auto* const at = triangle.v + corner;
  return std::find(triangle.v, at, *at) == at;
}

std::uint32_t place_of(const std::uint32_t (&three)[3], std::uint32_t wanted) {
  return static_cast<std::uint32_t>(std::find(three, three + 3, wanted) - three);
}

}  // namespace

ChangingMesh::ChangingMesh(Topology mesh) : mesh_(std::move(mesh)) {
  const std::size_t triangles = mesh_.triangles.size();
  links_.resize(3 * triangles);
  first_corner_.resize(mesh_.vertex_count, kNoIndex);
  triangle_count_.resize(mesh_.vertex_count, 0);
  for (std::uint32_t corner = 0; corner < 3 * triangles; ++corner) {
    if (is_first(mesh_.triangles[corner / 3], corner % 3)) link(corner);
  }
}

void ChangingMesh::change(Span<const Triangle> triangles, std::uint32_t vertex_count,
                          Span<const std::uint32_t> changed) {
  const auto before = static_cast<std::uint32_t>(mesh_.triangles.size());
  const auto now = static_cast<std::uint32_t>(triangles.size());
  const std::uint32_t most = std::max(before, now);
  touched_.clear();
  touched_.reserve(most);
  for (const std::uint32_t t : changed) touched_.insert(t);
  for (std::uint32_t t = std::min(before, now); t < most; ++t) touched_.insert(t);
  // Sorted, they are better cached, and new edges do not depend on the order of `changed`.
  touched_.sort();
  reserve(most, std::max(vertex_count, mesh_.vertex_count), touched_.indices().size());

  has_changes_ = true;
  for (const std::uint32_t t : touched_.indices()) {
    if (t < before) take_out(t);
  }
  find_lost_edges();
  mesh_.triangles.resize(now);
  mesh_.triangle_edges.resize(now);
  mesh_.ownership.resize(now);
  links_.resize(std::size_t{3} * now);
  mesh_.vertex_count = vertex_count;
  // Removed vertices are visited once more, and have no triangles.
  first_corner_.resize(std::max<std::size_t>(vertex_count, first_corner_.size()), kNoIndex);
  triangle_count_.resize(first_corner_.size(), 0);
  for (const std::uint32_t t : touched_.indices()) {
    if (t < now) put_in(t, triangles[t]);
  }
  for (const std::uint32_t v : vertices_.indices()) give_vertex(v);
  for (const std::uint32_t e : edges_.indices()) give_edge(e);
  vertices_.clear();
  edges_.clear();
  first_corner_.resize(vertex_count);
  triangle_count_.resize(vertex_count);
}

void ChangingMesh::forget_changes() noexcept {
  has_changes_ = false;
  changed_triangles_.clear();
  changed_edges_.clear();
}

void ChangingMesh::forget_relisted() noexcept {
  finds_relisted_ = true;
  for (IndexSet* const set : {&relisted_, &stale_, &stale_vertices_, &stale_edges_}) set->clear();
}

/// Reserves all memory that the change may need.
void ChangingMesh::reserve(std::size_t triangle_count, std::size_t vertex_count, std::size_t touched_count) {
  const std::size_t edges = mesh_.edges.size() + 3 * touched_count;
  reserve_roomy(mesh_.triangles, triangle_count);
  reserve_roomy(mesh_.triangle_edges, triangle_count);
  reserve_roomy(mesh_.ownership, triangle_count);
  reserve_roomy(mesh_.edges, edges);
  reserve_roomy(links_, 3 * triangle_count);
  reserve_roomy(first_corner_, vertex_count);
  reserve_roomy(triangle_count_, vertex_count);
  reserve_roomy(free_edges_, free_edges_.size() + 3 * touched_count);
  reserve_roomy(lost_by_key_, 3 * touched_count);
  changed_triangles_.reserve(triangle_count);
  relisted_.reserve(triangle_count);
  stale_.reserve(triangle_count);
  stale_vertices_.reserve(vertex_count);
  stale_edges_.reserve(edges);
  changed_edges_.reserve(edges);
  vertices_.reserve(vertex_count);
  edges_.reserve(edges);
}

void ChangingMesh::take_out(std::uint32_t triangle) noexcept {
  mark_changing(triangle);
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t edge = mesh_.triangle_edges[triangle].e[corner];
    if (edge != kNoIndex) edges_.insert(edge);
    vertices_.insert(mesh_.triangles[triangle].v[corner]);
    if (is_first(mesh_.triangles[triangle], corner)) unlink(3 * triangle + corner);
  }
}

/// Collects the edges that removed triangles had. Such an edge may stay, although no triangle has it at the moment.
void ChangingMesh::find_lost_edges() noexcept {
  lost_by_key_.clear();
  for (const std::uint32_t e : edges_.indices()) {
    lost_by_key_.push_back({edge_key(mesh_.edges[e].v[0], mesh_.edges[e].v[1]), e});
  }
  std::sort(lost_by_key_.begin(), lost_by_key_.end(),
            [](const KeyedEdge& a, const KeyedEdge& b) { return a.key < b.key; });
}

void ChangingMesh::put_in(std::uint32_t triangle, const Triangle& vertices) noexcept {
  // A new triangle has no listed features.
  changed_triangles_.insert(triangle);
  if (finds_relisted_) relisted_.insert(triangle);
  TriangleEdges& edges = mesh_.triangle_edges[triangle];
  edges = {{kNoIndex, kNoIndex, kNoIndex}};
  for (std::uint32_t side = 0; side < 3; ++side) {
    const std::uint32_t a = vertices.v[side];
    const std::uint32_t b = vertices.v[(side + 1) % 3];
    if (a == b) continue;
    // A triangle with two equal corners has two equal sides.
    const auto* const same = std::find_if(edges.e, edges.e + side, [&](const std::uint32_t& e) {
      return e != kNoIndex && edge_key(mesh_.edges[e].v[0], mesh_.edges[e].v[1]) == edge_key(a, b);
    });
    edges.e[side] = same != edges.e + side ? *same : edge_between(a, b);
    edges_.insert(edges.e[side]);
  }
  mesh_.triangles[triangle] = vertices;
  mesh_.ownership[triangle] = 0;
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    vertices_.insert(vertices.v[corner]);
    if (is_first(vertices, corner)) link(3 * triangle + corner);
  }
}

/// Returns the edge of a present or removed triangle, or else makes a new edge.
std::uint32_t ChangingMesh::edge_between(std::uint32_t a, std::uint32_t b) noexcept {
  const std::uint64_t key = edge_key(a, b);
  const auto lost = std::lower_bound(lost_by_key_.begin(), lost_by_key_.end(), key,
                                     [](const KeyedEdge& edge, std::uint64_t wanted) { return edge.key < wanted; });
  if (lost != lost_by_key_.end() && lost->key == key) return lost->edge;
  const bool by_first = triangle_count_[a] <= triangle_count_[b];
  const std::uint32_t end = by_first ? b : a;
  for (std::uint32_t corner = first_corner_[by_first ? a : b]; corner != kNoIndex; corner = links_[corner].next) {
    const Triangle& other = mesh_.triangles[corner / 3];
    if (!has_vertex(other, end)) continue;
    for (const std::uint32_t e : mesh_.triangle_edges[corner / 3].e) {
      if (e != kNoIndex && edge_key(mesh_.edges[e].v[0], mesh_.edges[e].v[1]) == key) return e;
    }
  }
  auto edge = static_cast<std::uint32_t>(mesh_.edges.size());
  if (free_edges_.empty()) {
    mesh_.edges.push_back({});
  } else {
    edge = free_edges_.back();
    free_edges_.pop_back();
  }
  mesh_.edges[edge] = {{std::min(a, b), std::max(a, b)}};
  changed_edges_.insert(edge);
  return edge;
}

void ChangingMesh::link(std::uint32_t corner) noexcept {
  const std::uint32_t v = mesh_.triangles[corner / 3].v[corner % 3];
  links_[corner] = {kNoIndex, first_corner_[v]};
  if (first_corner_[v] != kNoIndex) links_[first_corner_[v]].previous = corner;
  first_corner_[v] = corner;
  corners_around_ += 2 * std::uint64_t{triangle_count_[v]++} + 1;
}

void ChangingMesh::unlink(std::uint32_t corner) noexcept {
  const std::uint32_t v = mesh_.triangles[corner / 3].v[corner % 3];
  const Links links = links_[corner];
  (links.previous == kNoIndex ? first_corner_[v] : links_[links.previous].next) = links.next;
  if (links.next != kNoIndex) links_[links.next].previous = links.previous;
  corners_around_ -= 2 * std::uint64_t{--triangle_count_[v]} + 1;
}

/// Marks a triangle that is about to change. Call it while the triangle is still unchanged.
void ChangingMesh::mark_changing(std::uint32_t triangle) noexcept {
  changed_triangles_.insert(triangle);
  if (!finds_relisted_ || relisted_.contains(triangle)) return;
  relisted_.insert(triangle);
  mark_stale(triangle);
}

/// Marks all triangles and features that took part in listed pairs with this triangle. Removed neighbours were marked
/// on their removal.
void ChangingMesh::mark_stale(std::uint32_t triangle) noexcept {
  const Ownership ownership = mesh_.ownership[triangle];
  stale_.insert(triangle);
  for (std::uint32_t corner = 0; corner < 3; ++corner) {
    const std::uint32_t v = mesh_.triangles[triangle].v[corner];
    if ((ownership & (1U << corner)) != 0) stale_vertices_.insert(v);
    if ((ownership & (8U << corner)) != 0) stale_edges_.insert(mesh_.triangle_edges[triangle].e[corner]);
    for_each_triangle_of(v, [&](std::uint32_t t) { stale_.insert(t); });
  }
}

/// Gives a feature at the vertex to the first of the vertex's triangles that has it. ownership_in(t) is the feature's
/// bit in triangle t, or 0 where t does not have it. Returns that triangle, or kNoIndex where there is none.
template <class OwnershipIn>
std::uint32_t ChangingMesh::give(std::uint32_t vertex, const OwnershipIn& ownership_in) noexcept {
  std::uint32_t first = kNoIndex;
  std::uint32_t owner = kNoIndex;
  for_each_triangle_of(vertex, [&](std::uint32_t t) {
    const Ownership bit = ownership_in(t);
    if (bit != 0) first = std::min(first, t);
    if ((mesh_.ownership[t] & bit) != 0) owner = t;
  });
  if (first == owner) return first;
  if (owner != kNoIndex) {
    mark_changing(owner);
    mesh_.ownership[owner] = static_cast<Ownership>(mesh_.ownership[owner] & ~ownership_in(owner));
  }
  mark_changing(first);
  mesh_.ownership[first] = static_cast<Ownership>(mesh_.ownership[first] | ownership_in(first));
  return first;
}

void ChangingMesh::give_vertex(std::uint32_t vertex) noexcept {
  give(vertex, [&](std::uint32_t t) { return static_cast<Ownership>(1U << place_of(mesh_.triangles[t].v, vertex)); });
}

/// Gives the edge to its first triangle. Frees it where no triangle has it any more.
void ChangingMesh::give_edge(std::uint32_t edge) noexcept {
  const auto [a, b] = mesh_.edges[edge].v;
  const std::uint32_t owner = give(triangle_count_[a] <= triangle_count_[b] ? a : b, [&](std::uint32_t t) {
    const std::uint32_t side = place_of(mesh_.triangle_edges[t].e, edge);
    return static_cast<Ownership>(side < 3 ? 8U << side : 0U);
  });
  if (owner != kNoIndex) return;
  mesh_.edges[edge] = {};
  free_edges_.push_back(edge);
  changed_edges_.insert(edge);
}

}  // namespace softcd
