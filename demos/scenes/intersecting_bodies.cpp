#include "scenes/intersecting_bodies.hpp"

#include <stdexcept>
#include <string>

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

/// A sleeve that starts partly inside an arm, whose nodes are massless.
Bodies make_sleeve(btSoftBodyWorldInfo& info, World, int size) {
  Bodies bodies;
  bodies.push_back(make_body(info,
                             lathe_mesh(refined({{0, btScalar(-0.9)},
                                                 {btScalar(0.2), btScalar(-0.8)},
                                                 {btScalar(0.2), btScalar(0.8)},
                                                 {0, btScalar(0.9)}},
                                                btScalar(0.1)),
                                        16),
                             0));
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
  bodies.push_back(std::move(sleeve));
  for (const auto& body : bodies) body->getCollisionShape()->setMargin(btScalar(0.01));
  return bodies;
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

}  // namespace softcd::demo
