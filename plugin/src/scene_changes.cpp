#include <algorithm>
#include <memory>

#include "mesh_numbering.hpp"
#include "scene_store.hpp"
#include "softcd/mesh/neighbour_lister.hpp"

// Meshes of which a few triangles are changed, at the cost of these.
namespace softcd {

/// With ownership as if no triangle were left out.
Topology SceneStore::copy_of_mesh(const Body& body) const {
  const MeshView mesh = mesh_of(body);
  Topology copy;
  copy.vertex_count = mesh.vertex_count;
  copy.triangles.reserve(mesh.triangles.size());
  copy.triangle_edges.reserve(mesh.triangles.size());
  copy.edges.reserve(mesh.edges.size());
  for (const Triangle& triangle : mesh.triangles)
    copy.triangles.push_back(renumbered(triangle, 0U - mesh.first_vertex));
  for (const TriangleEdges& edges : mesh.triangle_edges) {
    copy.triangle_edges.push_back(renumbered(edges, 0U - mesh.first_edge));
  }
  for (const Edge& edge : mesh.edges) copy.edges.push_back(renumbered(edge, 0U - mesh.first_vertex));
  copy.ownership = assign_ownership(view_of(copy), std::vector<std::uint8_t>(copy.triangles.size(), 0));
  return copy;
}

const ChangingMesh& SceneStore::changing_mesh(Body& body) {
  if (!body.changing) {
    body.changing = std::make_unique<ChangingBody>(body.new_mesh ? *body.new_mesh : copy_of_mesh(body));
    body.changing->is_new = body.new_mesh.has_value();
    body.new_mesh.reset();
  }
  return body.changing->mesh;
}

void SceneStore::update_body(Body& body, const BodyDesc& desc, Span<const std::uint32_t> changed) {
  const Topology& mesh = changing_mesh(body).topology();
  const std::size_t added = desc.triangles.size() - std::min(mesh.triangles.size(), desc.triangles.size());
  plan(body, desc.vertex_count, desc.triangles.size(), mesh.edges.size() + 3 * (changed.size() + added));
  body.changing->mesh.change(desc.triangles, desc.vertex_count, changed);
  const auto outgrows = [](const Place& place) { return place.next_capacity > place.capacity; };
  body.changing->is_new |= outgrows(body.vertices) || outgrows(body.triangles) || outgrows(body.edges);
  body.changing->is_new |= body.left_out_triangles > 0;
  has_new_layout_ |= body.changing->is_new;
  replace(body, desc);
}

void SceneStore::settle_changes() {
  for (Body& body : bodies_) {
    if (body.changing && body.changing->mesh.has_changes()) settle_changes(body);
  }
}

/// Does all of it again where memory ran out.
void SceneStore::settle_changes(Body& body) {
  ++mesh_revision_;
  ChangingMesh& changing = body.changing->mesh;
  const Topology& mesh = changing.topology();
  const std::uint32_t v = body.vertices.first;
  for (const std::uint32_t t : changing.changed_triangles()) {
    const bool is_there = t < mesh.triangles.size();
    const std::size_t place = std::size_t{body.triangles.first} + t;
    triangles_.data()[place] = is_there ? renumbered(mesh.triangles[t], v) : Triangle{{v, v, v}};
    triangle_edges_.data()[place] =
        is_there ? renumbered(mesh.triangle_edges[t], body.edges.first) : TriangleEdges{{kNoIndex, kNoIndex, kNoIndex}};
    ownership_.data()[place] = is_there ? mesh.ownership[t] : static_cast<Ownership>(kLeftOut);
    body.unsent.triangles.add(t, t + 1);
  }
  for (const std::uint32_t e : changing.changed_edges()) {
    edges_.data()[std::size_t{body.edges.first} + e] = renumbered(mesh.edges[e], v);
    body.unsent.edges.add(e, e + 1);
  }
  body.vertices.count = mesh.vertex_count;
  body.triangles.count = static_cast<std::uint32_t>(mesh.triangles.size());
  body.edges.count = static_cast<std::uint32_t>(mesh.edges.size());
  body.named_strays.clear();
  body.is_closed.reset();
  // What was listed before triangles were changed can only be listed anew.
  if (body.lists_neighbours != changing.lists_neighbours() || (body.lists_neighbours && !body.changing->has_blocks)) {
    drop_neighbours(body);
  }
  changing.forget_changes();
}

/// Brings up to date what is listed of neighbours; where there is no room for that it is listed anew.
void SceneStore::settle_neighbours() {
  for (Body& body : bodies_) {
    if (!body.changing || !body.lists_neighbours || body.changing->mesh.stale_triangles().empty()) continue;
    bool is_settled = false;
    try {
      is_settled = settle_neighbours(body);
    } catch (...) {
      drop_neighbours(body);
      throw;
    }
    if (!is_settled) drop_neighbours(body);
  }
}

bool SceneStore::settle_neighbours(Body& body) {
  ChangingBody& changing = *body.changing;
  const Topology& topology = changing.mesh.topology();
  const MeshView mesh = view_of(topology);
  NeighbourFeatures features;
  NeighbourLister lister(mesh, topology.ownership, features);
  const auto put = [](FeatureBlocks& blocks, std::uint32_t t, std::vector<std::uint64_t>& of_triangle,
                      std::uint64_t first, std::vector<std::uint64_t>& list, const Range& part, UnsentRanges& unsent) {
    for (std::uint64_t& pair : of_triangle) pair += first;
    const Span<std::uint64_t> of_body(list.data() + part.begin, part.end - part.begin);
    return blocks.put(of_body, t, of_triangle, part.begin, unsent);
  };
  const std::uint64_t first_pair = (std::uint64_t{body.vertices.first} << 32) + body.triangles.first;
  const std::uint64_t first_edges = (std::uint64_t{body.edges.first} << 32) + body.edges.first;
  for (const std::uint32_t t : changing.mesh.stale_triangles()) {
    features.vertex_triangle.clear();
    features.edge_edge.clear();
    if (t < topology.triangles.size()) for_each_neighbour(mesh, changing.mesh, t, [&](auto n) { lister.add(t, n); });
    if (!put(changing.vertex_triangle, t, features.vertex_triangle, first_pair, vertex_triangle_neighbours_,
             body.vertex_triangle_neighbours, unsent_vertex_triangle_neighbours_) ||
        !put(changing.edge_edge, t, features.edge_edge, first_edges, edge_edge_neighbours_, body.edge_edge_neighbours,
             unsent_edge_edge_neighbours_)) {
      return false;
    }
  }
  changing.mesh.forget_stale();
  return true;
}

/// With room for more where triangles are changed.
NeighbourFeatures SceneStore::listed_neighbours(Body& body) const {
  const Span<const Ownership> ownership(ownership_.data() + body.triangles.first, body.triangles.count);
  if (!body.changing) return neighbour_features(mesh_of(body), ownership);
  ChangingBody& changing = *body.changing;
  std::vector<FeatureEnds> ends;
  NeighbourFeatures features = neighbour_features(mesh_of(body), ownership, &ends);
  changing.vertex_triangle.assign(ends, &FeatureEnds::vertex_triangle);
  changing.edge_edge.assign(ends, &FeatureEnds::edge_edge);
  changing.has_blocks = features.are_listed;
  for (std::vector<std::uint64_t>* const list : {&features.vertex_triangle, &features.edge_edge}) {
    list->resize(list->size() + list->size() / 4, kNoFeatures);
  }
  changing.mesh.forget_stale();
  return features;
}

}  // namespace softcd
