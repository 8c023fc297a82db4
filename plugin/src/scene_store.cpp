#include "scene_store.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <utility>

#include "mesh_numbering.hpp"
#include "softcd/mesh/closed_surface.hpp"
#include "validation.hpp"

namespace softcd {
namespace {

/// Room for `count` elements: a quarter more than that where the body has outgrown its place.
std::uint32_t capacity_for(std::size_t count, const Place& place, bool is_placed) {
  const auto wanted = static_cast<std::uint32_t>(count);
  if (!is_placed) return wanted;
  return wanted <= place.capacity ? place.capacity : wanted + wanted / 4;
}

/// The place as long as nothing is put into it.
void keep_place(Place& place, std::uint64_t& planned) {
  planned -= place.next_capacity - place.capacity;
  place.next_capacity = place.capacity;
}

bool is_finite(Vec3f x) {
  return std::isfinite(x.x);
}

/// Elements [begin, end) follow on those before where there are some, and where these do.
void append(std::vector<Range>& ranges, std::uint64_t begin, std::uint64_t end) {
  if (begin == end) return;
  if (!ranges.empty() && ranges.back().end == begin) {
    ranges.back().end = end;
  } else {
    ranges.push_back({begin, end});
  }
}
void append(std::vector<Range>& ranges, const Place& place) {
  append(ranges, place.first, std::uint64_t{place.first} + place.capacity);
}

void append(std::vector<Range>& ranges, const Place& place, const UnsentRanges& unsent) {
  for (const Range& range : unsent.within(place.capacity))
    append(ranges, place.first + range.begin, place.first + range.end);
}

std::uint64_t end_of(const Place& place) {
  return std::uint64_t{place.next_first} + place.next_capacity;
}

}  // namespace

BodyId SceneStore::add_body(const BodyDesc& desc) {
  Body body;
  body.id = next_id();
  body.settings = desc.settings;
  body.rank = desc.rank;
  Topology& mesh = body.new_mesh.emplace(build_topology(desc.triangles, desc.vertex_count, desc.segments));
  body.vertices.next_capacity = mesh.vertex_count;
  body.triangles.next_capacity = static_cast<std::uint32_t>(mesh.triangles.size());
  body.edges.next_capacity = static_cast<std::uint32_t>(mesh.edges.size());
  const Sizes sizes = {planned_.vertices + body.vertices.next_capacity,
                       planned_.triangles + body.triangles.next_capacity, planned_.edges + body.edges.next_capacity};
  reserve(sizes);
  bodies_.push_back(std::move(body));
  planned_ = sizes;
  change(bodies_.back());
  has_new_layout_ = true;
  return BodyId{next_id_++};
}

void SceneStore::update_body(Body& body, const BodyDesc& desc) {
  Topology mesh = build_topology(desc.triangles, desc.vertex_count, desc.segments);
  plan(body, mesh.vertex_count, mesh.triangles.size(), mesh.edges.size());
  body.new_mesh = std::move(mesh);
  body.changing.reset();
  replace(body, desc);
  has_new_layout_ = true;
}

/// Sees to it that there is room for so many elements.
void SceneStore::plan(Body& body, std::size_t vertices, std::size_t triangles, std::size_t edges) {
  const std::uint32_t of_vertices = capacity_for(vertices, body.vertices, body.is_placed);
  const std::uint32_t of_triangles = capacity_for(triangles, body.triangles, body.is_placed);
  const std::uint32_t of_edges = capacity_for(edges, body.edges, body.is_placed);
  const Sizes sizes = {planned_.vertices - body.vertices.next_capacity + of_vertices,
                       planned_.triangles - body.triangles.next_capacity + of_triangles,
                       planned_.edges - body.edges.next_capacity + of_edges};
  reserve(sizes);
  planned_ = sizes;
  body.vertices.next_capacity = of_vertices;
  body.triangles.next_capacity = of_triangles;
  body.edges.next_capacity = of_edges;
}

/// All but the mesh.
void SceneStore::replace(Body& body, const BodyDesc& desc) {
  body.settings = desc.settings;
  body.rank = desc.rank;
  body.positions.forget();
  body.vertex_filters.clear();
  body.x_rest.clear();
  change(body);
}

void SceneStore::set_settings(Body& body, const BodySettings& settings) {
  const auto rings = [](const Body& b) { return b.excludes_rings() ? b.settings.neighbour_rings : 1U; };
  const std::uint32_t rings_before = rings(body);
  body.settings = settings;
  change(body);
  if (rings(body) != rings_before) filters_.note_change();
}

void SceneStore::set_vertex_filters(Body& body, Span<const VertexFilter> filters) {
  body.vertex_filters.assign(filters.begin(), filters.end());
  change(body);
  filters_.note_change();
}

void SceneStore::set_rest_positions(Body& body, const Positions& x) {
  body.x_rest = rest_positions(x);
  change(body);
  filters_.note_change();
}

void SceneStore::set_ignored_pairs(BodyPairList pairs) {
  for (const BodyPair& pair : ignored_pairs_.pairs()) {
    Body* const a = find(pair.a);
    Body* const b = find(pair.b);
    if (a == nullptr || b == nullptr || pairs.has(pair.a, pair.b)) continue;
    change(*a);
    change(*b);
  }
  ignored_pairs_ = std::move(pairs);
}

void SceneStore::remove_body(Body& body) {
  body.is_removed = true;
  body.new_mesh.reset();
  body.changing.reset();
  keep_place(body.vertices, planned_.vertices);
  keep_place(body.triangles, planned_.triangles);
  keep_place(body.edges, planned_.edges);
  body.vertex_filters.clear();
  body.x_rest.clear();
  body.positions.forget();
  change(body);
  has_new_layout_ = true;
}

void SceneStore::set_positions(Body& body, const Positions& x_t0, const Positions& x_t1) {
  body.positions.set(x_t0, x_t1);
  body.last_change = ++last_change_;
}

Body* SceneStore::find(BodyId id) {
  const auto found = std::lower_bound(bodies_.begin(), bodies_.end(), id,
                                      [](const Body& body, BodyId wanted) { return body.id < wanted; });
  return found == bodies_.end() || found->id != id || found->is_removed ? nullptr : &*found;
}

template <class F>
void SceneStore::for_each_array(const F& f) {
  const Kind of_vertices = {&Body::vertices, &Sizes::vertices};
  const Kind of_triangles = {&Body::triangles, &Sizes::triangles};
  f(x_t0_, of_vertices);
  f(x_t1_, of_vertices);
  f(vertex_body_, of_vertices);
  f(triangles_, of_triangles);
  f(triangle_edges_, of_triangles);
  f(ownership_, of_triangles);
  f(triangle_body_, of_triangles);
  f(edges_, Kind{&Body::edges, &Sizes::edges});
}

/// Places are 32 bits wide.
void SceneStore::reserve(const Sizes& sizes) {
  if (std::max({sizes.vertices, sizes.triangles, sizes.edges}) >= kMostElements) {
    throw InvalidInput(
        fmt::format("{} triangles, {} vertices and {} edges in one scene are more than 2^31; split it over several.",
                    sizes.triangles, sizes.vertices, sizes.edges));
  }
  for_each_array([&](auto& array, const Kind& kind) { array.reserve(sizes.*kind.size); });
}

void SceneStore::resize(const Sizes& sizes) noexcept {
  for_each_array([&](auto& array, const Kind& kind) { array.resize(sizes.*kind.size); });
}

void SceneStore::settle(const LookedAt& by_scene, const LookedAt& by_next, DevicePositionReader* reader,
                        bool may_foresee, bool lists_neighbours) {
  newly_left_out_.clear();
  lay_out();
  settle_changes();
  if (may_foresee && reader != nullptr && can_foresee(by_scene)) {
    foresee(by_scene, *reader);
  } else {
    read_positions(by_scene, reader);
  }
  leave_out_strays(by_next);
  settle_neighbours();
  if (lists_neighbours) list_neighbours();
  filters_.settle(bodies_, vertex_body_.size(), mesh_revision_, [this](const Body& body) { return mesh_of(body); });
}

/// Gives every body its place, and every new mesh. Allocates nothing.
void SceneStore::lay_out() {
  if (!std::exchange(has_new_layout_, false)) return;
  ++mesh_revision_;
  const bool moves = has_to_move();
  if (moves) sweep_out_removed();
  choose_places(moves);
  resize({std::max<std::uint64_t>(planned_.vertices, vertex_body_.size()),
          std::max<std::uint64_t>(planned_.triangles, triangles_.size()),
          std::max<std::uint64_t>(planned_.edges, edges_.size())});
  if (moves) for_each_array([&](auto& array, const Kind& kind) { move_elements(array, kind.place); });
  for (std::uint32_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    if (body.is_removed) {
      std::fill_n(ownership_.data() + body.triangles.first, body.triangles.count, static_cast<Ownership>(kLeftOut));
      body.unsent.ownership |= std::exchange(body.triangles.count, 0U) > 0;
    } else if (body.is_new()) {
      place_mesh(b);
    } else if (moves) {
      renumber(b);
    }
  }
  resize(planned_);
}

/// Where a body has outgrown its place, and where more is left of bodies that are gone than there is of others.
bool SceneStore::has_to_move() const {
  std::uint64_t gone = 0;
  bool is_outgrown = false;
  for (const Body& body : bodies_) {
    if (body.is_removed) {
      gone += body.triangles.capacity;
      continue;
    }
    const auto outgrows = [](const Place& place) { return place.next_capacity > place.capacity; };
    is_outgrown |= body.is_placed && (outgrows(body.vertices) || outgrows(body.triangles) || outgrows(body.edges));
  }
  return is_outgrown || 2 * gone > planned_.triangles;
}

void SceneStore::sweep_out_removed() {
  for (Body& body : bodies_) {
    if (!body.is_removed) continue;
    drop_neighbours(body);
    planned_.vertices -= body.vertices.next_capacity;
    planned_.triangles -= body.triangles.next_capacity;
    planned_.edges -= body.edges.next_capacity;
  }
  bodies_.erase(std::remove_if(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.is_removed; }),
                bodies_.end());
}

