#include "scene_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>

#include "mesh_numbering.hpp"
#include "softcd/mesh/closed_surface.hpp"
#include "softcd/mesh/patches.hpp"
#include "validation.hpp"

namespace softcd {
namespace {

/// Returns the capacity for `count` elements: a quarter more than that if the body has outgrown its place.
std::uint32_t capacity_for(std::size_t count, const Place& place, bool is_placed) {
  const auto wanted = static_cast<std::uint32_t>(count);
  if (!is_placed) return wanted;
  return wanted <= place.capacity ? place.capacity : wanted + wanted / 4;
}

/// Returns a multiple of kPatchSize.
std::uint64_t whole_patches(std::uint64_t triangles) {
  return (triangles + kPatchSize - 1) / kPatchSize * kPatchSize;
}

}  // namespace

Body& SceneLayout::add_body(const BodyDesc& desc) {
  Body body;
  body.id = next_id();
  body.settings = desc.settings;
  body.rank = desc.rank;
  const Topology& mesh = body.new_mesh.emplace(build_topology(desc.triangles, desc.vertex_count, desc.segments));
  if (bodies_.size() == bodies_.capacity()) bodies_.reserve(2 * bodies_.size() + 1);
  plan(body, {mesh.vertex_count, mesh.triangles.size(), mesh.edges.size()}, mesh.patches);
  bodies_.push_back(std::move(body));
  ++next_id_;
  has_new_layout_ = true;
  return bodies_.back();
}

void SceneLayout::set_mesh(Body& body, const BodyDesc& desc) {
  Topology mesh = build_topology(desc.triangles, desc.vertex_count, desc.segments);
  plan(body, {mesh.vertex_count, mesh.triangles.size(), mesh.edges.size()}, mesh.patches);
  body.new_mesh = std::move(mesh);
  body.changing.reset();
  has_new_layout_ = true;
}

/// Returns the body's mesh, with ownership as if no triangle were left out.
Topology SceneLayout::copy_of_mesh(const Body& body) const {
  const MeshView mesh = mesh_of(body);
  Topology copy;
  copy.vertex_count = mesh.vertex_count;
  copy.triangles.reserve(mesh.triangles.size());
  copy.triangle_edges.reserve(mesh.triangles.size());
  copy.edges.reserve(mesh.edges.size());
  for (const Triangle& t : mesh.triangles) copy.triangles.push_back(renumbered(t, 0U - mesh.first_vertex));
  for (const TriangleEdges& e : mesh.triangle_edges) copy.triangle_edges.push_back(renumbered(e, 0U - mesh.first_edge));
  for (const Edge& edge : mesh.edges) copy.edges.push_back(renumbered(edge, 0U - mesh.first_vertex));
  copy.ownership = assign_ownership(view_of(copy), std::vector<std::uint8_t>(copy.triangles.size(), 0));
  copy.patches.triangle_count = body.triangles.capacity;
  const std::uint32_t* const patches = patch_triangles_.data() + body.patches.first;
  std::transform(patches, patches + body.patches.capacity, std::back_inserter(copy.patches.triangles),
                 [&](std::uint32_t t) { return t == kNoIndex ? kNoIndex : t - body.triangles.first; });
  return copy;
}

const ChangingMesh& SceneLayout::changing_mesh(Body& body) {
  if (!body.changing) {
    body.changing = std::make_unique<ChangingBody>(body.new_mesh ? *body.new_mesh : copy_of_mesh(body));
    body.changing->is_new = body.new_mesh.has_value();
    body.new_mesh.reset();
  }
  return body.changing->mesh;
}

void SceneLayout::change_mesh(Body& body, const BodyDesc& desc, Span<const std::uint32_t> changed) {
  const Topology& mesh = changing_mesh(body).topology();
  const std::size_t added = desc.triangles.size() - std::min(mesh.triangles.size(), desc.triangles.size());
  plan(body, {desc.vertex_count, desc.triangles.size(), mesh.edges.size() + 3 * (changed.size() + added)},
       mesh.patches);
  body.changing->mesh.change(desc.triangles, desc.vertex_count, changed);
  body.changing->is_new |= body.is_outgrown() || body.left_out_triangles > 0;
  has_new_layout_ |= body.changing->is_new;
}

/// Reserves capacity for so many elements of the body, and for patches of all triangles that it has capacity for.
void SceneLayout::plan(Body& body, const MeshSize& size, const PatchOrder& patches) {
  const std::uint32_t triangles = capacity_for(size.triangles, body.triangles, body.is_placed);
  const std::uint64_t unordered = triangles - std::min(triangles, patches.triangle_count);
  const Sizes capacities = {
      capacity_for(size.vertices, body.vertices, body.is_placed), triangles,
      capacity_for(size.edges, body.edges, body.is_placed),
      whole_patches(capacity_for(patches.triangles.size() + whole_patches(unordered), body.patches, body.is_placed))};
  Sizes sizes = planned_;
  for (std::size_t k = 0; k < kPlaces.size(); ++k) sizes[k] += capacities[k] - (body.*kPlaces[k]).next_capacity;
  reserve(sizes);
  planned_ = sizes;
  for (std::size_t k = 0; k < kPlaces.size(); ++k) {
    (body.*kPlaces[k]).next_capacity = static_cast<std::uint32_t>(capacities[k]);
  }
}

void SceneLayout::remove_body(Body& body) {
  body.is_removed = true;
  body.new_mesh.reset();
  body.changing.reset();
  body.neighbours.slots.reset();
  for (std::size_t k = 0; k < kPlaces.size(); ++k) {
    Place& place = body.*kPlaces[k];
    planned_[k] -= place.next_capacity - place.capacity;
    place.next_capacity = place.capacity;
  }
  has_new_layout_ = true;
}

Body* SceneLayout::find(BodyId id) {
  const auto found = std::lower_bound(bodies_.begin(), bodies_.end(), id,
                                      [](const Body& body, BodyId wanted) { return body.id < wanted; });
  return found == bodies_.end() || found->id != id || found->is_removed ? nullptr : &*found;
}

template <class F>
void SceneLayout::for_each_array(const F& f) {
  f(x_t0_, kVertices);
  f(x_t1_, kVertices);
  f(vertex_body_, kVertices);
  f(triangles_, kTriangles);
  f(triangle_edges_, kTriangles);
  f(ownership_, kTriangles);
  f(patch_triangles_, kPatches);
  f(triangle_body_, kTriangles);
  f(edges_, kEdges);
}

/// Reserves the arrays. Places are 32 bits wide.
void SceneLayout::reserve(const Sizes& sizes) {
  if (*std::max_element(sizes.begin(), sizes.end()) >= kMostElements) {
    throw InvalidInput(
        fmt::format("{} triangles, {} vertices and {} edges in one scene are more than 2^31; split it over several.",
                    sizes[kTriangles], sizes[kVertices], sizes[kEdges]));
  }
  for_each_array([&](auto& array, std::size_t kind) { array.reserve(sizes[kind]); });
}

void SceneLayout::share_positions() {
  x_t0_.share();
  x_t1_.share();
}

void SceneLayout::apply_changes() {
  lay_out();
  for (Body& body : bodies_) {
    if (body.changing && body.changing->mesh.has_changes()) write_changes(body);
  }
}

/// Gives every body its place, and writes every new mesh.
void SceneLayout::lay_out() noexcept {
  if (!std::exchange(has_new_layout_, false)) return;
  ++revision_;
  const bool moves = has_to_move();
  if (moves) std::erase_if(bodies_, [](const Body& body) { return body.is_removed; });
  choose_places(moves);
  for_each_array([&](auto& array, std::size_t kind) {
    array.resize(std::max<std::size_t>(planned_[kind], array.size()));
    if (moves) move_elements(array, kind);
  });
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
  for_each_array([&](auto& array, std::size_t kind) { array.resize(planned_[kind]); });
}

bool SceneLayout::has_to_move() const {
  std::uint64_t gone = 0;
  bool is_outgrown = false;
  for (const Body& body : bodies_) {
    if (body.is_removed) {
      gone += body.triangles.capacity;
      continue;
    }
    is_outgrown |= body.is_placed && body.is_outgrown();
  }
  return is_outgrown || 2 * gone > planned_[kTriangles];
}

/// Places one body behind the other: all of them, or only those that have no place.
void SceneLayout::choose_places(bool moves) {
  planned_ = {};
  for (Body& body : bodies_) {
    for (std::size_t k = 0; k < kPlaces.size(); ++k) {
      Place& place = body.*kPlaces[k];
      place.next_first = moves || !body.is_placed ? static_cast<std::uint32_t>(planned_[k]) : place.first;
      planned_[k] = std::uint64_t{place.next_first} + place.next_capacity;
    }
  }
}

/// Moves the bodies whose mesh stays. Bodies that move down go first, in their order; then those that move up, in the
/// opposite order. So no body overwrites one that has yet to move.
template <class T>
void SceneLayout::move_elements(HostArray<T>& elements, std::size_t kind) {
  const auto move = [&](const Place& place) {
    if (place.capacity == 0) return;
    std::memmove(elements.data() + place.next_first, elements.data() + place.first, place.capacity * sizeof(T));
  };
  const auto stays_itself = [](const Body& body) { return !body.is_removed && !body.is_new(); };
  for (const Body& body : bodies_) {
    const Place& place = body.*kPlaces[kind];
    if (stays_itself(body) && place.next_first < place.first) move(place);
  }
  for (std::size_t b = bodies_.size(); b-- > 0;) {
    const Place& place = bodies_[b].*kPlaces[kind];
    if (stays_itself(bodies_[b]) && place.next_first > place.first) move(place);
  }
}

/// Sets the place of a body that was moved, and renumbers its mesh accordingly.
void SceneLayout::renumber(std::uint32_t index) {
  Body& body = bodies_[index];
  const std::uint32_t by_vertex = body.vertices.next_first - body.vertices.first;
  const std::uint32_t by_edge = body.edges.next_first - body.edges.first;
  const std::uint32_t by_triangle = body.triangles.next_first - body.triangles.first;
  for (const auto place : kPlaces) {
    (body.*place).first = (body.*place).next_first;
    (body.*place).capacity = (body.*place).next_capacity;
  }
  for (std::uint32_t t = body.triangles.first; t < body.triangles.first + body.triangles.count; ++t) {
    triangles_.data()[t] = renumbered(triangles_.data()[t], by_vertex);
    triangle_edges_.data()[t] = renumbered(triangle_edges_.data()[t], by_edge);
  }
  for (std::uint32_t i = body.patches.first; i < body.patches.first + body.patches.capacity; ++i) {
    std::uint32_t& t = patch_triangles_.data()[i];
    if (t != kNoIndex) t += by_triangle;
  }
  for (std::uint32_t e = body.edges.first; e < body.edges.first + body.edges.count; ++e) {
    edges_.data()[e] = renumbered(edges_.data()[e], by_vertex);
  }
  fill_rest(index);
}

/// Fills the unused elements behind the body's triangles and edges, and the body numbers of its whole place.
void SceneLayout::fill_rest(std::uint32_t index) {
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

void SceneLayout::place_mesh(std::uint32_t index) {
  Body& body = bodies_[index];
  const Topology& mesh = *body.mesh();
  const auto place = [](Place& where, std::size_t count) {
    where = {where.next_first, static_cast<std::uint32_t>(count), where.next_capacity, 0, where.next_capacity};
  };
  place(body.vertices, mesh.vertex_count);
  place(body.triangles, mesh.triangles.size());
  place(body.edges, mesh.edges.size());
  place(body.patches, body.patches.next_capacity);
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
  place_patches(body, mesh.patches);
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
  body.neighbours = {};
  fill_rest(index);
}

/// Fills the body's patches, in which every triangle that it has capacity for is once. The mesh may have changed since
/// `order` was made: triangles that are not in it are put together in the order of their indices.
void SceneLayout::place_patches(const Body& body, const PatchOrder& order) {
  const auto [first, count, capacity, next_first, next_capacity] = body.triangles;
  std::uint32_t* next = patch_triangles_.data() + body.patches.first;
  std::uint32_t* const end = next + body.patches.capacity;
  std::fill(next, end, kNoIndex);
  for (std::size_t patch = 0; patch < order.triangles.size(); patch += kPatchSize) {
    const auto* const triangles = order.triangles.data() + patch;
    std::uint32_t* place = next;
    for (const std::uint32_t* t = triangles; t < triangles + kPatchSize; ++t) {
      if (*t < capacity) *place++ = first + *t;
    }
    if (place > next) next += kPatchSize;
  }
  for (std::uint32_t t = order.triangle_count; t < capacity; ++t) *next++ = first + t;
}

PositionArrays SceneLayout::positions_of(const Body& body) {
  return {x_t0_.data() + body.vertices.first, x_t1_.data() + body.vertices.first};
}

MeshView SceneLayout::mesh_of(const Body& body) const {
  return {{triangles_.data() + body.triangles.first, body.triangles.count},
          {edges_.data() + body.edges.first, body.edges.count},
          {triangle_edges_.data() + body.triangles.first, body.triangles.count},
          body.vertices.count,
          body.vertices.first,
          body.triangles.first,
          body.edges.first,
          body.segment_count};
}

/// Writes the changes of a ChangingMesh. After std::bad_alloc the next call writes all of them again.
void SceneLayout::write_changes(Body& body) {
  ++revision_;
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
  // Features that were listed before the first change have no slots, and must be listed again.
  const bool are_listed = body.neighbours.are_listed;
  if (are_listed != changing.lists_neighbours() || (are_listed && !body.neighbours.slots)) body.neighbours = {};
  changing.forget_changes();
}

void SceneLayout::leave_out(Body& body, std::vector<std::uint32_t> strays) {
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
  body.neighbours = {};
  ++revision_;
}

void SceneLayout::find_closed_surfaces() {
  for (Body& body : bodies_) {
    if (body.is_removed || body.is_closed) continue;
    body.is_closed = body.left_out_triangles == 0 && is_closed_surface(mesh_of(body));
  }
}

SceneArrays SceneLayout::arrays() const {
  SceneArrays arrays{};
  arrays.x_t0 = x_t0_.view();
  arrays.x_t1 = x_t1_.view();
  arrays.triangles = triangles_.view();
  arrays.triangle_edges = triangle_edges_.view();
  arrays.edges = edges_.view();
  arrays.ownership = ownership_.view();
  arrays.patch_triangles = patch_triangles_.view();
  arrays.triangle_body = triangle_body_.view();
  arrays.vertex_body = vertex_body_.view();
  arrays.revision = revision_;
  return arrays;
}

SceneSize SceneLayout::size() const {
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

void SceneLayout::append_changes(SceneChanges& changes, bool all) const {
  const auto append_unsent = [](std::vector<Range>& ranges, const Place& place, const UnsentRanges& unsent) {
    for (const Range& range : unsent.within(place.capacity)) {
      append(ranges, {place.first + range.begin, place.first + range.end});
    }
  };
  for (const Body& body : bodies_) {
    if (all || body.unsent.mesh) {
      append(changes.vertices, body.vertices.range());
      append(changes.triangles, body.triangles.range());
      append(changes.edges, body.edges.range());
      append(changes.patches, body.patches.range());
    } else {
      append_unsent(changes.triangles, body.triangles, body.unsent.triangles);
      append_unsent(changes.edges, body.edges, body.unsent.edges);
      if (body.unsent.ownership) append(changes.ownership, body.triangles.range());
    }
  }
}

void SceneLayout::forget_changes() {
  for (Body& body : bodies_) {
    body.unsent.mesh = body.unsent.ownership = false;
    body.unsent.triangles.clear(body.triangles.capacity);
    body.unsent.edges.clear(body.edges.capacity);
  }
}

}  // namespace softcd
