#include "neighbour_lists.hpp"

#include <algorithm>

#include "scene_layout.hpp"
#include "softcd/core/parallel.hpp"
#include "softcd/mesh/neighbour_lister.hpp"

namespace softcd {
namespace {

/// The scene's first numbers for a mesh's features: of vertices; a vertex or edge << 32, and a triangle or edge.
struct Numbering {
  explicit Numbering(const Body& body)
      : stars(body.vertices.first),
        vertex_triangle((std::uint64_t{body.vertices.first} << 32) + body.triangles.first),
        edge_edge((std::uint64_t{body.edges.first} << 32) + body.edges.first) {}

  std::uint64_t stars, vertex_triangle, edge_edge;
};

/// The listed features of a body whose triangles have changed.
class ChangedNeighbours {
 public:
  ChangedNeighbours(Body& body, const FeaturePart& vertex_triangle, const FeaturePart& edge_edge)
      : changing_(body.changing->mesh),
        slots_(*body.neighbours.slots),
        first_(body),
        vertex_triangle_(vertex_triangle),
        edge_edge_(edge_edge) {}

  /// Drops stale features and lists new ones. Returns false if there are too few slots. Works in the order of
  /// triangles, for the cache. Slots are reused in the opposite order to their release, so features of nearby triangles
  /// stay close to each other.
  bool list() {
    for (const std::uint32_t t : sorted(changing_.stale_triangles())) drop(t);
    const std::vector<std::uint32_t> relisted = sorted(changing_.relisted_triangles());
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
    slots_.vertex_triangle.drop(vertex_triangle_, triangle, [&](std::uint64_t pair) {
      pair -= first_.vertex_triangle;
      return changing_.is_stale_pair(high(pair), low(pair));
    });
    slots_.edge_edge.drop(edge_edge_, triangle, [&](std::uint64_t edges) {
      edges -= first_.edge_edge;
      return changing_.are_stale_edges(high(edges), low(edges));
    });
  }

  /// Lists all features of a triangle with its neighbours. With a neighbour that is listed again itself, lists only
  /// half of them.
  bool relist(std::uint32_t triangle) {
    features_.vertex_triangle.clear();
    features_.edge_edge.clear();
    for_each_neighbour(mesh_, changing_, triangle, [&](std::uint32_t neighbour) {
      lister_.add(triangle, neighbour);
      if (!changing_.is_relisted(neighbour)) lister_.add(neighbour, triangle);
    });
    const auto add = [triangle](FeatureSlots& slots, const FeaturePart& part, std::uint64_t first,
                                const std::vector<std::uint64_t>& features) {
      return std::all_of(features.begin(), features.end(),
                         [&](std::uint64_t feature) { return slots.add(part, triangle, feature + first); });
    };
    return add(slots_.vertex_triangle, vertex_triangle_, first_.vertex_triangle, features_.vertex_triangle) &&
           add(slots_.edge_edge, edge_edge_, first_.edge_edge, features_.edge_edge);
  }