/// One body behind the other: all of them anew, or only those that have no place.
void SceneStore::choose_places(bool moves) {
  Sizes next{0, 0, 0};
  for (Body& body : bodies_) {
    const auto choose = [&](Place& place, std::uint64_t& first) {
      place.next_first = moves || !body.is_placed ? static_cast<std::uint32_t>(first) : place.first;
      first = end_of(place);
    };
    choose(body.vertices, next.vertices);
    choose(body.triangles, next.triangles);
    choose(body.edges, next.edges);
  }
  planned_ = next;
}

/// Moves those that stay what they are. In their order bodies that move down do not run into others that have not moved
/// yet, nor do, in the opposite order, those that move up.
template <class T>
void SceneStore::move_elements(HostArray<T>& elements, Place Body::*kind) {
  const auto move = [&](const Body& body) {
    const Place& place = body.*kind;
    if (place.count == 0) return;
    std::memmove(elements.data() + place.next_first, elements.data() + place.first, place.count * sizeof(T));
  };
  const auto stays_itself = [](const Body& body) { return !body.is_removed && !body.is_new(); };
  for (const Body& body : bodies_) {
    if (stays_itself(body) && (body.*kind).next_first < (body.*kind).first) move(body);
  }
  for (std::size_t b = bodies_.size(); b-- > 0;) {
    const Body& body = bodies_[b];
    if (stays_itself(body) && (body.*kind).next_first > (body.*kind).first) move(body);
  }
}

