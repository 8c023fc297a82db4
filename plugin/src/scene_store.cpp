#include "scene_store.hpp"

#include <utility>

namespace softcd {

BodyId SceneStore::add_body(const BodyDesc& desc) {
  Body& body = layout_.add_body(desc);
  note_change(body);
  return body.id;
}

void SceneStore::update_body(Body& body, const BodyDesc& desc) {
  layout_.set_mesh(body, desc);
  replace(body, desc);
}

void SceneStore::update_body(Body& body, const BodyDesc& desc, Span<const std::uint32_t> changed) {
  layout_.change_mesh(body, desc, changed);
  replace(body, desc);
}

/// Replaces all but the mesh.
void SceneStore::replace(Body& body, const BodyDesc& desc) {
  body.settings = desc.settings;
  body.rank = desc.rank;
  body.positions.forget();
  body.vertex_filters.clear();
  body.x_rest.clear();
  note_change(body);
}

/// Records a change of anything but positions.
void SceneStore::note_change(Body& body) {
  body.last_change = ++last_change_;
  positions_.forget_prediction();
}

void SceneStore::set_settings(Body& body, const BodySettings& settings) {
  const auto rings = [](const Body& b) { return b.excludes_rings() ? b.settings.neighbour_rings : 1U; };
  const std::uint32_t rings_before = rings(body);
  body.settings = settings;
  note_change(body);
  if (rings(body) != rings_before) filters_.note_change();
}

void SceneStore::remove_body(Body& body) {
  layout_.remove_body(body);
  body.vertex_filters.clear();
  body.x_rest.clear();
  body.positions.forget();
  note_change(body);
}

void SceneStore::set_vertex_filters(Body& body, Span<const VertexFilter> filters) {
  body.vertex_filters.assign(filters.begin(), filters.end());
  note_change(body);
  filters_.note_change();
}

void SceneStore::set_rest_positions(Body& body, const Positions& x) {
  body.x_rest = rest_positions(x);
  note_change(body);
  filters_.note_change();
}

void SceneStore::set_positions(Body& body, const Positions& x_t0, const Positions& x_t1) {
  body.positions.set(x_t0, x_t1);
  body.last_change = ++last_change_;
}

void SceneStore::set_ignored_pairs(BodyPairList pairs) {
  for (const BodyPair& pair : ignored_pairs_.pairs()) {
    Body* const a = layout_.find(pair.a);
    Body* const b = layout_.find(pair.b);
    if (a == nullptr || b == nullptr || pairs.has(pair.a, pair.b)) continue;
    note_change(*a);
    note_change(*b);
  }
  ignored_pairs_ = std::move(pairs);
}

void SceneStore::apply_changes(const NeededPositions& by_scene, const NeededPositions& by_next,
                               DevicePositionReader* reader, bool may_predict, bool lists_neighbours) {
  layout_.apply_changes();
  positions_.read(by_scene, reader, may_predict);
  leave_out_strays(by_next);
  neighbours_.update(layout_.bodies());
  if (lists_neighbours) neighbours_.list_missing(layout_);
  filters_.update(layout_);
}

void SceneStore::leave_out_strays(const NeededPositions& needs) {
  for (Body& body : layout_.bodies()) {
    if (body.is_removed) continue;
    std::vector<std::uint32_t> strays = positions_.find_strays(body, needs);
    if (strays != body.stray_vertices) layout_.leave_out(body, std::move(strays));
  }
}

SceneArrays SceneStore::arrays() const {
  SceneArrays arrays = layout_.arrays();
  arrays.full_t0 = positions_.full_t0();
  arrays.full_t1 = positions_.full_t1();
  arrays.vertex_triangle_neighbours = neighbours_.vertex_triangle();
  arrays.edge_edge_neighbours = neighbours_.edge_edge();
  arrays.stars = neighbours_.stars();
  arrays.filters = filters_.arrays();
  return arrays;
}

SceneChanges SceneStore::changes(bool all, bool with_t0) const {
  SceneChanges changes;
  layout_.append_changes(changes, all);
  positions_.append_changes(changes, all, with_t0);
  neighbours_.append_changes(changes, all);
  changes.filters = all || filters_.are_unsent();
  return changes;
}

void SceneStore::forget_changes(bool with_t0) {
  layout_.forget_changes();
  positions_.forget_changes(with_t0);
  neighbours_.forget_changes();
  filters_.forget_changes();
}

}  // namespace softcd
