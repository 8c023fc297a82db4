#include "scenes/intersecting_bodies.hpp"

#include <stdexcept>
#include <string>
#include <utility>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletCollision/Gimpact/btGImpactShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "scenes/cloth.hpp"
#include "scenes/soft_ball.hpp"
#include "scenes/surface_mesh.hpp"

namespace softcd::demo {
namespace {

using Bodies = std::vector<std::unique_ptr<btSoftBody>>;

constexpr btScalar kClothMass = btScalar(0.2);
constexpr btScalar kBallRadius = btScalar(0.25);

std::unique_ptr<btSoftBody> make_thin_cloth(btSoftBodyWorldInfo& info, const ClothShape& shape) {
  auto cloth = make_cloth(info, shape, kClothMass);
  const btScalar cell = (cloth->m_nodes[1].m_x - cloth->m_nodes[0].m_x).length();
  cloth->getCollisionShape()->setMargin(cell / 5);
  cloth->m_cfg.kDP = btScalar(0.02);
  cloth->m_cfg.piterations = 4;
  return cloth;
}

/// A square cloth in the x-z plane, turned about the z axis and then moved.
std::unique_ptr<btSoftBody> make_turned_cloth(btSoftBodyWorldInfo& info, int size, btScalar angle,
                                              const btVector3& center) {
  ClothShape shape = horizontal_cloth(size, 1, 0);
  shape.position = [flat = shape.position, angle, center](int column, int row) {
    return center + flat(column, row).rotate(btVector3(0, 0, 1), angle);
  };
  return make_thin_cloth(info, shape);
}

/// A horizontal cloth, and another one that is turned by an angle and shifted.
Bodies make_two_cloths(btSoftBodyWorldInfo& info, int size, btScalar angle, const btVector3& shift) {
  Bodies bodies;
  bodies.push_back(make_turned_cloth(info, size, 0, btVector3(0, 0, 0)));
  bodies.push_back(make_turned_cloth(info, size, angle, shift));
  return bodies;
}

Bodies make_crossed_cloths(btSoftBodyWorldInfo& info, World, int size) {
  return make_two_cloths(info, size, btScalar(0.8), btVector3(btScalar(0.13), btScalar(0.02), btScalar(0.07)));
}

/// The borders of both cloths are through the other, and the curve ends within both.
Bodies make_interlocked_cloths(btSoftBodyWorldInfo& info, World, int size) {
  return make_two_cloths(info, size, btScalar(1.3), btVector3(btScalar(0.03), btScalar(0.02), btScalar(0.63)));
}

/// A strip along a loop whose ends pass through each other: a strophoid.
Bodies make_loop(btSoftBodyWorldInfo& info, World, int size) {
  ClothShape shape;
  shape.columns = 2 * size;
  shape.rows = size / 2;
  shape.resists_bending = false;
  shape.position = [size](int column, int row) {
    const btScalar t = btScalar(1.5) * (2 * btScalar(column) / btScalar(2 * size - 1) - 1);
    const btScalar s = t * t - 1;
    return btScalar(0.5) * btVector3(s, s * t, btScalar(row) * 3 / btScalar(size));
  };
  Bodies bodies;
  bodies.push_back(make_thin_cloth(info, shape));
  return bodies;
}

std::unique_ptr<btSoftBody> make_ball_at(btSoftBodyWorldInfo& info, World kind, const btVector3& center) {
  return make_soft_ball(info, kind, {center, kBallRadius, 2, btScalar(0.5), kBallRadius / 20});
}

Bodies make_two_balls(btSoftBodyWorldInfo& info, World kind, int /*size*/) {
  Bodies bodies;
  bodies.push_back(make_ball_at(info, kind, btVector3(0, 0, 0)));
  bodies.push_back(make_ball_at(info, kind, btVector3(btScalar(1.5) * kBallRadius, btScalar(0.02), btScalar(0.03))));
  return bodies;
}

Bodies make_heap(btSoftBodyWorldInfo& info, World kind, int /*size*/) {
  Bodies bodies;
  for (int i = 0; i < 20; ++i) {
    const int row = i / 5;
    const int layer = i / 10;
    const btVector3 cell(btScalar(i % 5), btScalar(row % 2), btScalar(layer));
    const btVector3 shift = btVector3(btScalar(i * 7 % 5), btScalar(i * 3 % 5), btScalar(i * 4 % 7)) * btScalar(0.004);
    bodies.push_back(make_ball_at(info, kind, cell * (btScalar(1.5) * kBallRadius) + shift));
  }
  return bodies;
}

/// An open cloth whose middle is inside a closed ball.
Bodies make_cloth_in_ball(btSoftBodyWorldInfo& info, World kind, int size) {
  Bodies bodies;
  bodies.push_back(make_turned_cloth(info, size, 0, btVector3(0, 0, 0)));
  bodies.push_back(make_ball_at(info, kind, btVector3(btScalar(0.05), btScalar(0.15), btScalar(0.02))));
  return bodies;
}

SurfaceMesh arm_mesh() {
  return lathe_mesh(
      refined(
          {{0, btScalar(-0.9)}, {btScalar(0.2), btScalar(-0.8)}, {btScalar(0.2), btScalar(0.8)}, {0, btScalar(0.9)}},
          btScalar(0.1)),
      16);
}

/// A sleeve that starts partly inside an arm.
std::unique_ptr<btSoftBody> make_narrow_sleeve(btSoftBodyWorldInfo& info, int size) {
  auto sleeve = make_thin_cloth(
      info, vertical_tube(btVector3(0, btScalar(-0.4), 0), btScalar(0.25), btScalar(0.8), 2 * size, size));
  // Bullet otherwise measures the links' lengths in the first step.
  sleeve->updateConstants();
  sleeve->m_bUpdateRtCst = false;
  sleeve->initializeFaceTree();
  for (int i = 0; i < sleeve->m_nodes.size(); ++i) {
    btVector3& x = sleeve->m_nodes[i].m_x;
    const btScalar narrowed = 1 - btScalar(0.35) * btExp(-btScalar(40) * x.y() * x.y());
    x = btVector3(x.x() * narrowed + btScalar(0.011), x.y(), x.z() * narrowed + btScalar(0.007));
    sleeve->m_nodes[i].m_q = x;
  }
  sleeve->getCollisionShape()->setMargin(btScalar(0.01));
  return sleeve;
}

/// The arm's nodes are massless.
Bodies make_sleeve(btSoftBodyWorldInfo& info, World, int size) {
  Bodies bodies;
  bodies.push_back(make_body(info, arm_mesh(), 0));
  bodies.back()->getCollisionShape()->setMargin(btScalar(0.01));
  bodies.push_back(make_narrow_sleeve(info, size));
  return bodies;
}

Bodies make_sleeve_alone(btSoftBodyWorldInfo& info, World, int size) {
  Bodies bodies;
  bodies.push_back(make_narrow_sleeve(info, size));
  return bodies;
}

/// A band along a trefoil knot that is nearly flat, so that it passes through itself where it crosses itself. Its ends
/// are apart.
Bodies make_knot(btSoftBodyWorldInfo& info, World, int size) {
  ClothShape shape;
  shape.columns = 6 * size;
  shape.rows = size / 3;
  shape.resists_bending = false;
  shape.position = [size](int column, int row) {
    const btScalar t = SIMD_2_PI * (btScalar(0.04) + btScalar(0.92) * btScalar(column) / btScalar(6 * size - 1));
    const btVector3 place(btSin(t) + 2 * btSin(2 * t), btCos(t) - 2 * btCos(2 * t), btScalar(-0.2) * btSin(3 * t));
    return btScalar(0.2) * (place + btVector3(0, 0, btScalar(row) * 4 / btScalar(size)));
  };
  Bodies bodies;
  bodies.push_back(make_thin_cloth(info, shape));
  return bodies;
}

Bodies make_tilted_cloth(btSoftBodyWorldInfo& info, World, int size) {
  Bodies bodies;
  bodies.push_back(make_turned_cloth(info, size, btScalar(0.1), btVector3(0, 0, 0)));
  return bodies;
}

/// A closed mesh around the cloth's middle.
std::vector<MeshBody> make_mesh_ball(btScalar mass) {
  return {{sphere_mesh(btVector3(btScalar(0.05), btScalar(0.15), btScalar(0.02)), btScalar(0.25), 2), mass}};
}

/// A slope that passes through the cloth.
std::vector<MeshBody> make_slope() {
  SurfaceMesh mesh;
  constexpr int kCells = 8;
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      const btScalar x = 4 * (btScalar(i) / kCells - btScalar(0.5));
      const btScalar z = 4 * (btScalar(j) / kCells - btScalar(0.5));
      mesh.positions.emplace_back(x, btScalar(-0.1) + btScalar(0.7) * x, z);
      if (i == kCells || j == kCells) continue;
      const int first = i * (kCells + 1) + j;
      mesh.triangles.push_back({first, first + 1, first + kCells + 1});
      mesh.triangles.push_back({first + 1, first + kCells + 2, first + kCells + 1});
    }
  }
  return {{mesh, 0}};
}

