#include "bodies/rigid_mirror.hpp"

#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

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

void RigidProxies::begin_step() {
  std::erase_if(pieces_, [this](const auto& entry) { return entry.second.part.last_step != step_; });
  ++step_;
  bodies_.clear();
  for (const auto& [key, piece] : pieces_) bodies_.push_back(piece.body.get());
}

void RigidProxies::clear() {
  pieces_.clear();
  bodies_.clear();
}

const btCollisionObject* RigidProxies::object_of(const btSoftBody& body) const {
  const auto piece =
      std::find_if(pieces_.begin(), pieces_.end(), [&](const auto& entry) { return entry.second.body.get() == &body; });
  return piece != pieces_.end() ? piece->second.part.object : nullptr;
}

RigidProxies::Piece& RigidProxies::require(const RigidKey& key, const btCollisionObject& object,
                                           const std::vector<Bounds>& boxes, const RigidPoses& poses,
                                           btScalar time_step, btSoftBodyWorldInfo& world_info) {
  Piece& piece = pieces_[key];
  if (piece.body == nullptr) {
    piece.body = make_proxy(world_info, ++last_number_);
    bodies_.push_back(piece.body.get());
  }
  piece.part.last_step = step_;
  piece.part.object = &object;
  RigidMesh& mesh = piece.part.shape;
  if (mesh.read(static_cast<const btConcaveShape&>(*std::get<1>(key)), boxes)) set_faces(mesh, *piece.body);
  mesh.place(poses);
  place(piece, time_step);
  return piece;
}

void RigidProxies::hold(Piece& piece, const btTransform& start) const {
  piece.part.shape.place({start, start});
  place(piece, /*time_step=*/0);
}

void RigidProxies::place(Piece& piece, btScalar time_step) const {
  btSoftBody& body = *piece.body;
  const RigidMesh& mesh = piece.part.shape;
  body.m_cfg.kDF = piece.part.object->getFriction();
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    btSoftBody::Node& node = body.m_nodes[i];
    node.*ends_.start = to_bullet(mesh.x_t0()[static_cast<std::size_t>(i)]);
    node.*ends_.end = to_bullet(mesh.x_t1()[static_cast<std::size_t>(i)]);
    const btVector3 motion = node.*ends_.end - node.*ends_.start;
    node.m_v = time_step > 0 ? motion / time_step : btVector3(0, 0, 0);
    node.m_splitv.setZero();
  }
}

}  // namespace softcd::bullet
