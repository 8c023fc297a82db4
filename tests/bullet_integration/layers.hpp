#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "any_simulation.hpp"

namespace softcd::test {

/// The contacts of a step. `soft` has body, node and the other body's face; `rigid` has body and node that touches the
/// mesh. An entry that occurs twice is an error.
struct LayerContacts {
  std::multiset<std::array<int, 3>> soft;
  std::multiset<std::array<int, 2>> rigid;
};

/// Two sheets above each other that touch, the lower one on a rigid mesh of one triangle. Where they are, and not what
/// was before, decides about their contacts in a step. The upper one has a node more on each side than the lower one.
class Layers {
 public:
  explicit Layers(World world, const std::optional<bullet::Settings>& settings, int nodes_per_side = 5)
      : simulation_(world, settings) {
    triangles_.addTriangle(btVector3(-3, 0, -3), btVector3(0, 0, 6), btVector3(3, 0, -3));
    simulation_.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&triangles_, true), btVector3(0, 0, 0));
    SheetOptions options;
    options.nodes_per_side = nodes_per_side - 1;
    options.margin = btScalar(0.05);
    for (const btScalar height : {btScalar(0.04), btScalar(0.11)}) {
      options.height = height;
      ++options.nodes_per_side;
      bodies_.push_back(&simulation_.add(make_sheet(simulation_.world_info(), options)));
      for (int n = 0; n < bodies_.back()->m_nodes.size(); ++n) places_.push_back(bodies_.back()->m_nodes[n].m_x);
    }
  }

  /// A step that starts where the sheets were made, at rest or with this velocity of the upper sheet.
  void step(btScalar velocity = 0) {
    std::size_t place = 0;
    for (btSoftBody* body : bodies_) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        body->m_nodes[n].m_x = body->m_nodes[n].m_q = places_[place++];
        body->m_nodes[n].m_v = btVector3(0, body == bodies_.back() ? velocity : 0, 0);
      }
    }
    simulation_.step(kStep);
  }

  LayerContacts contacts() const {
    LayerContacts found;
    for (int b = 0; b < 2; ++b) {
      const btSoftBody& body = *bodies_[static_cast<std::size_t>(b)];
      const btSoftBody& other = *bodies_[static_cast<std::size_t>(1 - b)];
      const auto add = [&](const btSoftBody::Node* node, const btSoftBody::Face* face) {
        found.soft.insert({b, static_cast<int>(node - &body.m_nodes[0]), static_cast<int>(face - &other.m_faces[0])});
      };
      const auto add_rigid = [&](const btSoftBody::Node* node) {
        found.rigid.insert({b, static_cast<int>(node - &body.m_nodes[0])});
      };
      for (int i = 0; i < body.m_scontacts.size(); ++i) add(body.m_scontacts[i].m_node, body.m_scontacts[i].m_face);
      for (int i = 0; i < body.m_faceNodeContacts.size(); ++i) {
        add(body.m_faceNodeContacts[i].m_node, body.m_faceNodeContacts[i].m_face);
      }
      for (int i = 0; i < body.m_rcontacts.size(); ++i) add_rigid(body.m_rcontacts[i].m_node);
      for (int i = 0; i < body.m_nodeRigidContacts.size(); ++i) add_rigid(body.m_nodeRigidContacts[i].m_node);
    }
    return found;
  }
  /// Returns the height of each node, and its velocity upwards.
  std::vector<std::array<btScalar, 2>> motions() const {
    std::vector<std::array<btScalar, 2>> motions;
    for (const btSoftBody* body : bodies_) {
      for (int n = 0; n < body->m_nodes.size(); ++n) {
        motions.push_back({body->m_nodes[n].m_x.y(), body->m_nodes[n].m_v.y()});
      }
    }
    return motions;
  }
  /// One node of the upper sheet has no position.
  void spoil() { places_.back().setY(std::numeric_limits<btScalar>::quiet_NaN()); }

  /// Switches off Bullet's response to contacts, so that fast nodes pass through.
  void answer_nothing() {
    for (btSoftBody* body : bodies_) body->m_cfg.piterations = 0;
  }

  int index_of(const btCollisionObject* body) const {
    return static_cast<int>(std::find(bodies_.begin(), bodies_.end(), body) - bodies_.begin());
  }

  AnySimulation& simulation() { return simulation_; }
  const bullet::WorldDetection& detection() { return simulation_.detection(); }

 private:
  btTriangleMesh triangles_;
  AnySimulation simulation_;
  std::vector<btSoftBody*> bodies_;
  std::vector<btVector3> places_;
};

}  // namespace softcd::test
