#include "bodies/world_mirror.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "bodies/query_options.hpp"
#include "bodies/vectors.hpp"
#include "softcd/core/parallel.hpp"
#include "softcd/fields/options.hpp"

namespace softcd::bullet {
namespace {

/// If more than one in this many triangles has changed, updating all of them costs less.
constexpr std::size_t kOneChangedIn = 8;

/// Throws the errors that a scene would throw, before the scene has the body.
void validate(const btSoftBody& body, const BodyFilters& filters) {
  const auto node_count = static_cast<std::size_t>(body.m_nodes.size());
  if (!filters.nodes.empty() && filters.nodes.size() != node_count) {
    throw InvalidInput("softcd::bullet::BodyFilters: there are " + std::to_string(filters.nodes.size()) +
                       " filters of nodes, but the body has " + std::to_string(node_count) + " nodes");
  }
  BodySettings settings;
  settings.neighbour_rings = filters.neighbour_rings;
  settings.rest_distance = filters.rest_distance;
  const std::string problem = problem_of(settings);
  if (!problem.empty()) throw InvalidInput("softcd::bullet::BodyFilters: " + problem);
}

/// Returns no positions unless the filters need them.
std::vector<Vec3d> rest_positions(const btSoftBody& body, const BodyFilters& filters) {
  std::vector<Vec3d> x_rest;
  if (!(filters.rest_distance > 0.0F)) return x_rest;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& x = body.m_nodes[i].m_x;
    x_rest.push_back(to_doubles(x));
    if (std::isfinite(x.x()) && std::isfinite(x.y()) && std::isfinite(x.z())) continue;
    throw InvalidInput("softcd::bullet::BodyFilters: node " + std::to_string(i) +
                       " has a position that is not finite, but rest_distance is measured from it");
  }
  return x_rest;
}

BodyDesc desc_of(const BodyMesh& mesh, const BodySettings& settings) {
  return {mesh.triangles, mesh.node_count, settings, /*rank=*/-1, mesh.segments};
}

}  // namespace

WorldMirror::WorldMirror(const NodeEnds& ends, const Settings& settings)
    : ends_(ends), settings_(settings), scene_(scene_options(settings), settings.log), rigid_(ends, scene_) {}

void WorldMirror::follow_settings() {
  if (scene_options(settings_) != scene_.options()) scene_.set_options(scene_options(settings_));
  scene_.set_log(settings_.log);
}

void WorldMirror::set_filters(const btSoftBody& body, BodyFilters filters) {
  validate(body, filters);
  KeptFilters kept = {std::move(filters), {}, last_filters_ + 1, false};
  kept.x_rest = rest_positions(body, kept.filters);
  filters_.insert_or_assign(BodyKey(body), std::move(kept));
  ++last_filters_;
}

/// Removes the filters of all other bodies.
void WorldMirror::keep_filters_of(Span<btSoftBody* const> bodies) noexcept {
  if (filters_.empty()) return;
  for (const btSoftBody* body : bodies) {
    const auto known = filters_.find(BodyKey(*body));
    if (known != filters_.end()) known->second.is_in_world = true;
  }
  for (auto entry = filters_.begin(); entry != filters_.end();) {
    entry = std::exchange(entry->second.is_in_world, false) ? std::next(entry) : filters_.erase(entry);
  }
}

void WorldMirror::drop_unfit_filters(const btSoftBody& body) {
  const auto known = filters_.find(BodyKey(body));
  if (known == filters_.end()) return;
  const auto fits = [&](std::size_t count) {
    return count == 0 || count == static_cast<std::size_t>(body.m_nodes.size());
  };
  if (fits(known->second.filters.nodes.size()) && fits(known->second.x_rest.size())) return;
  filters_.erase(known);
  if (!settings_.log) return;
  settings_.log(LogLevel::warning,
                "the filters of a soft body were removed, because its number of nodes has changed since they were set");
}

BodySettings WorldMirror::settings_of(const btSoftBody& body) const {
  BodySettings settings = read_settings(ends_, body, settings_);
  const auto known = filters_.find(BodyKey(body));
  if (known == filters_.end()) return settings;
  settings.neighbour_rings = known->second.filters.neighbour_rings;
  settings.rest_distance = known->second.filters.rest_distance;
  return settings;
}

/// Passes the body's filters to the scene. The scene has none where `member.filters` is 0.
void WorldMirror::pass_on_filters(Member& member) {
  const auto known = filters_.find(BodyKey(*member.body));
  const std::uint64_t number = known == filters_.end() ? 0 : known->second.number;
  if (member.filters == number) return;
  static const KeptFilters none;
  const KeptFilters& kept = known == filters_.end() ? none : known->second;
  scene_.set_vertex_filters(member.id, kept.filters.nodes);
  scene_.set_rest_positions(member.id, kept.x_rest);
  member.filters = number;
}

