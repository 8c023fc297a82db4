#include "questions/soft_body_scene.hpp"

#include <algorithm>
#include <utility>

namespace softcd::bullet {
namespace {

SceneOptions on_the_cpu() {
  SceneOptions options;
  options.backend = Backend::cpu;
  return options;
}

}  // namespace

SoftBodyScene::SoftBodyScene(LogCallback log) : scene_(on_the_cpu(), std::move(log)) {}

const SoftBodyScene::Member& SoftBodyScene::update(btSoftBody& body) {
  Member& member = members_[&body];
  const bool is_known = member.body != nullptr;
  if (!is_known || !is_up_to_date(member.mesh, body)) set_mesh(member, body);
  update_positions(member, body);
  return member;
}

void SoftBodyScene::keep(Span<btSoftBody* const> all) {
  if (members_.size() <= all.size()) return;
  for (auto entry = members_.begin(); entry != members_.end();) {
    if (std::find(all.begin(), all.end(), entry->first) != all.end()) {
      ++entry;
      continue;
    }
    scene_.remove_body(entry->second.id);
    members_by_id_.erase(entry->second.id.value);
    entry = members_.erase(entry);
  }
}

const SoftBodyScene::Member* SoftBodyScene::find(const btSoftBody& body) const {
  const auto found = members_.find(&body);
  return found == members_.end() ? nullptr : &found->second;
}

const SoftBodyScene::Member* SoftBodyScene::find(BodyId id) const {
  const auto found = members_by_id_.find(id.value);
  return found == members_by_id_.end() ? nullptr : found->second;
}

void SoftBodyScene::set_mesh(Member& member, btSoftBody& body) {
  BodyMesh mesh = read_mesh(body);
  BodySettings settings;
  settings.self_collision = false;
  const BodyDesc desc = {mesh.triangles, mesh.node_count, settings, -1, mesh.segments};
  if (member.body == nullptr) {
    member.id = scene_.add_body(desc);
    try {
      members_by_id_[member.id.value] = &member;
    } catch (...) {
      scene_.remove_body(member.id);
      throw;
    }
  } else {
    scene_.update_body(member.id, desc);
  }
  member.body = &body;
  member.mesh = std::move(mesh);
  member.positions.clear();
}

void SoftBodyScene::update_positions(Member& member, const btSoftBody& body) {
  const auto count = static_cast<std::size_t>(body.m_nodes.size());
  bool has_moved = member.positions.size() != count;
  member.positions.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const btVector3& x = body.m_nodes[static_cast<int>(i)].m_x;
    const Vec3<btScalar> now{x.x(), x.y(), x.z()};
    has_moved |= !(member.positions[i] == now);
    member.positions[i] = now;
  }
  if (has_moved && count > 0) scene_.set_positions(member.id, member.positions);
}

}  // namespace softcd::bullet