  const ChangingMesh& changing_;
  BodyNeighbours::Slots& slots_;
  Numbering first_;
  FeaturePart vertex_triangle_, edge_edge_;
  MeshView mesh_ = view_of(changing_.topology());
  NeighbourFeatures features_;
  NeighbourLister lister_{mesh_, changing_.topology().ownership, features_};
};

void add_to_numbers(std::uint64_t& feature, std::uint64_t added) {
  if (feature != kNoFeatures) feature += added;
}

void add_to_numbers(VertexStar& star, std::uint64_t added) {
  const auto vertices = static_cast<std::uint32_t>(added);
  star.centre += vertices;
  for (std::uint32_t& v : star.ring) v += v == kNoIndex ? 0U : vertices;
}

/// Returns the features of a body; with free slots if its triangles are being changed.
NeighbourFeatures features_of(Body& body, const SceneLayout& layout) {
  const MeshView mesh = layout.mesh_of(body);
  if (!body.changing) return neighbour_features(mesh, layout.ownership_of(body));
  std::vector<FeatureEnds> ends;
  NeighbourFeatures features = neighbour_features(mesh, layout.ownership_of(body), &ends);
  for (std::vector<std::uint64_t>* const list : {&features.vertex_triangle, &features.edge_edge}) {
    list->resize(list->size() + list->size() / 4, kNoFeatures);
  }
  features.stars.clear();
  if (features.are_listed) {
    body.neighbours.slots = std::make_unique<BodyNeighbours::Slots>();
    BodyNeighbours::Slots& slots = *body.neighbours.slots;
    slots.vertex_triangle.assign(ends, &FeatureEnds::vertex_triangle, features.vertex_triangle.size());
    slots.edge_edge.assign(ends, &FeatureEnds::edge_edge, features.edge_edge.size());
  }
  body.changing->mesh.forget_relisted();
  return features;
}

}  // namespace

template <class Feature>
void NeighbourLists::List<Feature>::renumber(Body& body, std::uint64_t numbering) {
  ListedFeatures& listed = body.neighbours.*part;
  if (listed.numbering == numbering) return;
  for (std::uint64_t i = listed.range.begin; i < listed.range.end; ++i) {
    add_to_numbers(features[i], numbering - listed.numbering);
  }
  listed.numbering = numbering;
  unsent.add_from(0);
}

/// Moves the bodies' parts together if there is an unused gap between them.
template <class Feature>
void NeighbourLists::List<Feature>::close_gaps(std::vector<Body>& bodies) {
  std::uint64_t listed_size = 0;
  for (const Body& body : bodies) {
    const Range& range = (body.neighbours.*part).range;
    if (body.neighbours.are_listed) listed_size += range.end - range.begin;
  }
  if (listed_size == features.size()) return;
  std::vector<Range*> kept;
  for (Body& body : bodies) {
    if (body.neighbours.are_listed) kept.push_back(&(body.neighbours.*part).range);
  }
  std::sort(kept.begin(), kept.end(), [](const Range* a, const Range* b) { return a->begin < b->begin; });
  std::uint64_t end = 0;
  for (Range* const range : kept) {
    const std::uint64_t size = range->end - range->begin;
    if (range->begin != end) unsent.add_from(end);
    std::copy_n(features.begin() + static_cast<std::ptrdiff_t>(range->begin), size,
                features.begin() + static_cast<std::ptrdiff_t>(end));
    *range = {end, end + size};
    end += size;
  }
  features.resize(end);
  unsent.add_from(end);
}

/// Appends a body's features. Allocates nothing where capacity was reserved.
template <class Feature>
void NeighbourLists::List<Feature>::append(BodyNeighbours& body, const std::vector<Feature>& added,
                                           std::uint64_t numbering) {
  const std::uint64_t begin = features.size();
  features.insert(features.end(), added.begin(), added.end());
  body.*part = {{begin, features.size()}, numbering};
}

template <class Feature>
FeaturePart NeighbourLists::List<Feature>::part_of(const Body& body) {
  const Range& range = (body.neighbours.*part).range;
  return {{features.data() + range.begin, range.end - range.begin}, range.begin, unsent};
}

void NeighbourLists::update(std::vector<Body>& bodies) {
  for (Body& body : bodies) {
    if (!body.neighbours.are_listed) continue;
    const Numbering numbering(body);
    vertex_triangle_.renumber(body, numbering.vertex_triangle);
    edge_edge_.renumber(body, numbering.edge_edge);
    stars_.renumber(body, numbering.stars);
    if (!body.changing || body.changing->mesh.relisted_triangles().empty()) continue;
    try {
      if (ChangedNeighbours(body, vertex_triangle_.part_of(body), edge_edge_.part_of(body)).list()) {
        body.changing->mesh.forget_relisted();
        continue;
      }
    } catch (...) {
      body.neighbours = {};
      throw;
    }
    body.neighbours = {};
  }
}

void NeighbourLists::list_missing(SceneLayout& layout) {
  vertex_triangle_.close_gaps(layout.bodies());
  edge_edge_.close_gaps(layout.bodies());
  stars_.close_gaps(layout.bodies());
  std::vector<Body*> unlisted;
  for (Body& body : layout.bodies()) {
    const bool touches_itself = body.settings.self_collision && !body.settings.kinematic;
    if (!body.is_removed && touches_itself && !body.neighbours.are_known) unlisted.push_back(&body);
  }
  if (unlisted.empty()) return;
  // When listing fails for one body, oneTBB silently stops the loops of the others.
  std::vector<NeighbourFeatures> listed(unlisted.size());
  parallel::for_each(unlisted.size(), [&](std::size_t i) { listed[i] = features_of(*unlisted[i], layout); });
  std::size_t vertex_triangle = vertex_triangle_.features.size();
  std::size_t edge_edge = edge_edge_.features.size();
  std::size_t stars = stars_.features.size();
  for (const NeighbourFeatures& features : listed) {
    vertex_triangle += features.vertex_triangle.size();
    edge_edge += features.edge_edge.size();
    stars += features.stars.size();
  }
  vertex_triangle_.features.reserve(vertex_triangle);
  edge_edge_.features.reserve(edge_edge);
  stars_.features.reserve(stars);
  for (std::size_t i = 0; i < unlisted.size(); ++i) {
    BodyNeighbours& body = unlisted[i]->neighbours;
    const Numbering numbering(*unlisted[i]);
    body.are_known = true;
    body.are_listed = listed[i].are_listed;
    vertex_triangle_.append(body, listed[i].vertex_triangle, numbering.vertex_triangle);
    edge_edge_.append(body, listed[i].edge_edge, numbering.edge_edge);
    stars_.append(body, listed[i].stars, numbering.stars);
  }
}

void NeighbourLists::append_changes(SceneChanges& changes, bool all) const {
  const auto ranges = [all](const auto& list) {
    return all ? std::vector<Range>{{0, list.features.size()}} : list.unsent.within(list.features.size());
  };
  changes.vertex_triangle_neighbours = ranges(vertex_triangle_);
  changes.edge_edge_neighbours = ranges(edge_edge_);
  changes.stars = ranges(stars_);
}

void NeighbourLists::forget_changes() noexcept {
  const auto forget = [](auto& list) { list.unsent.clear(list.features.size()); };
  forget(vertex_triangle_);
  forget(edge_edge_);
  forget(stars_);
}

}  // namespace softcd
