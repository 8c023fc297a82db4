#include "crossings/rigid_obstacles.hpp"

#include <algorithm>
#include <limits>

#include "rigid/rigid_pairs.hpp"
#include "rigid/rigid_touches.hpp"

namespace softcd::bullet {
namespace {

/// Enlarges boxes for rounding, so that they also contain objects that only touch at their margins.
constexpr btScalar kBoxRounding = 16 * std::numeric_limits<btScalar>::epsilon();

Bounds reach_of(const btSoftBody& body) {
  const Bounds box = swept_box(body, margin_of(body));
  return box.grown(kBoxRounding * (box.low.absolute() + box.high.absolute()));
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
  const btCollisionObject* const object = proxies_.object_of(body);
  return object != nullptr ? *object : static_cast<const btCollisionObject&>(body);
}

btRigidBody* RigidObstacles::free_body_of(const btSoftBody& proxy) const {
  btRigidBody* const rigid = const_cast<btRigidBody*>(btRigidBody::upcast(proxies_.object_of(proxy)));
  if (rigid == nullptr || rigid->isStaticOrKinematicObject() || !(rigid->getInvMass() > 0)) return nullptr;
  return rigid;
}

void RigidObstacles::begin_step(Span<btSoftBody* const> bodies, const Surroundings& surroundings, btScalar time_step) {
  proxies_.begin_step();
  partners_.clear();
  meshes_.clear();
  held_.clear();
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
      if (!way.box.overlaps(world_box)) continue;
      const Bounds box = box_in_shape(world_box, way.poses);
      if (is_covered(mesh, *body, box) || !takes_meshes_of(*body, *way.object)) continue;
      if (surroundings_.collides(*body, *way.object)) reaches.push_back({body, box});
    }
    if (!reaches.empty()) add_piece(mesh, reaches);
  }
}

bool RigidObstacles::is_covered(const Mesh& mesh, const btSoftBody& body, const Bounds& box) const {
  return std::any_of(mesh.pieces.begin(), mesh.pieces.end(), [&](const RigidProxies::Piece* piece) {
    const RigidMesh& read = piece->part.shape;
    return read.covers(box) && (read.triangles().empty() || collide(*piece->body, body));
  });
}

void RigidObstacles::add_piece(Mesh& mesh, const std::vector<Reach>& reaches) {
  const MeshWay& way = mesh.way;
  std::vector<Bounds> boxes;
  boxes.reserve(reaches.size());
  for (const Reach& reach : reaches) boxes.push_back(reach.box);
  const RigidKey key(BodyKey(*way.object), way.shape, way.child, static_cast<int>(mesh.pieces.size()));
  RigidProxies::Piece& piece =
      proxies_.require(key, *way.object, boxes, way.poses, time_step_, *reaches.front().body->getWorldInfo());
  mesh.pieces.push_back(&piece);
  if (piece.part.shape.triangles().empty()) return;
  mirror_.require(*piece.body, /*needs_way=*/true);
  Partners& partners = partners_[piece.body.get()];
  for (const Reach& reach : reaches) partners.insert(reach.body);
}

bool RigidObstacles::hold(btRigidBody& body) {
  if (!held_.emplace(&body, body.getWorldTransform()).second) return false;
  for (Mesh& mesh : meshes_) {
    MeshWay& way = mesh.way;
    if (way.object != &body) continue;
    body.proceedToTransform(way.object_start);
    way.poses.t1 = way.poses.t0;
    way.box = bounds_of(*way.shape, way.poses.t0);
    for (RigidProxies::Piece* piece : mesh.pieces) {
      proxies_.hold(*piece, way.poses.t0);
      if (has(*piece->body)) mirror_.update_way(mirror_.member(*piece->body));
    }
  }
  return true;
}

void RigidObstacles::stop_held() const {
  for (const auto& [body, end] : held_) {
    body->setLinearVelocity(btVector3(0, 0, 0));
    body->setAngularVelocity(btVector3(0, 0, 0));
    body->proceedToTransform(body->getWorldTransform());
  }
}

void RigidObstacles::release_held() {
  for (const auto& [body, end] : held_) body->proceedToTransform(end);
  held_.clear();
}

void RigidObstacles::end_step() {
  surroundings_ = {};
}

}  // namespace softcd::bullet
