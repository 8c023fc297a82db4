#include "soft_body_scene.hpp"

#include <algorithm>
#include <utility>

namespace softcd::bullet {
namespace {

constexpr std::uint32_t kTetrahedronFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}};

/// The sides of all tetrahedra, four each.
std::vector<Triangle> tetrahedron_faces(const btSoftBody& body) {
  std::vector<Triangle> triangles;
  triangles.reserve(4 * static_cast<std::size_t>(body.m_tetras.size()));
  for (int i = 0; i < body.m_tetras.size(); ++i) {
    for (const auto& corners : kTetrahedronFaces) {
      Triangle triangle{};
      for (int corner = 0; corner < 3; ++corner) {
        triangle.v[corner] = static_cast<std::uint32_t>(body.m_tetras[i].m_n[corners[corner]] - &body.m_nodes[0]);
      }
      triangles.push_back(triangle);
    }
  }
  return triangles;
}

bool has_same_corners(const Triangle& a, const Triangle& b) {
  return std::equal(a.v, a.v + 3, b.v);
}

SceneOptions on_the_cpu() {
  SceneOptions options;
  options.backend = Backend::cpu;
  return options;
}

}  // namespace

SoftBodyScene::SoftBodyScene(RayTargets targets, LogCallback log)
    : targets_(targets), scene_(on_the_cpu(), std::move(log)) {}

const SoftBodyScene::Member& SoftBodyScene::update(btSoftBody& body) {
  std::vector<Triangle> tetrahedra;
  if (targets_ == RayTargets::faces_and_tetrahedra) tetrahedra = tetrahedron_faces(body);
  Member& member = members_[&body];
  const bool is_known = member.body != nullptr;
  if (!is_known || !is_up_to_date(member.mesh, body) ||
      !std::equal(tetrahedra.begin(), tetrahedra.end(), member.tetrahedron_faces.begin(),
                  member.tetrahedron_faces.end(), has_same_corners)) {
    set_mesh(member, body, std::move(tetrahedra));
  }
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

void SoftBodyScene::set_mesh(Member& member, btSoftBody& body, std::vector<Triangle> tetrahedra) {
  BodyMesh mesh = read_mesh(body);
  std::vector<Triangle> triangles = mesh.triangles;
  triangles.insert(triangles.end(), tetrahedra.begin(), tetrahedra.end());
  const BodyDesc desc = {triangles, mesh.node_count, {}, -1, mesh.segments};
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
  member.tetrahedron_faces = std::move(tetrahedra);
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
