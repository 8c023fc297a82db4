#include "read_out/deformable_impulses.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

#include "BulletSoftBody/btDeformableBodySolver.h"
#include "bodies/body_mesh.hpp"
#include "contacts/soft_response.hpp"
#include "read_out/one_by_one.hpp"

namespace softcd::bullet {
namespace {

using Impulses = std::vector<ContactImpulses::Impulse>;
using Node = btSoftBody::Node;

/// Calls visit(node, change of its velocity by the constraint's impulses) for each node with mass.
template <class Visit>
void for_each_node(const btDeformableNodeRigidContactConstraint& constraint, Visit visit) {
  const Node& node = *constraint.getContact()->m_node;
  if (node.m_im > 0) visit(node, constraint.m_total_normal_dv + constraint.m_total_tangent_dv);
}
template <class Visit>
void for_each_node(const btDeformableFaceRigidContactConstraint& constraint, Visit visit) {
  const btVector3 change = constraint.m_total_normal_dv + constraint.m_total_tangent_dv;
  for (int i = 0; i < 3; ++i) {
    const Node& node = *constraint.getContact()->m_face->m_n[i];
    if (node.m_im > 0) visit(node, change * constraint.getContact()->m_weights[i]);
  }
}

/// The constraints that the last solve made for a body's contacts with rigid objects.
struct RigidConstraints {
  const btAlignedObjectArray<btDeformableNodeRigidContactConstraint>& of_nodes;
  const btAlignedObjectArray<btDeformableFaceRigidContactConstraint>& of_faces;
};

/// Returns whether the constraints belong to these contacts. They may belong to a deleted body whose address a new body
/// has.
template <class Entry, class Constraint>
bool are_about(const btAlignedObjectArray<Constraint>& constraints, const btAlignedObjectArray<Entry>& entries) {
  if (constraints.size() == 0) return true;
  if (entries.size() == 0) return false;
  const std::less<> is_before;
  const Entry* const first = constraints[0].getContact();
  return !is_before(first, &entries[0]) && is_before(first, &entries[0] + entries.size());
}

/// Returns none for a body that was added after the solve. The solver numbers bodies as they were then.
std::optional<RigidConstraints> rigid_constraints_of(const btSoftBody& body, const btDeformableBodySolver& solver,
                                                     std::size_t likely_place) {
  const btDeformableContactProjection& kept = solver.m_objective->m_projection;
  int place = static_cast<int>(likely_place);
  if (place >= kept.m_softBodies.size() || kept.m_softBodies[place] != &body) {
    place = kept.m_softBodies.findLinearSearch(const_cast<btSoftBody*>(&body));
  }
  if (place >= kept.m_softBodies.size()) return {};
  const RigidConstraints constraints = {kept.m_nodeRigidConstraints[place], kept.m_faceRigidConstraints[place]};
  const bool are_its = are_about(constraints.of_nodes, body.m_nodeRigidContacts) &&
                       are_about(constraints.of_faces, body.m_faceRigidContacts);
  return are_its ? std::optional(constraints) : std::nullopt;
}

/// Computes impulses from constraints. A constraint stores the change of the soft body's velocity at the contact by its
/// impulses (m_total_normal_dv and m_total_tangent_dv); m_c5 is the inverse mass there. Bullet's weights give a face
/// less than that.
template <class Entry, class Constraint>
void read_constraints(const btAlignedObjectArray<Entry>& entries, const btAlignedObjectArray<Constraint>& constraints,
                      Impulses& impulses) {
  impulses.assign(static_cast<std::size_t>(entries.size()), {});
  for (const Constraint& constraint : span_of(constraints)) {
    const Entry* entry = constraint.getContact();
    ContactImpulses::Impulse& impulse = impulses[static_cast<std::size_t>(entry - &entries[0])];
    for_each_node(constraint,
                  [&](const Node& node, const btVector3& change) { impulse.on_owner += change / node.m_im; });
    impulse.on_other = -(entry->m_c5.inverse() * (constraint.m_total_normal_dv + constraint.m_total_tangent_dv));
  }
}

/// The impulse on a node that its contacts' constraints do not explain, and the number of these contacts.
struct Reaction {
  btVector3 rest{0, 0, 0};
  int contact_count = 0;
};
using Reactions = std::unordered_map<const Node*, Reaction>;

template <class Constraint>
void take_from_rests(const btAlignedObjectArray<Constraint>& constraints, Reactions& reactions) {
  for (const Constraint& constraint : span_of(constraints)) {
    for_each_node(constraint, [&](const Node& node, const btVector3& change) {
      Reaction& reaction = reactions[&node];
      reaction.rest -= change / node.m_im;
      ++reaction.contact_count;
    });
  }
}

/// Divides a node's unexplained impulse equally among its contacts.
template <class Entry, class Constraint>
void add_rests(const btAlignedObjectArray<Entry>& entries, const btAlignedObjectArray<Constraint>& constraints,
               const Reactions& reactions, Impulses& impulses) {
  for (const Constraint& constraint : span_of(constraints)) {
    ContactImpulses::Impulse& impulse = impulses[static_cast<std::size_t>(constraint.getContact() - &entries[0])];
    for_each_node(constraint, [&](const Node& node, const btVector3& /*change*/) {
      const Reaction& reaction = reactions.at(&node);
      impulse.on_owner += reaction.rest / btScalar(reaction.contact_count);
    });
  }
}

template <class Entry>
void oppose_immovable(const btAlignedObjectArray<Entry>& entries, Impulses& impulses) {
  for (int i = 0; i < entries.size(); ++i) {
    ContactImpulses::Impulse& impulse = impulses[static_cast<std::size_t>(i)];
    if (!is_moved_by_impulses(*entries[i].m_cti.m_colObj)) impulse.on_other = -impulse.on_owner;
  }
}

/// Returns whether no body was added or removed since the solve.
bool has_these(const btDeformableBodySolver& solver, Span<btSoftBody* const> bodies) {
  const Span<btSoftBody* const> solved = span_of(solver.m_objective->m_projection.m_softBodies);
  return std::equal(bodies.begin(), bodies.end(), solved.begin(), solved.end());
}

/// Returns the impulses on the nodes of the damping within the bodies, in a step of the explicit solver. That solver's
/// velocities include those of split impulses.
btAlignedObjectArray<btVector3> damping_impulses(btDeformableBodySolver& solver, Span<btSoftBody* const> bodies,
                                                 btScalar time_step) {
  btAlignedObjectArray<btVector3> impulses;
  impulses.resize(solver.m_objective->m_nodes.size(), btVector3(0, 0, 0));
  const auto for_each = [&](auto change) {
    for (btSoftBody* body : bodies) {
      for (Node& node : span_of(body->m_nodes)) change(node);
    }
  };
  std::vector<btVector3> velocities;
  for_each([&](const Node& node) { velocities.push_back(node.m_v); });
  for_each([](Node& node) { node.m_v += node.m_splitv; });
  solver.m_objective->computeResidual(time_step, impulses);
  auto next = velocities.begin();
  for_each([&](Node& node) { node.m_v = *next++; });
  return impulses;
}

/// Counts what rigid bodies give a contact's nodes as impulses of their own contacts with these.
class BackingReader final : public BackedNodes::Reader {
 public:
  BackingReader(ContactImpulses& impulses, const btSoftBody::DeformableFaceNodeContact& contact,
                ContactImpulses::Impulse& of_contact)
      : impulses_(impulses), contact_(contact), of_contact_(of_contact) {}