std::unique_ptr<btTriangleMesh> triangles_of(const SurfaceMesh& mesh) {
  auto triangles = std::make_unique<btTriangleMesh>();
  for (const auto& corners : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(corners[i])]; };
    triangles->addTriangle(corner(0), corner(1), corner(2));
  }
  return triangles;
}

/// A shape of Bullet's with its triangles.
template <class Shape>
class OwnedShape : public Shape {
 public:
  template <class... Arguments>
  explicit OwnedShape(std::unique_ptr<btTriangleMesh> triangles, Arguments... arguments)
      : Shape(triangles.get(), arguments...), triangles_(std::move(triangles)) {}

 private:
  std::unique_ptr<btTriangleMesh> triangles_;
};

std::unique_ptr<btCollisionShape> make_shape(const MeshBody& body) {
  if (!(body.mass > 0)) return std::make_unique<OwnedShape<btBvhTriangleMeshShape>>(triangles_of(body.mesh), true);
  auto shape = std::make_unique<OwnedShape<btGImpactMeshShape>>(triangles_of(body.mesh));
  shape->updateBound();
  return shape;
}

/// A small closed body wholly inside a large one.
Bodies make_ball_in_ball(btSoftBodyWorldInfo& info, World kind, int /*size*/) {
  Bodies bodies;
  bodies.push_back(make_soft_ball(info, kind, {btVector3(0, 0, 0), btScalar(0.5), 2, 1, btScalar(0.01)}));
  bodies.push_back(make_ball_at(info, kind, btVector3(btScalar(0.02), 0, 0)));
  return bodies;
}

}  // namespace