/// After a body was moved: indices into the scene's arrays.
void SceneStore::renumber(std::uint32_t index) {
  Body& body = bodies_[index];
  const std::uint32_t by_vertex = body.vertices.next_first - body.vertices.first;
  const std::uint32_t by_triangle = body.triangles.next_first - body.triangles.first;
  const std::uint32_t by_edge = body.edges.next_first - body.edges.first;
  for (Place* place : {&body.vertices, &body.triangles, &body.edges}) {
    place->first = place->next_first;
    place->capacity = place->next_capacity;
  }
  for (std::uint32_t t = body.triangles.first; t < body.triangles.first + body.triangles.count; ++t) {
    triangles_.data()[t] = renumbered(triangles_.data()[t], by_vertex);
    triangle_edges_.data()[t] = renumbered(triangle_edges_.data()[t], by_edge);
  }
  for (std::uint32_t e = body.edges.first; e < body.edges.first + body.edges.count; ++e) {
    edges_.data()[e] = renumbered(edges_.data()[e], by_vertex);
  }
  const auto shift = [](std::vector<std::uint64_t>& features, const Range& range, std::uint32_t first,
                        std::uint32_t second) {
    for (std::uint64_t i = range.begin; i < range.end; ++i) {
      if (features[i] == kNoFeatures) continue;
      const std::uint32_t high = static_cast<std::uint32_t>(features[i] >> 32) + first;
      const std::uint32_t low = static_cast<std::uint32_t>(features[i]) + second;
      features[i] = (std::uint64_t{high} << 32) | low;
    }
  };
  shift(vertex_triangle_neighbours_, body.vertex_triangle_neighbours, by_vertex, by_triangle);
  shift(edge_edge_neighbours_, body.edge_edge_neighbours, by_edge, by_edge);
  unsent_vertex_triangle_neighbours_.add_from(0);
  unsent_edge_edge_neighbours_.add_from(0);
  fill_rest(index);
}

