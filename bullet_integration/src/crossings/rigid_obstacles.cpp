#include "crossings/rigid_obstacles.hpp"

#include <algorithm>
#include <limits>

#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "LinearMath/btAabbUtil2.h"
#include "bodies/vectors.hpp"
#include "rigid/rigid_pairs.hpp"
#include "rigid/rigid_touches.hpp"

namespace softcd::bullet {
namespace {

/// Enlarges boxes for rounding, so that they also contain objects that only touch at their margins.
constexpr btScalar kBoxRounding = 16 * std::numeric_limits<btScalar>::epsilon();

RigidBox reach_of(const btSoftBody& body) {
  RigidBox box = swept_box(body, body.getCollisionShape()->getMargin());
  const btVector3 growth = kBoxRounding * (box.low.absolute() + box.high.absolute());
  return {box.low - growth, box.high + growth};
}

/// Makes a soft body that nothing moves and that collides with nothing by itself. `number` tells it from an earlier
/// proxy at the same address.
std::unique_ptr<btSoftBody> make_proxy(btSoftBodyWorldInfo& world_info, int number) {
  auto body = std::make_unique<btSoftBody>(&world_info);
  body->setUserIndex(number);
  body->m_cfg.collisions = 0;
  body->getCollisionShape()->setMargin(0);
  return body;
}

void set_faces(const RigidMesh& mesh, btSoftBody& body) {
  body.m_faces.clear();
  body.m_nodes.clear();
  static const btSoftBody::Node no_mass{};  // all members are 0
  body.m_nodes.resize(static_cast<int>(mesh.vertex_count()), no_mass);
  for (const Triangle& triangle : mesh.triangles()) {
    btSoftBody::Face face{};
    for (int i = 0; i < 3; ++i) face.m_n[i] = &body.m_nodes[static_cast<int>(triangle.v[i])];
    body.m_faces.push_back(face);
  }
}

}  // namespace

bool RigidObstacles::collide(const btSoftBody& a, const btSoftBody& b) const {
  const auto holds = [this](const btSoftBody& proxy, const btSoftBody& soft) {
    const auto known = partners_.find(&proxy);
    return known != partners_.end() && known->second.count(&soft) != 0;
  };
  return holds(a, b) || holds(b, a);
}

const btCollisionObject& RigidObstacles::object_of(const btSoftBody& body) const {
  const auto part =
      std::find_if(parts_.begin(), parts_.end(), [&](const auto& entry) { return entry.second.proxy.get() == &body; });
  return part != parts_.end() ? *std::get<BodyKey>(part->first).object : static_cast<const btCollisionObject&>(body);
}

void RigidObstacles::remove_absent() {
  proxies_.clear();
  for (auto entry = parts_.begin(); entry != parts_.end();) {
    if (!std::exchange(entry->second.is_present, false)) {
      entry = parts_.erase(entry);
      continue;
    }
    proxies_.push_back(entry->second.proxy.get());
    ++entry;
  }
}

void RigidObstacles::begin_step(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step) {
  remove_absent();
  partners_.clear();
  meshes_.clear();
  surroundings_ = surroundings;
  time_step_ = time_step;
  if (surroundings.objects == nullptr) return;
  for (const MeshWay& way : ways_.find(*surroundings.objects)) meshes_.push_back({way});
  follow(bodies);
}

void RigidObstacles::follow(Span<btSoftBody* const> bodies) {
  if (meshes_.empty()) return;
  std::vector<Reach> all;
  for (btSoftBody* body : bodies) all.push_back({body, reach_of(*body)});
  for (Mesh& mesh : meshes_) {
    const MeshWay& way = mesh.way;
    std::vector<Reach> reaches;
    for (const auto& [body, world_box] : all) {
      if (!TestAabbAgainstAabb2(way.box.low, way.box.high, world_box.low, world_box.high)) continue;
      const RigidBox box = box_in_shape(world_box, way.poses);
      if (is_covered(mesh, *body, box) || !takes_meshes_of(*body, *way.object)) continue;
      if (surroundings_.collides(*body, *way.object)) reaches.push_back({body, box});
    }
    if (!reaches.empty()) add_part(mesh, reaches);
  }
}

bool RigidObstacles::is_covered(const Mesh& mesh, const btSoftBody& body, const RigidBox& box) const {
  return std::any_of(mesh.parts.begin(), mesh.parts.end(), [&](const Part* part) {
    return part->mesh.covers(box) && (part->mesh.triangles().empty() || collide(*part->proxy, body));
  });
}

void RigidObstacles::add_part(Mesh& mesh, const std::vector<Reach>& reaches) {
  const MeshWay& way = mesh.way;
  Part& part = parts_[{BodyKey(*way.object), way.shape, way.child, static_cast<int>(mesh.parts.size())}];
  if (part.proxy == nullptr) {
    part.proxy = make_proxy(*reaches.front().body->getWorldInfo(), ++last_proxy_);
    proxies_.push_back(part.proxy.get());
  }
  part.is_present = true;
  mesh.parts.push_back(&part);
  std::vector<RigidBox> boxes;
  boxes.reserve(reaches.size());
  for (const Reach& reach : reaches) boxes.push_back(reach.box);
  if (part.mesh.read(*way.shape, boxes)) set_faces(part.mesh, *part.proxy);
  if (part.mesh.triangles().empty()) return;
  place(part, way);
  mirror_.require(*part.proxy, /*needs_way=*/true);
  Partners& partners = partners_[part.proxy.get()];
  for (const Reach& reach : reaches) partners.insert(reach.body);
}

void RigidObstacles::place(Part& part, const MeshWay& way) const {
  btSoftBody& body = *part.proxy;
  part.mesh.place(way.poses);
  body.m_cfg.kDF = way.object->getFriction();
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    btSoftBody::Node& node = body.m_nodes[i];
    node.*ends_.start = to_bullet(part.mesh.x_t0()[static_cast<std::size_t>(i)]);
    node.*ends_.end = to_bullet(part.mesh.x_t1()[static_cast<std::size_t>(i)]);
    const btVector3 motion = node.*ends_.end - node.*ends_.start;
    node.m_v = time_step_ > 0 ? motion / time_step_ : btVector3(0, 0, 0);
    node.m_splitv.setZero();
  }
}

void RigidObstacles::end_step() {
  surroundings_ = {};
}

}  // namespace softcd::bullet