/// Removes the members that are neither among these bodies nor proxies, and those for which is_kept(member) is false.
template <class Predicate>
void WorldMirror::keep(Span<btSoftBody* const> bodies, Predicate is_kept) noexcept {
  for (const Span<btSoftBody* const> present : {bodies, rigid_.proxies.bodies()}) {
    for (btSoftBody* body : present) {
      const auto known = members_.find(BodyKey(*body));
      if (known != members_.end()) known->second.is_in_world = is_kept(known->second);
    }
  }
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

void WorldMirror::begin_step(Span<btSoftBody* const> bodies) noexcept {
  keep_filters_of(bodies);
  const bool keeps_some = !std::exchange(forgets_all_, false);
  keep(bodies, [&](const Member& member) { return keeps_some && member.last_step == step_; });
  for (auto& [body, member] : members_) member.topology_changed = false;
  ++step_;
}

void WorldMirror::resume_step(Span<btSoftBody* const> bodies) noexcept {
  keep(bodies, [](const Member& /*member*/) { return true; });
  for (auto& [body, member] : members_) member.last_compared = 0;
}

void WorldMirror::compare(Span<btSoftBody* const> bodies) {
  if (members_.empty()) return;
  parallel::for_each(bodies.size(), [&](std::size_t i) {
    const auto known = members_.find(BodyKey(*bodies[i]));
    if (known != members_.end()) compare(known->second);
  });
}

void WorldMirror::compare(Member& member) const {
  if (member.last_compared == step_) return;
  member.is_outdated = !is_up_to_date(member.mesh, *member.body);
  member.topology_changed |= member.is_outdated;
  member.last_compared = step_;
}

WorldMirror::Member& WorldMirror::require(btSoftBody& body, bool needs_way) {
  drop_unfit_filters(body);
  const auto known = members_.find(BodyKey(body));
  if (known == members_.end()) {
    Member& added = add(body, settings_of(body));
    pass_on_filters(added);
    set_positions(added, needs_way);
    return added;
  }
  Member& member = known->second;
  if (member.last_step != step_ || member.last_compared != step_) {
    update(member, settings_of(body));
    pass_on_filters(member);
    set_positions(member, needs_way);
    member.last_step = step_;
  } else if (needs_way && !member.has_way) {
    set_positions(member, needs_way);
  }
  return member;
}

bool WorldMirror::has(const btSoftBody& body) const {
  const auto known = members_.find(BodyKey(body));
  return known != members_.end() && known->second.last_step == step_;
}

WorldMirror::Member& WorldMirror::add(btSoftBody& body, const BodySettings& settings) {
  Member& member = members_[BodyKey(body)];
  try {
    member.body = &body;
    member.mesh = read_mesh(body);
    member.settings = settings;
    member.topology_changed = true;
    member.last_compared = step_;
    member.id = scene_.add_body(desc_of(member.mesh, settings));
    add_faces_of_nodes(member.mesh);
    member.mesh.outward = outward_side(member.mesh, body);
    members_by_id_[member.id.value] = &member;
    member.last_step = step_;
    return member;
  } catch (...) {
    if (scene_.has_body(member.id)) scene_.remove_body(member.id);
    members_.erase(BodyKey(body));
    throw;
  }
}

void WorldMirror::update(Member& member, const BodySettings& settings) {
  compare(member);
  if (member.is_outdated) {
    update_mesh(member, settings);
  } else if (!has_equal_fields(member.settings, settings)) {
    scene_.set_settings(member.id, settings);
  }
  member.settings = settings;
}

void WorldMirror::update_mesh(Member& member, const BodySettings& settings) {
  BodyMesh mesh = read_mesh(*member.body);
  const BodyDesc desc = desc_of(mesh, settings);
  const std::vector<std::uint32_t> changed = changed_triangles(member.mesh, mesh);
  const std::size_t added = mesh.triangles.size() - std::min(mesh.triangles.size(), member.mesh.triangles.size());
  // Contact tests report edges by their numbers alone. So a probe reads a changed mesh as a whole, which numbers its
  // edges by the rule in Contact.
  if (!is_outside_steps() && changed.size() + added <= mesh.triangles.size() / kOneChangedIn) {
    scene_.update_body(member.id, desc, changed);
  } else {
    scene_.update_body(member.id, desc);
  }
  add_faces_of_nodes(mesh);
  mesh.outward = outward_side(mesh, *member.body);
  member.mesh = std::move(mesh);
  member.filters = 0;
  member.x.clear();
}

void WorldMirror::set_positions(Member& member, bool needs_way) {
  const btSoftBody& body = *member.body;
  if (is_outside_steps() && !has_moved(member)) return;
  const NodePosition start = ends_.start;
  const NodePosition end = body.isActive() ? ends_.end : start;
  if (needs_way) {
    scene_.set_positions(member.id, positions_of(body, start), positions_of(body, end));
  } else {
    scene_.set_positions(member.id, positions_of(body, start));
  }
  member.has_way = needs_way;
}

/// Compares the nodes' positions with those of the last call.
bool WorldMirror::has_moved(Member& member) {
  const auto count = static_cast<std::size_t>(member.body->m_nodes.size());
  bool has_moved = member.x.size() != count;
  member.x.resize(count);
  int node = 0;
  for (Vec3<btScalar>& x : member.x) {
    const btVector3& now = member.body->m_nodes[node++].m_x;
    const Vec3<btScalar> before = std::exchange(x, {now.x(), now.y(), now.z()});
    has_moved |= !(before == x);
  }
  return has_moved;
}

void WorldMirror::update_way(Member& member) {
  const btSoftBody& body = *member.body;
  scene_.set_positions(member.id, positions_of(body, ends_.start), positions_of(body, ends_.end));
  member.has_way = true;
}

const WorldMirror::Member* WorldMirror::find(BodyId id) const {
  const auto found = members_by_id_.find(id.value);
  return found == members_by_id_.end() ? nullptr : found->second;
}

}  // namespace softcd::bullet