/// The triangles behind the body's, and whose all of them are.
void SceneStore::fill_rest(std::uint32_t index) {
  Body& body = bodies_[index];
  const std::uint32_t triangles = body.triangles.first + body.triangles.count;
  const std::uint32_t rest = body.triangles.capacity - body.triangles.count;
  const std::uint32_t v = body.vertices.first;
  std::fill_n(triangles_.data() + triangles, rest, Triangle{{v, v, v}});
  std::fill_n(triangle_edges_.data() + triangles, rest, TriangleEdges{{kNoIndex, kNoIndex, kNoIndex}});
  std::fill_n(ownership_.data() + triangles, rest, static_cast<Ownership>(kLeftOut));
  std::fill_n(triangle_body_.data() + body.triangles.first, body.triangles.capacity, index);
  std::fill_n(vertex_body_.data() + body.vertices.first, body.vertices.capacity, index);
  std::fill_n(edges_.data() + body.edges.first + body.edges.count, body.edges.capacity - body.edges.count,
              Edge{{v, v}});
  body.unsent = {/*mesh=*/true, /*ownership=*/false, /*x_t0=*/true, /*x_t1=*/true, {}, {}};
}

void SceneStore::place_mesh(std::uint32_t index) {
  Body& body = bodies_[index];
  const Topology& mesh = *body.mesh();
  const auto place = [](Place& where, std::size_t count) {
    where = {where.next_first, static_cast<std::uint32_t>(count), where.next_capacity, 0, where.next_capacity};
  };
  place(body.vertices, mesh.vertex_count);
  place(body.triangles, mesh.triangles.size());
  place(body.edges, mesh.edges.size());
  body.segment_count = mesh.segment_count;
  const std::uint32_t v = body.vertices.first;
  const std::uint32_t e = body.edges.first;
  std::transform(mesh.triangles.begin(), mesh.triangles.end(), triangles_.data() + body.triangles.first,
                 [&](const Triangle& triangle) { return renumbered(triangle, v); });
  std::transform(mesh.triangle_edges.begin(), mesh.triangle_edges.end(), triangle_edges_.data() + body.triangles.first,
                 [&](const TriangleEdges& edges) { return renumbered(edges, e); });
  std::transform(mesh.edges.begin(), mesh.edges.end(), edges_.data() + e,
                 [&](const Edge& edge) { return renumbered(edge, v); });
  std::copy(mesh.ownership.begin(), mesh.ownership.end(), ownership_.data() + body.triangles.first);
  std::fill_n(x_t0_.data() + v, body.vertices.capacity, Vec3f{0, 0, 0});
  std::fill_n(x_t1_.data() + v, body.vertices.capacity, Vec3f{0, 0, 0});
  body.new_mesh.reset();
  if (body.changing) {
    body.changing->is_new = false;
    body.changing->mesh.forget_changes();
  }
  body.is_placed = true;
  body.stray_vertices.clear();
  body.named_strays.clear();
  body.left_out_triangles = 0;
  body.is_closed.reset();
  drop_neighbours(body);
  fill_rest(index);
}

