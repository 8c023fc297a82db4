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
  if (body.lists_neighbours != changing.lists_neighbours() || (body.lists_neighbours && !body.changing->has_slots)) {
    drop_neighbours(body);
  }
  changing.forget_changes();
}

namespace {

/// What is listed of the neighbours of a body whose triangles have changed.
class ChangedNeighbours {
 public:
  /// Indices into the scene's arrays are those into the mesh, and these more.
  struct Numbering {
    std::uint64_t vertex_triangle, edge_edge;
  };

  ChangedNeighbours(ChangingBody& body, const Numbering& first, const FeaturePart& vertex_triangle,
                    const FeaturePart& edge_edge)
      : body_(body), first_(first), vertex_triangle_(vertex_triangle), edge_edge_(edge_edge) {}

  /// In order of triangles, as what lies beside each other is in the cache. Slots that become free in this order are
  /// taken in the opposite one: triangles' features stay near those of triangles nearby.
  bool list() {
    const ChangingMesh& mesh = body_.mesh;
    for (const std::uint32_t t : sorted(mesh.stale_triangles())) drop(t);
    const std::vector<std::uint32_t> relisted = sorted(mesh.relisted_triangles());
    return std::all_of(relisted.rbegin(), relisted.rend(),
                       [&](std::uint32_t t) { return t >= mesh_.triangles.size() || relist(t); });
  }

 private:
  static std::vector<std::uint32_t> sorted(Span<const std::uint32_t> triangles) {
    std::vector<std::uint32_t> all(triangles.begin(), triangles.end());
    std::sort(all.begin(), all.end());
    return all;
  }

  static std::uint32_t high(std::uint64_t feature) { return static_cast<std::uint32_t>(feature >> 32); }
  static std::uint32_t low(std::uint64_t feature) { return static_cast<std::uint32_t>(feature); }

  void drop(std::uint32_t triangle) {
    body_.vertex_triangle.drop(vertex_triangle_, triangle, [&](std::uint64_t pair) {
      pair -= first_.vertex_triangle;
      return body_.mesh.is_stale_pair(high(pair), low(pair));
    });
    body_.edge_edge.drop(edge_edge_, triangle, [&](std::uint64_t edges) {
      edges -= first_.edge_edge;
      return body_.mesh.are_stale_edges(high(edges), low(edges));
    });
  }

  /// All that it has with its neighbours is its own; where a neighbour is relisted, too, half of that.
  bool relist(std::uint32_t triangle) {
    features_.vertex_triangle.clear();
    features_.edge_edge.clear();
    for_each_neighbour(mesh_, body_.mesh, triangle, [&](std::uint32_t neighbour) {
      lister_.add(triangle, neighbour);
      if (!body_.mesh.is_relisted(neighbour)) lister_.add(neighbour, triangle);
    });
    const auto add = [triangle](FeatureSlots& slots, const FeaturePart& part, std::uint64_t first,
                                const std::vector<std::uint64_t>& features) {
      return std::all_of(features.begin(), features.end(),
                         [&](std::uint64_t feature) { return slots.add(part, triangle, feature + first); });
    };
    return add(body_.vertex_triangle, vertex_triangle_, first_.vertex_triangle, features_.vertex_triangle) &&
           add(body_.edge_edge, edge_edge_, first_.edge_edge, features_.edge_edge);
  }

  ChangingBody& body_;
  Numbering first_;
  FeaturePart vertex_triangle_, edge_edge_;
  MeshView mesh_ = view_of(body_.mesh.topology());
  NeighbourFeatures features_;
  NeighbourLister lister_{mesh_, body_.mesh.topology().ownership, features_};
};

}  // namespace

/// Brings up to date what is listed of neighbours; where there is no room for that it is listed anew.
void SceneStore::settle_neighbours() {
  for (Body& body : bodies_) {
    if (!body.changing || !body.lists_neighbours || body.changing->mesh.relisted_triangles().empty()) continue;
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
  const auto part_of = [](std::vector<std::uint64_t>& list, const Range& part, UnsentRanges& unsent) {
    return FeaturePart{{list.data() + part.begin, part.end - part.begin}, part.begin, unsent};
  };
  const ChangedNeighbours::Numbering first{(std::uint64_t{body.vertices.first} << 32) + body.triangles.first,
                                           (std::uint64_t{body.edges.first} << 32) + body.edges.first};
  ChangedNeighbours neighbours(
      *body.changing, first,
      part_of(vertex_triangle_neighbours_, body.vertex_triangle_neighbours, unsent_vertex_triangle_neighbours_),
      part_of(edge_edge_neighbours_, body.edge_edge_neighbours, unsent_edge_edge_neighbours_));
  if (!neighbours.list()) return false;
  body.changing->mesh.forget_relisted();
  return true;
}

/// With room for more where triangles are changed.
NeighbourFeatures SceneStore::listed_neighbours(Body& body) const {
  const Span<const Ownership> ownership(ownership_.data() + body.triangles.first, body.triangles.count);
  if (!body.changing) return neighbour_features(mesh_of(body), ownership);
  ChangingBody& changing = *body.changing;
  std::vector<FeatureEnds> ends;
  NeighbourFeatures features = neighbour_features(mesh_of(body), ownership, &ends);
  for (std::vector<std::uint64_t>* const list : {&features.vertex_triangle, &features.edge_edge}) {
    list->resize(list->size() + list->size() / 4, kNoFeatures);
  }
  changing.vertex_triangle.assign(ends, &FeatureEnds::vertex_triangle, features.vertex_triangle.size());
  changing.edge_edge.assign(ends, &FeatureEnds::edge_edge, features.edge_edge.size());
  changing.has_slots = features.are_listed;
  changing.mesh.forget_relisted();
  return features;
}

}  // namespace softcd