const std::vector<IntersectingBodies>& intersecting_bodies() {
  static const std::vector<IntersectingBodies> list = {
      {"crossed-cloths", "two cloths through each other", make_crossed_cloths},
      {"interlocked-cloths", "two cloths, each with a border through the other", make_interlocked_cloths},
      {"loop", "a strip whose ends pass through each other", make_loop},
      {"two-balls", "two balls that overlap by half a radius", make_two_balls},
      {"heap", "20 balls that overlap by half a radius", make_heap},
      {"cloth-in-ball", "a cloth through a ball", make_cloth_in_ball},
      {"sleeve", "a sleeve partly inside a massless arm", make_sleeve},
      {"knot", "a band drawn through itself along a knot", make_knot},
      {"cloth-in-mesh", "a cloth half-way through a static mesh", make_tilted_cloth, [] { return make_mesh_ball(0); }},
      {"cloth-in-free-mesh", "a cloth half-way through a mesh that moves freely", make_tilted_cloth,
       [] { return make_mesh_ball(1); }},
      {"cloth-in-slope", "a cloth half-way through an open mesh", make_tilted_cloth, make_slope},
      {"sleeve-on-mesh", "a sleeve partly inside an arm that is a static mesh", make_sleeve_alone,
       [] {
         return std::vector<MeshBody>{{arm_mesh(), 0}};
       }},
      {"ball-in-ball", "a ball wholly inside another one", make_ball_in_ball},
  };
  return list;
}

const IntersectingBodies& find_intersecting_bodies(const char* name) {
  for (const IntersectingBodies& bodies : intersecting_bodies()) {
    if (std::string(bodies.name) == name) return bodies;
  }
  throw std::invalid_argument(std::string("there are no intersecting bodies named ") + name);
}

RigidMeshes::RigidMeshes(const IntersectingBodies& kind, btSoftBodyWorldInfo& world_info, const AddRigid& add_rigid) {
  if (kind.make_meshes != nullptr) meshes_ = kind.make_meshes();
  for (const MeshBody& body : meshes_) {
    std::unique_ptr<btCollisionShape> shape = make_shape(body);
    shape->setMargin(btScalar(0.01));
    bodies_.push_back(&add_rigid(std::move(shape), btVector3(0, 0, 0), body.mass));
    copies_.push_back(make_body(world_info, body.mesh, 0));
  }
}

void RigidMeshes::append_copies(std::vector<const btSoftBody*>& bodies) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    int node = 0;
    for (const btVector3& position : meshes_[i].mesh.positions) {
      copies_[i]->m_nodes[node++].m_x = bodies_[i]->getWorldTransform() * position;
    }
    bodies.push_back(copies_[i].get());
  }
}

}  // namespace softcd::demo
