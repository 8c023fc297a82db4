#include "soft_body_registry.hpp"

#include <tbb/parallel_for.h>

#include <utility>

namespace softcd::bullet {
namespace {

bool is_same(const BodySettings& a, const BodySettings& b) {
  return a.margin == b.margin && a.self_collision == b.self_collision && a.kinematic == b.kinematic &&
         a.features.edge_edge == b.features.edge_edge;
}

}  // namespace

void SoftBodyRegistry::compare(Span<btSoftBody* const> bodies) {
  tbb::parallel_for(std::size_t{0}, bodies.size(), [&](std::size_t i) {
    const auto known = members_.find(bodies[i]);
    if (known != members_.end()) compare(known->second);
  });
}

void SoftBodyRegistry::compare(Member& member) const {
  if (member.last_compared == round_) return;
  member.topology_changed = !is_up_to_date(member.mesh, *member.body);
  member.last_compared = round_;
}

SoftBodyRegistry::Member& SoftBodyRegistry::synchronize(btSoftBody& body, const BodySettings& settings) {
  const auto known = members_.find(&body);
  if (known != members_.end()) update(known->second, settings);
  Member& member = known != members_.end() ? known->second : add(body, settings);
  member.last_round = round_;
  return member;
}

SoftBodyRegistry::Member& SoftBodyRegistry::add(btSoftBody& body, const BodySettings& settings) {
  Member member;
  member.body = &body;
  member.mesh = read_mesh(body);
  member.settings = settings;
  member.topology_changed = true;
  member.id = pipeline_.add_body({member.mesh.triangles, member.mesh.node_count, settings});
  Member& added = members_.emplace(&body, std::move(member)).first->second;
  members_by_id_[added.id.value] = &added;
  return added;
}

void SoftBodyRegistry::update(Member& member, const BodySettings& settings) {
  compare(member);
  if (member.topology_changed) {
    BodyMesh mesh = read_mesh(*member.body);
    pipeline_.update_body(member.id, {mesh.triangles, mesh.node_count, settings});
    member.mesh = std::move(mesh);
    member.settings = settings;
  } else {
    set_settings(member, settings);
  }
}

void SoftBodyRegistry::set_settings(Member& member, const BodySettings& settings) {
  if (!is_same(member.settings, settings)) pipeline_.set_settings(member.id, settings);
  member.settings = settings;
}

void SoftBodyRegistry::remove_absent() {
  for (auto entry = members_.begin(); entry != members_.end();) {
    if (entry->second.last_round == round_) {
      ++entry;
      continue;
    }
    pipeline_.remove_body(entry->second.id);
    members_by_id_.erase(entry->second.id.value);
    entry = members_.erase(entry);
  }
  ++round_;
}

}  // namespace softcd::bullet