MeshView SceneStore::mesh_of(const Body& body) const {
  return {{triangles_.data() + body.triangles.first, body.triangles.count},
          {edges_.data() + body.edges.first, body.edges.count},
          {triangle_edges_.data() + body.triangles.first, body.triangles.count},
          body.vertices.count,
          body.vertices.first,
          body.triangles.first,
          body.edges.first,
          body.segment_count};
}

std::vector<std::uint32_t> SceneStore::strays_of(const Body& body, const LookedAt& looked_at) const {
  std::vector<std::uint32_t> strays;
  const StepSurvey& survey = body.positions.survey();
  const bool t0 = looked_at.needs_t0() && survey.t0.stray_count > 0;
  const bool t1 = looked_at.needs_t1() && survey.t1.stray_count > 0;
  if (!body.positions.are_set() || (!t0 && !t1)) return strays;
  for (std::uint32_t i = 0; i < body.vertices.count; ++i) {
    const std::uint32_t v = body.vertices.first + i;
    if ((t0 && !is_finite(x_t0_.data()[v])) || (t1 && !is_finite(x_t1_.data()[v]))) strays.push_back(i);
  }
  return strays;
}

void SceneStore::leave_out_strays(const LookedAt& looked_at) {
  for (Body& body : bodies_) {
    if (body.is_removed) continue;
    std::vector<std::uint32_t> strays = strays_of(body, looked_at);
    name_strays(body, strays);
    if (strays != body.stray_vertices) leave_out(body, std::move(strays));
  }
}

/// Queries that look at other ends of the step take turns: what one has named another need not name again.
void SceneStore::name_strays(Body& body, const std::vector<std::uint32_t>& strays) {
  std::vector<std::uint32_t>& named = body.named_strays;
  const StepSurvey& survey = body.positions.survey();
  if (survey.t0.stray_count == 0 && survey.t1.stray_count == 0) named.clear();
  if (std::includes(named.begin(), named.end(), strays.begin(), strays.end())) return;
  newly_left_out_.push_back(&body);
  std::vector<std::uint32_t> all;
  std::set_union(named.begin(), named.end(), strays.begin(), strays.end(), std::back_inserter(all));
  named = std::move(all);
}

