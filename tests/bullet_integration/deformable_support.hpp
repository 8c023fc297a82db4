#pragma once

#include <memory>
#include <optional>

#include "scenes/deformable_simulation.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {

/// A hollow ball of one kilogram, 320 triangles.
inline std::unique_ptr<btSoftBody> make_soft_ball(btSoftBodyWorldInfo& world_info, const btVector3& center,
                                                  btScalar radius) {
  auto ball = demo::make_ball(world_info, center, radius, 2);
  for (int i = 0; i < ball->m_nodes.size(); ++i) ball->setMass(i, 1);
  ball->setTotalMass(1);
  return ball;
}

/// A strip rolled up so that its layers touch.
inline std::unique_ptr<btSoftBody> make_roll(btSoftBodyWorldInfo& info, int columns, int rows) {
  demo::ClothShape shape;
  shape.columns = columns;
  shape.rows = rows;
  shape.position = [](int column, int row) {
    const btScalar angle = btScalar(0.35) * btScalar(column);
    const btScalar radius = btScalar(0.3) + btScalar(0.008) * angle;
    return btVector3(radius * btCos(angle), radius * btSin(angle), btScalar(0.1) * btScalar(row));
  };
  auto roll = demo::make_cloth(info, shape, 1);
  roll->getCollisionShape()->setMargin(btScalar(0.03));
  return roll;
}

/// The height of a sheet, the graph of a function of x and z, as far as it reaches.
inline std::optional<btScalar> height_at(const btSoftBody& sheet, btScalar x, btScalar z) {
  for (int f = 0; f < sheet.m_faces.size(); ++f) {
    const btVector3& a = sheet.m_faces[f].m_n[0]->m_x;
    const btVector3 ab = sheet.m_faces[f].m_n[1]->m_x - a;
    const btVector3 ac = sheet.m_faces[f].m_n[2]->m_x - a;
    const btScalar area = ab.x() * ac.z() - ab.z() * ac.x();
    if (btFabs(area) < SIMD_EPSILON) continue;
    const btScalar u = ((x - a.x()) * ac.z() - (z - a.z()) * ac.x()) / area;
    const btScalar v = (ab.x() * (z - a.z()) - ab.z() * (x - a.x())) / area;
    if (u >= 0 && v >= 0 && u + v <= 1) return a.y() + u * ab.y() + v * ac.y();
  }
  return std::nullopt;
}

inline int count_below(const btSoftBody& body, const btSoftBody& sheet) {
  int count = 0;
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btVector3& x = body.m_nodes[n].m_x;
    count += x.y() < height_at(sheet, x.x(), x.z()).value_or(x.y());
  }
  return count;
}

}  // namespace softcd::test
