#include "read_out/solver_replay.hpp"

#include <algorithm>
#include <unordered_map>

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"
#include "BulletSoftBody/btSoftBodyInternals.h"
#include "bodies/node_ends.hpp"
#include "read_out/one_by_one.hpp"

namespace softcd::bullet {
namespace {

using Node = btSoftBody::Node;
using Impulses = std::vector<ContactImpulses::Impulse>;

/// Restores everything that the solver changes when it is destroyed: nodes of soft bodies, and velocities of the
/// objects that they touch or are anchored to.
class StateKept {
 public:
  explicit StateKept(Span<btSoftBody* const> bodies) {
    for (btSoftBody* body : bodies) {
      for (const NodePosition member : kChanged) values_.push_back({body, member, values_of(*body, member)});
      for (const btSoftBody::RContact& contact : span_of(body->m_rcontacts)) keep(*contact.m_cti.m_colObj);
      for (const btSoftBody::Anchor& anchor : span_of(body->m_anchors)) keep(*anchor.m_body);
    }
  }
  ~StateKept() {
    for (const auto& [body, member, values] : values_) set_values(*body, member, values);
    for (const auto& [body, state] : rigid_) {
      body->setLinearVelocity(state.linear);
      body->setAngularVelocity(state.angular);
    }
    for (const auto& [body, velocities] : multibodies_) {
      std::copy(velocities.begin(), velocities.end(), const_cast<btScalar*>(body->getVelocityVector()));
    }
  }
  StateKept(const StateKept&) = delete;
  StateKept& operator=(const StateKept&) = delete;

 private:
  static constexpr NodePosition kChanged[] = {&Node::m_x, &Node::m_q, &Node::m_v, &Node::m_f};
  struct Values {
    btSoftBody* body;
    NodePosition member;
    std::vector<btVector3> values;
  };
  struct RigidState {
    btVector3 linear, angular;
  };

  void keep(const btCollisionObject& object) {
    if (auto* rigid = const_cast<btRigidBody*>(btRigidBody::upcast(&object))) {
      rigid_.try_emplace(rigid, RigidState{rigid->getLinearVelocity(), rigid->getAngularVelocity()});
    } else if (const auto* link = btMultiBodyLinkCollider::upcast(&object)) {
      const btScalar* velocities = link->m_multiBody->getVelocityVector();
      multibodies_.try_emplace(link->m_multiBody, velocities, velocities + link->m_multiBody->getNumDofs() + 6);
    }
  }

  std::vector<Values> values_;
  std::unordered_map<btRigidBody*, RigidState> rigid_;
  std::unordered_map<btMultiBody*, std::vector<btScalar>> multibodies_;
};

/// Solves one body as btSoftBody::solveConstraints does, without clusters.
class BodySolver {
 public:
  BodySolver(btSoftBody& body, Impulses& soft, Impulses& rigid) : body_(body), soft_(soft), rigid_(rigid) {
    soft_.assign(static_cast<std::size_t>(body.m_scontacts.size()), {});
    rigid_.assign(static_cast<std::size_t>(body.m_rcontacts.size()), {});
  }

  void run() {
    prepare();
    if (body_.m_cfg.viterations > 0) solve_velocities();
    if (body_.m_cfg.piterations > 0) solve_positions();
    if (body_.m_cfg.diterations > 0) solve_drift();
  }

 private:
  void prepare() {
    for (btSoftBody::Link& link : span_of(body_.m_links)) {
      link.m_c3 = link.m_n[1]->m_q - link.m_n[0]->m_q;
      link.m_c2 = 1 / (link.m_c3.length2() * link.m_c0);
    }
    for (btSoftBody::Anchor& anchor : span_of(body_.m_anchors)) {
      const btVector3 arm = anchor.m_body->getWorldTransform().getBasis() * anchor.m_local;
      anchor.m_c0 = ImpulseMatrix(body_.m_sst.sdt, anchor.m_node->m_im, anchor.m_body->getInvMass(),
                                  anchor.m_body->getInvInertiaTensorWorld(), arm);
      anchor.m_c1 = arm;
      anchor.m_c2 = body_.m_sst.sdt * anchor.m_node->m_im;
    }
  }

