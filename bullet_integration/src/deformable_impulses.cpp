#include "deformable_impulses.hpp"

#include <numeric>
#include <utility>

#include "BulletSoftBody/btDeformableBodySolver.h"
#include "one_by_one.hpp"

namespace softcd::bullet {
namespace {

/// A constraint keeps by what its impulses have changed the velocity of the soft body at the contact (m_total_normal_dv
/// and m_total_tangent_dv); m_c5 is the inverse mass there.
template <class Entry, class Constraint>
void read_constraints(const btAlignedObjectArray<Entry>& entries, const btAlignedObjectArray<Constraint>& constraints,
                      std::vector<ContactImpulses::Impulse>& impulses) {
  impulses.assign(static_cast<std::size_t>(entries.size()), {});
  for (int i = 0; i < constraints.size(); ++i) {
    const Constraint& constraint = constraints[i];
    const Entry* entry = constraint.getContact();
    ContactImpulses::Impulse& impulse = impulses[static_cast<std::size_t>(entry - &entries[0])];
    impulse.on_owner = entry->m_c5.inverse() * (constraint.m_total_normal_dv + constraint.m_total_tangent_dv);
    impulse.on_other = -impulse.on_owner;
  }
}

/// Appends 0 to count - 1, shuffled in Bullet's way.
void append_shuffled(int count, std::minstd_rand& random, std::vector<int>& order) {
  const auto first = static_cast<std::ptrdiff_t>(order.size());
  order.resize(order.size() + static_cast<std::size_t>(count));
  const Span<int> places(order.data() + first, static_cast<std::size_t>(count));
  std::iota(places.begin(), places.end(), 0);
  for (int& place : places) std::swap(place, places[random() % places.size()]);
}

}  // namespace

void DeformableImpulses::read_rigid(Span<btSoftBody* const> bodies) {
  impulses_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const btSoftBody& body = *bodies[i];
    auto* solver = dynamic_cast<btDeformableBodySolver*>(body.getSoftBodySolver());
    if (!body.isActive() || solver == nullptr || solver->isReducedSolver()) continue;
    const btDeformableContactProjection& kept = solver->m_objective->m_projection;
    const int place = static_cast<int>(i);
    read_constraints(body.m_nodeRigidContacts, kept.m_nodeRigidConstraints[place],
                     impulses_.of(body, ContactArray::rigid_node));
    read_constraints(body.m_faceRigidContacts, kept.m_faceRigidConstraints[place],
                     impulses_.of(body, ContactArray::rigid_face));
  }
}

void DeformableImpulses::prepare(Span<btSoftBody* const> bodies) {
  read_rigid(bodies);
  order_.clear();
  for (const btSoftBody* body : bodies) {
    if (!body->isActive()) continue;
    const int count = body->m_faceNodeContacts.size();
    impulses_.of(*body, ContactArray::soft).assign(static_cast<std::size_t>(count), {});
    append_shuffled(count, random_, order_);
  }
}

void DeformableImpulses::apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step) {
  auto next = order_.begin();
  for (btSoftBody* body : bodies) {
    if (!body->isActive()) continue;
    std::vector<ContactImpulses::Impulse>& impulses = impulses_.of(*body, ContactArray::soft);
    for (std::size_t answered = 0; answered < impulses.size(); ++answered) {
      const int i = *next++;
      with_single_entry(body->m_faceNodeContacts, i, [&](const btSoftBody::DeformableFaceNodeContact& contact) {
        impulses[static_cast<std::size_t>(i)] =
            measured_impulse(contact, &btSoftBody::Node::m_v, 1, [&] { body->applyRepulsionForce(time_step, true); });
      });
    }
  }
}

}  // namespace softcd::bullet