  void read(const ContactSource& contact, const Node& node, const btVector3& on_node) override {
    (&node == contact_.m_node ? of_contact_.on_owner : of_contact_.on_other) -= on_node;
    Impulses* const impulses = impulses_.find(*contact.owner, contact.array);
    if (impulses != nullptr) (*impulses)[static_cast<std::size_t>(contact.first)] += {on_node, -on_node};
  }

 private:
  ContactImpulses& impulses_;
  const btSoftBody::DeformableFaceNodeContact& contact_;
  ContactImpulses::Impulse& of_contact_;
};

}  // namespace

void DeformableImpulses::keep_velocities(Span<btSoftBody* const> bodies) {
  velocities_.clear();
  for (const btSoftBody* body : bodies) velocities_[body] = values_of(*body, &Node::m_v);
}

void DeformableImpulses::read_rigid(Span<btSoftBody* const> bodies, btScalar time_step) {
  impulses_.clear();
  btDeformableBodySolver* explicit_solver = nullptr;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const btSoftBody& body = *bodies[i];
    auto* solver = dynamic_cast<btDeformableBodySolver*>(body.getSoftBodySolver());
    if (!body.isActive() || solver == nullptr || solver->isReducedSolver()) continue;
    const std::optional<RigidConstraints> constraints = rigid_constraints_of(body, *solver, i);
    if (!constraints.has_value()) continue;
    read_constraints(body.m_nodeRigidContacts, constraints->of_nodes, impulses_.of(body, ContactArray::rigid_node));
    read_constraints(body.m_faceRigidContacts, constraints->of_faces, impulses_.of(body, ContactArray::rigid_face));
    if (!solver->m_objective->m_implicit) explicit_solver = solver;
  }
  if (explicit_solver != nullptr && time_step > 0 && has_these(*explicit_solver, bodies)) {
    add_reactions(*explicit_solver, bodies, time_step);
  }
  for (const btSoftBody* body : bodies) {
    if (impulses_.find(*body, ContactArray::rigid_node) == nullptr) continue;
    oppose_immovable(body->m_nodeRigidContacts, impulses_.of(*body, ContactArray::rigid_node));
    oppose_immovable(body->m_faceRigidContacts, impulses_.of(*body, ContactArray::rigid_face));
  }
}

