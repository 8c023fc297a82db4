#include "app_world.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "scenes/penetration.hpp"

namespace softcd::benchmarks {
namespace {

demo::PlugIn plug_in_of(AppWorldKind kind, bool is_softcd) {
  if (kind == AppWorldKind::soft_multi_body) {
    return is_softcd ? demo::PlugIn::multi_body_world : demo::PlugIn::none_multi_body;
  }
  return is_softcd ? demo::PlugIn::one_line_world : demo::PlugIn::none;
}

double length_of(const btVector3& v) {
  return std::hypot(double(v.x()), double(v.y()), double(v.z()));
}

/// Returns the kinetic energy in J.
double energy_of(const btSoftBody::Node& node) {
  const double speed = length_of(node.m_v);
  return node.m_im > 0 ? speed * speed / double(node.m_im) / 2 : 0;
}

double energy_of(const btRigidBody& body) {
  if (body.isStaticOrKinematicObject()) return 0;
  const btVector3& spin = body.getAngularVelocity();
  const btMatrix3x3 inertia = body.getInvInertiaTensorWorld().inverse();
  const double speed = length_of(body.getLinearVelocity());
  return speed * speed / double(body.getInvMass()) / 2 + double(spin.dot(inertia * spin)) / 2;
}

bool is_free(const btSoftBody& body) {
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    if (!(body.m_nodes[i].m_im > 0)) return false;
  }
  return true;
}

double mean_height(const btSoftBody& body) {
  double sum = 0;
  for (int i = 0; i < body.m_nodes.size(); ++i) sum += double(body.m_nodes[i].m_x.y());
  return sum / std::max(1, body.m_nodes.size());
}

}  // namespace

AppWorld::AppWorld(AppWorldKind kind, const std::optional<bullet::Settings>& settings, int iterations)
    : iterations_(iterations),
      world_(kind == AppWorldKind::deformable ? demo::World::deformable : demo::World::classic,
             plug_in_of(kind, settings.has_value()), settings.value_or(bullet::Settings())) {}

AppWorld::~AppWorld() = default;

btSoftBody& AppWorld::add(std::unique_ptr<btSoftBody> body) {
  body->m_cfg.piterations = iterations_;
  return world_.add(std::move(body));
}

btRigidBody& AppWorld::add_rigid(std::unique_ptr<btCollisionShape> shape, const btVector3& center, btScalar mass) {
  rigid_bodies_.push_back(&world_.add_rigid(std::move(shape), center, mass));
  rigid_bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
  return *rigid_bodies_.back();
}

btRigidBody& AppWorld::add_mesh(const demo::SurfaceMesh& mesh, const btVector3& center) {
  auto triangles = std::make_unique<btTriangleMesh>();
  const auto corner = [&](int i) { return mesh.positions[static_cast<std::size_t>(i)]; };
  for (const auto& [a, b, c] : mesh.triangles) triangles->addTriangle(corner(a), corner(b), corner(c));
  auto shape = std::make_unique<btBvhTriangleMeshShape>(triangles.get(), /*useQuantizedAabbCompression=*/true);
  triangles_.push_back(std::move(triangles));
  btRigidBody& body = add_rigid(std::move(shape), center);
  mesh_images_.push_back({&body, mesh, demo::make_body(info(), mesh, 0)});
  return body;
}

void AppWorld::shift_bodies(unsigned start) {
  std::mt19937 random(start);
  const auto shift = [&random] {
    return btScalar(1e-3) * (btScalar(2) * btScalar(random()) / btScalar(std::mt19937::max()) - 1);
  };
  for (btSoftBody* body : world_.bodies()) {
    const btScalar x = shift();
    const btScalar y = shift();
    body->translate(btVector3(x, y, shift()));
  }
}

std::size_t AppWorld::count_crossings() {
  std::vector<const btSoftBody*> surfaces(world_.bodies().begin(), world_.bodies().end());
  for (const MeshImage& mesh : mesh_images_) {
    int node = 0;
    for (const btVector3& corner : mesh.shape.positions) {
      mesh.image->m_nodes[node++].m_x = mesh.mesh->getWorldTransform() * corner;
    }
    surfaces.push_back(mesh.image.get());
  }
  const auto is_image = [this](const btSoftBody& body) {
    return std::any_of(mesh_images_.begin(), mesh_images_.end(),
                       [&](const MeshImage& mesh) { return mesh.image.get() == &body; });
  };
  const auto counts = [&](const btSoftBody& edges, const btSoftBody& triangles) {
    if (&edges == &triangles) return bool(edges.m_useSelfCollision);
    return !is_image(edges) || !is_image(triangles);
  };
  return demo::find_intersections(surfaces, counts).edge_count;
}

AppMotion AppWorld::motion() {
  AppMotion motion;
  const btVector3 gravity = info().m_gravity;
  const auto include = [&](double energy, btScalar inverse_mass, const btVector3& place) {
    motion.kinetic_energy += energy;
    if (inverse_mass > 0) motion.potential_energy -= double(gravity.dot(place)) / double(inverse_mass);
    // NaN counts as farthest.
    const double distance = length_of(place);
    if (!(distance <= motion.farthest)) motion.farthest = distance;
  };
  for (const btSoftBody* body : world_.bodies()) {
    for (int i = 0; i < body->m_nodes.size(); ++i) {
      const btSoftBody::Node& node = body->m_nodes[i];
      include(energy_of(node), node.m_im, node.m_x);
    }
  }
  for (const btRigidBody* body : rigid_bodies_) {
    if (body->isStaticOrKinematicObject()) continue;
    include(energy_of(*body), body->getInvMass(), body->getWorldTransform().getOrigin());
  }
  return motion;
}

std::size_t AppWorld::count_lost(btScalar height) const {
  for (const btSoftBody* body : world_.bodies()) {
    if (is_free(*body)) continue;
    // The order ignores NaN.
    for (int i = 0; i < body->m_nodes.size(); ++i) height = btMin(body->m_nodes[i].m_x.y(), height);
  }
  std::size_t count = 0;
  for (const btSoftBody* body : world_.bodies()) {
    if (is_free(*body) && !(mean_height(*body) >= double(height))) ++count;
  }
  for (const btRigidBody* body : rigid_bodies_) {
    if (!body->isStaticOrKinematicObject() && !(body->getWorldTransform().getOrigin().y() >= height)) ++count;
  }
  return count;
}

void make_kinematic(btRigidBody& body) {
  body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  body.setActivationState(DISABLE_DEACTIVATION);
}

}  // namespace softcd::benchmarks
