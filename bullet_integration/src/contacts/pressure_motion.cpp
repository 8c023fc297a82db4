#include "contacts/pressure_motion.hpp"

#include "native/native_trees.hpp"

namespace softcd::bullet {
namespace {

/// Does btSoftBody::getVolume for the start positions.
btScalar start_volume(const btSoftBody& body) {
  btScalar volume = 0;
  const btVector3 origin = body.m_nodes[0].m_q;
  for (const btSoftBody::Face& face : span_of(body.m_faces)) {
    const auto corner = [&](int i) { return face.m_n[i]->m_q - origin; };
    volume += corner(0).dot(corner(1).cross(corner(2)));
  }
  return volume / 6;
}

}  // namespace

void PressureMotion::read(Span<const btSoftBody* const> bodies) {
  motions_.clear();
  for (const btSoftBody* body : bodies) {
    const btScalar pressure = body->m_cfg.kPR;
    const btScalar stiffness = btMax(body->m_cfg.kVC, btScalar(0));
    if (!body->isActive() || body->m_faces.size() == 0 || (pressure == 0 && stiffness == 0)) continue;
    // Follows btSoftBody::applyForces.
    const btScalar volume = start_volume(*body);
    btScalar force_of_area = stiffness * (body->m_pose.m_volume - volume);
    if (pressure != 0) force_of_area += pressure / btFabs(volume);
    motions_.emplace(body, force_of_area * body->m_sst.sdt * body->m_sst.sdt);
  }
}

bool PressureMotion::is_cause_of(const MemberContact& found) const {
  if (motions_.empty()) return false;
  const Contact& contact = found.contact;
  btVector3 start(0, 0, 0);
  btVector3 end(0, 0, 0);
  for (int i = 0; i < 4; ++i) {
    const btSoftBody::Node& node = found.node(i);
    const bool is_of_first = contact.kind == ContactKind::vertex_triangle ? i == 0 : i < 2;
    const auto weight = btScalar(is_of_first ? contact.weights[i] : -contact.weights[i]);
    start += weight * node.m_q;
    end += weight * node.m_x;
    const auto motion = motions_.find((found.is_of_a(i) ? found.a : found.b).body);
    if (motion != motions_.end()) end -= node.m_n * (weight * node.m_area * node.m_im * motion->second);
  }
  const btVector3 normal = to_bullet(contact.normal);
  const btScalar margins = margin_of(*found.a.body) + margin_of(*found.b.body);
  return normal.dot(start) > margins && normal.dot(end) > margins;
}

}  // namespace softcd::bullet