/// Triangles with a stray vertex own nothing and take no part; their other vertices and edges pass to neighbours.
void SceneStore::leave_out(Body& body, std::vector<std::uint32_t> strays) {
  const MeshView mesh = mesh_of(body);
  std::vector<std::uint8_t> left_out(mesh.triangles.size(), 0);
  std::uint64_t left_out_count = 0;
  for (std::size_t t = 0; t < left_out.size(); ++t) {
    const auto& v = mesh.triangles[t].v;
    left_out[t] = std::any_of(v, v + 3, [&](std::uint32_t i) {
      return std::binary_search(strays.begin(), strays.end(), i - mesh.first_vertex);
    });
    left_out_count += left_out[t];
  }
  const std::vector<Ownership> ownership = assign_ownership(mesh, left_out);
  for (std::size_t t = 0; t < left_out.size(); ++t) {
    ownership_.data()[mesh.first_triangle + t] = left_out[t] != 0 ? static_cast<Ownership>(kLeftOut) : ownership[t];
  }
  body.stray_vertices = std::move(strays);
  body.left_out_triangles = left_out_count;
  body.is_closed.reset();
  body.unsent.ownership = true;
  ++mesh_revision_;
  drop_neighbours(body);
}

void SceneStore::find_closed_surfaces() {
  for (Body& body : bodies_) {
    if (body.is_removed || body.is_closed) continue;
    body.is_closed = body.left_out_triangles == 0 && is_closed_surface(mesh_of(body));
  }
}

void SceneStore::drop_neighbours(Body& body) {
  has_dropped_neighbours_ |= body.lists_neighbours;
  body.has_neighbours = body.lists_neighbours = false;
  if (body.changing) body.changing->has_slots = false;
  body.vertex_triangle_neighbours = body.edge_edge_neighbours = {0, 0};
}