  void solve_velocities() {
    for (int round = 0; round < body_.m_cfg.viterations; ++round) {
      for (const btSoftBody::eVSolver::_ kind : span_of(body_.m_cfg.m_vsequence))
        btSoftBody::getSolver(kind)(&body_, 1);
    }
    for (Node& node : span_of(body_.m_nodes)) node.m_x = node.m_q + node.m_v * body_.m_sst.sdt;
  }

  void solve_positions() {
    for (int round = 0; round < body_.m_cfg.piterations; ++round) {
      const btScalar progress = btScalar(round) / btScalar(body_.m_cfg.piterations);
      for (const btSoftBody::ePSolver::_ kind : span_of(body_.m_cfg.m_psequence)) solve(kind, progress);
    }
    const btScalar factor = body_.m_sst.isdt * (1 - body_.m_cfg.kDP);
    for (Node& node : span_of(body_.m_nodes)) node.m_v = (node.m_x - node.m_q) * factor;
  }

  void solve_drift() {
    const btScalar factor = body_.m_cfg.kVCF * body_.m_sst.isdt;
    for (Node& node : span_of(body_.m_nodes)) node.m_q = node.m_x;
    for (int round = 0; round < body_.m_cfg.diterations; ++round) {
      for (const btSoftBody::ePSolver::_ kind : span_of(body_.m_cfg.m_dsequence)) solve(kind, 0);
    }
    for (Node& node : span_of(body_.m_nodes)) node.m_v += (node.m_x - node.m_q) * factor;
  }

  void solve(btSoftBody::ePSolver::_ kind, btScalar progress) {
    if (kind == btSoftBody::ePSolver::SContacts) {
      for (int i = 0; i < body_.m_scontacts.size(); ++i) solve_soft_contact(i, progress);
    } else if (kind == btSoftBody::ePSolver::RContacts) {
      solve_rigid_contacts(body_, progress, rigid_);
    } else {
      btSoftBody::getSolver(kind)(&body_, 1, progress);
    }
  }

  void solve_soft_contact(int i, btScalar progress) {
    with_single_entry(body_.m_scontacts, i, [&](const btSoftBody::SContact& contact) {
      soft_[static_cast<std::size_t>(i)] += measured_impulse(
          contact, &Node::m_x, body_.m_sst.isdt, [&] { btSoftBody::PSolve_SContacts(&body_, 1, progress); });
    });
  }

  btSoftBody& body_;
  Impulses& soft_;
  Impulses& rigid_;
};

bool are_positions(const btSoftBody& body, const std::vector<btVector3>& positions) {
  if (positions.size() != static_cast<std::size_t>(body.m_nodes.size())) return false;
  for (int i = 0; i < body.m_nodes.size(); ++i) {
    const btVector3& expected = positions[static_cast<std::size_t>(i)];
    for (int axis = 0; axis < 3; ++axis) {
      if (body.m_nodes[i].m_x[axis] != expected[axis]) return false;
    }
  }
  return true;
}

}  // namespace

void SolverReplay::run(Span<btSoftBody* const> bodies) {
  impulses_.clear();
  ends_.clear();
  const StateKept kept(bodies);
  for (btSoftBody* body : bodies) {
    if (!body->isActive()) continue;
    BodySolver(*body, impulses_.of(*body, ContactArray::soft), impulses_.of(*body, ContactArray::rigid_node)).run();
  }
  for (const btSoftBody* body : bodies) ends_.push_back({body, body, values_of(*body, &Node::m_x)});
}

void SolverReplay::confirm(Span<btSoftBody* const> bodies) {
  for (const Ends& ends : ends_) {
    const bool is_there = std::find(bodies.begin(), bodies.end(), ends.body) != bodies.end();
    if (!is_there || !are_positions(*ends.body, ends.positions)) impulses_.doubt(ends.object);
  }
  ends_.clear();
}

}  // namespace softcd::bullet
