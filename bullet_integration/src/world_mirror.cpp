#include "world_mirror.hpp"

#include <tbb/parallel_for.h>

#include <utility>

#include "query_options.hpp"
#include "world_kind.hpp"

namespace softcd::bullet {
namespace {

bool is_same(const BodySettings& a, const BodySettings& b) {
  return a.margin == b.margin && a.self_collision == b.self_collision && a.kinematic == b.kinematic &&
         a.features.edge_edge == b.features.edge_edge;
}

BodyDesc desc_of(const BodyMesh& mesh, const BodySettings& settings) {
  return {mesh.triangles, mesh.node_count, settings, /*rank=*/-1, mesh.segments};
}

}  // namespace

WorldMirror::WorldMirror(const WorldKind& kind, const Settings& settings)
    : kind_(kind), settings_(settings), scene_(scene_options(settings), settings.log) {}

void WorldMirror::set_settings(const Settings& settings) {
  if (scene_options(settings) != scene_options(settings_)) scene_.set_options(scene_options(settings));
  scene_.set_log(settings.log);
  settings_ = settings;
}

void WorldMirror::begin_step(Span<btSoftBody* const> bodies) noexcept {
  const bool keeps_some = !std::exchange(forgets_all_, false);
  for (btSoftBody* body : bodies) {
    const auto known = members_.find(body);
    if (known != members_.end()) known->second.is_in_world = keeps_some && known->second.last_step == step_;
  }
  remove_unmarked();
  ++step_;
}

void WorldMirror::resume_step(Span<btSoftBody* const> bodies) noexcept {
  for (btSoftBody* body : bodies) {
    const auto known = members_.find(body);
    if (known != members_.end()) known->second.is_in_world = true;
  }
  remove_unmarked();
  for (auto& [body, member] : members_) member.last_compared = 0;
}

void WorldMirror::remove_unmarked() noexcept {
  for (auto entry = members_.begin(); entry != members_.end();) {
    if (std::exchange(entry->second.is_in_world, false)) {
      ++entry;
      continue;
    }
    scene_.remove_body(entry->second.id);
    members_by_id_.erase(entry->second.id.value);
    entry = members_.erase(entry);
  }
}

void WorldMirror::compare(Span<btSoftBody* const> bodies) {
  tbb::parallel_for(std::size_t{0}, bodies.size(), [&](std::size_t i) {
    const auto known = members_.find(bodies[i]);
    if (known != members_.end()) compare(known->second);
  });
}

void WorldMirror::compare(Member& member) const {
  if (member.last_compared == step_) return;
  member.topology_changed = !is_up_to_date(member.mesh, *member.body);
  member.last_compared = step_;
}

WorldMirror::Member& WorldMirror::require(btSoftBody& body, bool needs_way) {
  const auto known = members_.find(&body);
  if (known == members_.end()) {
    Member& added = add(body, read_settings(kind_, body, settings_));
    set_positions(added, needs_way);
    return added;
  }
  Member& member = known->second;
  if (member.last_step != step_ || member.last_compared != step_) {
    update(member, read_settings(kind_, body, settings_));
    set_positions(member, needs_way);
    member.last_step = step_;
  } else if (needs_way && !member.has_way) {
    set_positions(member, needs_way);
  }
  return member;
}

bool WorldMirror::has(const btSoftBody& body) const {
  const auto known = members_.find(&body);
  return known != members_.end() && known->second.last_step == step_;
}

WorldMirror::Member& WorldMirror::add(btSoftBody& body, const BodySettings& settings) {
  Member& member = members_[&body];
  try {
    member.body = &body;
    member.mesh = read_mesh(body);
    member.settings = settings;
    member.topology_changed = true;
    member.last_compared = step_;
    member.id = scene_.add_body(desc_of(member.mesh, settings));
    members_by_id_[member.id.value] = &member;
    member.last_step = step_;
    return member;
  } catch (...) {
    if (scene_.has_body(member.id)) scene_.remove_body(member.id);
    members_.erase(&body);
    throw;
  }
}

void WorldMirror::update(Member& member, const BodySettings& settings) {
  compare(member);
  if (member.topology_changed) {
    BodyMesh mesh = read_mesh(*member.body);
    scene_.update_body(member.id, desc_of(mesh, settings));
    member.mesh = std::move(mesh);
  } else if (!is_same(member.settings, settings)) {
    scene_.set_settings(member.id, settings);
  }
  member.settings = settings;
}

void WorldMirror::set_positions(Member& member, bool needs_way) {
  const btSoftBody& body = *member.body;
  const NodePosition start = start_of(kind_, body);
  const NodePosition end = body.isActive() ? kind_.end : start;
  if (needs_way && start != end) {
    scene_.set_positions(member.id, positions_of(body, start), positions_of(body, end));
  } else {
    scene_.set_positions(member.id, positions_of(body, start));
  }
  member.has_way = needs_way;
}

void WorldMirror::update_way(Member& member) {
  const btSoftBody& body = *member.body;
  scene_.set_positions(member.id, positions_of(body, kind_.start), positions_of(body, kind_.end));
  member.has_way = true;
}

const WorldMirror::Member* WorldMirror::find(BodyId id) const {
  const auto found = members_by_id_.find(id.value);
  return found == members_by_id_.end() ? nullptr : found->second;
}

}  // namespace softcd::bullet
