#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h"
#include "BulletDynamics/Dynamics/btActionInterface.h"
#include "any_simulation.hpp"
#include "deformable_app_support.hpp"
#include "small_scenes.hpp"
#include "softcd/bullet/attach.hpp"

namespace softcd::test {

/// Worlds of Bullet's, with no settings.
inline const auto kBulletsWorlds = testing::Values(World::one_line, World::multi_body, World::deformable);

inline bullet::Settings reading(bullet::ReadOut read_out, Detection detection = Detection::dcd) {
  bullet::Settings settings = cpu_settings(detection);
  settings.read_out = read_out;
  return settings;
}

inline void append_vector(std::vector<btScalar>& values, const btVector3& vector) {
  values.insert(values.end(), {vector.x(), vector.y(), vector.z()});
}

/// Positions and velocities of all nodes.
inline std::vector<btScalar> states_in(AnySimulation& world) {
  std::vector<btScalar> states;
  for (int b = 0; b < world.bodies().size(); ++b) {
    for (int n = 0; n < world.bodies()[b]->m_nodes.size(); ++n) {
      append_vector(states, world.bodies()[b]->m_nodes[n].m_x);
      append_vector(states, world.bodies()[b]->m_nodes[n].m_v);
    }
  }
  return states;
}

/// Returns all data of contacts for Bullet's solver, in its order.
inline std::vector<btScalar> contacts_of(const btSoftBody& body, const btAlignedObjectArray<btSoftBody*>& bodies) {
  std::vector<btScalar> values;
  const auto add_soft = [&](const btSoftBody::Node* node, const btSoftBody::Face* face) {
    values.push_back(btScalar(node - &body.m_nodes[0]));
    for (int b = 0; b < bodies.size(); ++b) {
      const btSoftBody::tFaceArray& faces = bodies[b]->m_faces;
      if (faces.size() == 0 || face < &faces[0] || face > &faces[faces.size() - 1]) continue;
      values.insert(values.end(), {btScalar(b), btScalar(face - &faces[0])});
    }
  };
  for (int i = 0; i < body.m_scontacts.size(); ++i) {
    const btSoftBody::SContact& contact = body.m_scontacts[i];
    add_soft(contact.m_node, contact.m_face);
    append_vector(values, contact.m_weights);
    append_vector(values, contact.m_normal);
    values.insert(values.end(), {contact.m_margin, contact.m_friction, contact.m_cfm[0], contact.m_cfm[1]});
  }
  for (int i = 0; i < body.m_faceNodeContacts.size(); ++i) {
    const btSoftBody::DeformableFaceNodeContact& contact = body.m_faceNodeContacts[i];
    add_soft(contact.m_node, contact.m_face);
    append_vector(values, contact.m_bary);
    append_vector(values, contact.m_normal);
    values.insert(values.end(), {contact.m_margin, contact.m_friction});
  }
  const auto add_rigid = [&](const btSoftBody::Node* node, const btSoftBody::sCti& contact) {
    values.push_back(btScalar(node - &body.m_nodes[0]));
    append_vector(values, contact.m_normal);
    values.push_back(contact.m_offset);
  };
  for (int i = 0; i < body.m_rcontacts.size(); ++i) add_rigid(body.m_rcontacts[i].m_node, body.m_rcontacts[i].m_cti);
  for (int i = 0; i < body.m_nodeRigidContacts.size(); ++i) {
    add_rigid(body.m_nodeRigidContacts[i].m_node, body.m_nodeRigidContacts[i].m_cti);
  }
  return values;
}

inline std::vector<btScalar> contacts_in(AnySimulation& world) {
  std::vector<btScalar> values;
  for (int b = 0; b < world.bodies().size(); ++b) append(values, contacts_of(*world.bodies()[b], world.bodies()));
  return values;
}
/// A held sheet and a free one within its reach, where Bullet's classic solver leaves it, or above it.
struct Sheets {
  AnySimulation simulation;
  btSoftBody* held;
  btSoftBody* free;

  explicit Sheets(World world, btScalar height = btScalar(0.08), const MaybeSettings& of_softcds_own = std::nullopt)
      : simulation(world, of_softcds_own) {
    SheetOptions options;
    options.nodes_per_side = 4;
    options.fixed = true;
    held = &simulation.add(make_sheet(simulation.world_info(), options));
    options.fixed = false;
    options.nodes_per_side = 5;
    options.side = btScalar(0.7);
    options.height = height;
    free = &simulation.add(make_sheet(simulation.world_info(), options));
    for (btSoftBody* body : {held, free}) body->m_cfg.piterations = 0;
    if (!is_deformable(world)) simulation.world_info().m_gravity.setZero();
  }
  btDiscreteDynamicsWorld& world() { return simulation.world(); }
  void step() { simulation.step_once(); }
};

inline std::uint64_t found_by(const bullet::Attachment& attachment) {
  return attachment.detection().contact_report().statistics().vt_contacts;
}

inline std::uint64_t failed_steps_of(const bullet::Attachment& attachment) {
  return attachment.detection().contact_report().failed_steps();
}

/// An app's action.
struct Action : btActionInterface {
  std::function<void()> on_update;
  void updateAction(btCollisionWorld*, btScalar) override { on_update(); }
  void debugDraw(btIDebugDraw*) override {}
};

}  // namespace softcd::test