/// Adds the impulses that constraints do not explain to the contacts of each node. Nodes on anchors are left out,
/// because their anchors give these impulses.
void DeformableImpulses::add_reactions(btDeformableBodySolver& solver, Span<btSoftBody* const> bodies,
                                       btScalar time_step) {
  const btAlignedObjectArray<btVector3> damping = damping_impulses(solver, bodies, time_step);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const btSoftBody& body = *bodies[i];
    const auto velocities = velocities_.find(&body);
    if (!body.isActive() || velocities == velocities_.end()) continue;
    if (velocities->second.size() != static_cast<std::size_t>(body.m_nodes.size())) continue;  // the app added nodes
    const std::optional<RigidConstraints> constraints = rigid_constraints_of(body, solver, i);
    if (!constraints.has_value()) continue;
    Reactions reactions;
    take_from_rests(constraints->of_nodes, reactions);
    take_from_rests(constraints->of_faces, reactions);
    for (auto& [node, reaction] : reactions) {
      const auto index = static_cast<std::size_t>(node - &body.m_nodes[0]);
      reaction.rest += (node->m_v - velocities->second[index]) / node->m_im - damping[node->index];
      if (node->m_battach != 0) reaction.rest.setZero();
    }
    add_rests(body.m_nodeRigidContacts, constraints->of_nodes, reactions, impulses_.of(body, ContactArray::rigid_node));
    add_rests(body.m_faceRigidContacts, constraints->of_faces, reactions, impulses_.of(body, ContactArray::rigid_face));
  }
}

void DeformableImpulses::prepare(Span<btSoftBody* const> bodies, btScalar time_step) {
  read_rigid(bodies, time_step);
  order_.clear();
  for (const btSoftBody* body : bodies) {
    if (!body->isActive()) continue;
    const int count = body->m_faceNodeContacts.size();
    impulses_.of(*body, ContactArray::soft).assign(static_cast<std::size_t>(count), {});
    append_shuffled(count, random_, order_);
  }
}

void DeformableImpulses::apply_repulsion(Span<btSoftBody* const> bodies, btScalar time_step,
                                         const BackedNodes& backed) {
  respond_to_soft_contacts(bodies, time_step, [&](bool with_springs) {
    auto next = order_.begin();
    for (btSoftBody* body : bodies) {
      if (!body->isActive()) continue;
      std::vector<ContactImpulses::Impulse>& impulses = impulses_.of(*body, ContactArray::soft);
      for (std::size_t answered = 0; answered < impulses.size(); ++answered) {
        const int i = *next++;
        with_single_entry(body->m_faceNodeContacts, i, [&](const btSoftBody::DeformableFaceNodeContact& contact) {
          ContactImpulses::Impulse& impulse = impulses[static_cast<std::size_t>(i)];
          BackingReader reader(impulses_, contact, impulse);
          impulse += measured_impulse(contact, &Node::m_v, 1,
                                      [&] { backed.respond_to_only(*body, time_step, with_springs, &reader); });
        });
      }
    }
  });
}

}  // namespace softcd::bullet
