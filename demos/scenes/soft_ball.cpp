#include "scenes/soft_ball.hpp"

#include "scenes/surface_mesh.hpp"

namespace softcd::demo {
namespace {

void link_opposite_nodes(btSoftBody& ball, const SoftBallShape& shape) {
  const btScalar tolerance = btScalar(0.02) * shape.radius;
  const auto is_opposite = [&](const btSoftBody::Node& a, const btSoftBody::Node& b) {
    return (a.m_x - shape.center + b.m_x - shape.center).length2() < tolerance * tolerance;
  };
  for (int i = 0; i < ball.m_nodes.size(); ++i) {
    for (int j = 0; j < i; ++j) {
      if (is_opposite(ball.m_nodes[i], ball.m_nodes[j])) ball.appendLink(i, j);
    }
  }
}

}  // namespace

std::unique_ptr<btSoftBody> make_soft_ball(btSoftBodyWorldInfo& world_info, World kind, const SoftBallShape& shape) {
  auto ball = make_body(world_info, sphere_mesh(shape.center, shape.radius, shape.subdivisions), 1);
  ball->setTotalMass(shape.mass);
  if (kind == World::deformable) {
    link_opposite_nodes(*ball, shape);
  } else {
    ball->setPose(/*bvolume=*/false, /*bframe=*/true);
    ball->m_cfg.kMT = btScalar(0.6);
  }
  ball->m_cfg.kDF = btScalar(0.5);
  ball->m_cfg.collisions |= btSoftBody::fCollision::SDF_RS;
  ball->getCollisionShape()->setMargin(shape.margin);
  return ball;
}

}  // namespace softcd::demo
