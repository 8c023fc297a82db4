#include "rigid/rigid_touches.hpp"

#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

int node_contact_count(const btSoftBody& body) {
  return has_deformable_contacts(body) ? body.m_nodeRigidContacts.size() : body.m_rcontacts.size();
}

}  // namespace

bool has_deformable_contacts(const btSoftBody& body) {
  return (body.m_cfg.collisions & btSoftBody::fCollision::RVSmask) == btSoftBody::fCollision::SDF_RD;
}

bool takes_node_contacts(const btSoftBody& body, const btSoftBody::Node& node) {
  if (node.m_battach != 0) return false;
  return !has_deformable_contacts(body) || (body.m_cfg.collisions & btSoftBody::fCollision::SDF_RDN) != 0;
}

Bounds swept_box(const btSoftBody& body, btScalar margin) {
  return bounds_of(body, {&btSoftBody::Node::m_x, &btSoftBody::Node::m_q}).grown(margin);
}

btVector3 point_on(const btSoftBody::Face& face, const btVector3& weights, NodePosition position) {
  btVector3 point(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    if (weights[i] != 0) point += weights[i] * (face.m_n[i]->*position);
  }
  return point;
}

btVector3 weights_on_edge(const btSoftBody::Face& face, const btSoftBody& body, const std::uint32_t* nodes,
                          const float* weights) {
  btVector3 result(0, 0, 0);
  for (int i = 0; i < 3; ++i) {
    for (int end = 0; end < 2; ++end) {
      if (face.m_n[i] == &body.m_nodes[static_cast<int>(nodes[end])]) result[i] = btScalar(weights[end]);
    }
  }
  return result;
}

btVector3 weighted_point(const std::vector<Vec3d>& x, const std::uint32_t* vertices, const float* weights, int count) {
  Vec3d point{0, 0, 0};
  for (int i = 0; i < count; ++i) point = point + static_cast<double>(weights[i]) * x[vertices[i]];
  return to_bullet(point);
}

void RigidTouches::clear() {
  node_touches_.clear();
  face_touches_.clear();
}

void RigidTouches::add(btSoftBody& body, btSoftBody::Node& node, const RigidTouch& touch) {
  node_touches_.push_back({&body, &node, touch});
}

void RigidTouches::add(btSoftBody& body, btSoftBody::Face& face, const btVector3& weights, const RigidTouch& touch) {
  face_touches_.push_back({&body, &face, weights, touch});
}

void RigidTouches::prepare_to_write(bool keeps_notes) {
  keeps_notes_ = keeps_notes;
  if (keeps_notes) notes_.reset(node_touches_.size() + 3 * face_touches_.size());
}

void RigidTouches::write() {
  for (const auto& [body, node, touch] : node_touches_) {
    const int count = node_contact_count(*body);
    if (has_deformable_contacts(*body)) {
      write_deformable_rigid_contact(*body, *node, touch);
    } else {
      write_rigid_contact(*body, *node, touch);
    }
    note(*body, ContactArray::rigid_node, count, node_contact_count(*body), touch,
         depth(touch, node->m_x, touch.object_point_t1));
  }
  for (const auto& [body, face, weights, touch] : face_touches_) {
    const btScalar distance = depth(touch, point_on(*face, weights, &btSoftBody::Node::m_x), touch.object_point_t1);
    if (has_deformable_contacts(*body)) {
      const int count = body->m_faceRigidContacts.size();
      write_deformable_rigid_contact(*body, *face, weights, touch);
      note(*body, ContactArray::rigid_face, count, body->m_faceRigidContacts.size(), touch, distance);
    } else {
      const int count = body->m_rcontacts.size();
      write_rigid_contact(*body, *face, weights, touch);
      note(*body, ContactArray::rigid_node, count, body->m_rcontacts.size(), touch, distance);
    }
  }
  notes_.arrange();
}

/// Adds a note for each entry from `count_before` to `count`.
void RigidTouches::note(const btSoftBody& body, ContactArray array, int count_before, int count,
                        const RigidTouch& touch, btScalar distance) {
  if (!keeps_notes_) return;
  Contact contact;
  contact.time_of_impact = touch.time_of_impact;
  contact.distance = static_cast<float>(distance);
  for (int i = count_before; i < count; ++i) notes_.add({{&body, array, i}, nullptr, nullptr, contact});
}

}  // namespace softcd::bullet