/// Closes the gaps that dropped ones have left.
void SceneStore::forget_dropped_neighbours() {
  if (!has_dropped_neighbours_) return;
  std::vector<Range*> kept;
  const auto close_gaps = [&](std::vector<std::uint64_t>& features, Range Body::*kind, UnsentRanges& unsent) {
    kept.clear();
    for (Body& body : bodies_) {
      if (body.lists_neighbours) kept.push_back(&(body.*kind));
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
  };
  kept.reserve(bodies_.size());
  close_gaps(vertex_triangle_neighbours_, &Body::vertex_triangle_neighbours, unsent_vertex_triangle_neighbours_);
  close_gaps(edge_edge_neighbours_, &Body::edge_edge_neighbours, unsent_edge_edge_neighbours_);
  has_dropped_neighbours_ = false;
}

void SceneStore::list_neighbours() {
  forget_dropped_neighbours();
  std::vector<Body*> unlisted;
  for (Body& body : bodies_) {
    const bool touches_itself = body.settings.self_collision && !body.settings.kinematic;
    if (!body.is_removed && touches_itself && !body.has_neighbours) unlisted.push_back(&body);
  }
  if (unlisted.empty()) return;
  // When one body's list fails, oneTBB cuts short the loops of the others without a word.
  std::vector<NeighbourFeatures> listed(unlisted.size());
  tbb::parallel_for(std::size_t{0}, unlisted.size(),
                    [&](std::size_t i) { listed[i] = listed_neighbours(*unlisted[i]); });
  std::size_t vertex_triangle = vertex_triangle_neighbours_.size();
  std::size_t edge_edge = edge_edge_neighbours_.size();
  for (const NeighbourFeatures& features : listed) {
    vertex_triangle += features.vertex_triangle.size();
    edge_edge += features.edge_edge.size();
  }
  vertex_triangle_neighbours_.reserve(vertex_triangle);
  edge_edge_neighbours_.reserve(edge_edge);
  const auto append_all = [](std::vector<std::uint64_t>& to, const std::vector<std::uint64_t>& features) {
    const std::uint64_t begin = to.size();
    to.insert(to.end(), features.begin(), features.end());
    return Range{begin, to.size()};
  };
  for (std::size_t i = 0; i < unlisted.size(); ++i) {
    Body& body = *unlisted[i];
    body.has_neighbours = true;
    body.lists_neighbours = listed[i].are_listed;
    body.vertex_triangle_neighbours = append_all(vertex_triangle_neighbours_, listed[i].vertex_triangle);
    body.edge_edge_neighbours = append_all(edge_edge_neighbours_, listed[i].edge_edge);
  }
}

SceneArrays SceneStore::arrays() const {
  return {x_t0_.view(),
          x_t1_.view(),
          full_t0_.view(),
          full_t1_.view(),
          triangles_.view(),
          triangle_edges_.view(),
          edges_.view(),
          ownership_.view(),
          triangle_body_.view(),
          vertex_body_.view(),
          vertex_triangle_neighbours_,
          edge_edge_neighbours_,
          mesh_revision_,
          filters_.arrays()};
}

SceneSize SceneStore::size() const {
  SceneSize size;
  for (const Body& body : bodies_) {
    if (body.is_removed) continue;
    ++size.bodies;
    size.triangles += body.triangle_count();
    size.vertices += body.vertex_count();
    size.edges += body.edge_count();
    size.left_out_triangles += body.left_out_triangles;
    size.bodies_without_positions += body.positions.are_set() ? 0 : 1;
  }
  return size;
}

void SceneStore::append_full_positions(SceneChanges& changes) const {
  for (const Body& body : bodies_) {
    const auto append_end = [&](std::vector<Range>& ranges, std::vector<DevicePositions>& on_device,
                                const Positions& end) {
      if (body.positions.are_on_device()) {
        on_device.push_back({given(end), body.vertices.first, body.vertices.count});
      } else {
        append(ranges, body.vertices);
      }
    };
    if (needs_t0_) append_end(changes.full_t0, changes.device_full_t0, body.positions.given_t0());
    append_end(changes.full_t1, changes.device_full_t1, body.positions.given_t1());
  }
}

SceneChanges SceneStore::changes(bool all, bool with_t0) const {
  SceneChanges changes;
  for (const Body& body : bodies_) {
    if (all || body.unsent.mesh) {
      append(changes.vertices, body.vertices);
      append(changes.triangles, body.triangles);
      append(changes.edges, body.edges);
    } else {
      append(changes.triangles, body.triangles, body.unsent.triangles);
      append(changes.edges, body.edges, body.unsent.edges);
      if (body.unsent.ownership) append(changes.ownership, body.triangles);
    }
    const auto append_end = [&](std::vector<Range>& ranges, std::vector<DevicePositions>& on_device,
                                const Positions& end) {
      if (body.positions.are_on_device()) {
        on_device.push_back({given(end), body.vertices.first, body.vertices.count});
      } else {
        append(ranges, body.vertices);
      }
    };
    if (with_t0 && (all || body.unsent.x_t0)) append_end(changes.x_t0, changes.device_x_t0, body.positions.given_t0());
    if (all || body.unsent.x_t1) append_end(changes.x_t1, changes.device_x_t1, body.positions.given_t1());
  }
  changes.origin = origin_;
  changes.verdict = verdict_;
  const auto unsent = [&](const UnsentRanges& ranges, const std::vector<std::uint64_t>& features) {
    return all ? std::vector<Range>{{0, features.size()}} : ranges.within(features.size());
  };
  changes.vertex_triangle_neighbours = unsent(unsent_vertex_triangle_neighbours_, vertex_triangle_neighbours_);
  changes.edge_edge_neighbours = unsent(unsent_edge_edge_neighbours_, edge_edge_neighbours_);
  changes.filters = all || filters_.are_unsent();
  return changes;
}

void SceneStore::forget_changes(bool with_t0) {
  for (Body& body : bodies_) {
    body.unsent.mesh = body.unsent.ownership = body.unsent.x_t1 = false;
    body.unsent.x_t0 &= !with_t0;
    body.unsent.triangles.clear(body.triangles.capacity);
    body.unsent.edges.clear(body.edges.capacity);
  }
  unsent_vertex_triangle_neighbours_.clear(vertex_triangle_neighbours_.size());
  unsent_edge_edge_neighbours_.clear(edge_edge_neighbours_.size());
  filters_.forget_changes();
}

}  // namespace softcd
