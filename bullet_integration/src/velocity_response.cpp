#include "velocity_response.hpp"

#include <utility>

#include "inverse_mass.hpp"
#include "vectors.hpp"

namespace softcd::bullet {
namespace {

constexpr int kMostSweeps = 10;
/// Sweeps end when no approach is faster than this share of the fastest.
constexpr btScalar kNegligibleApproach = btScalar(1e-3);

btScalar movability(const btSoftBody::Node& node) {
  return node.m_constrained != 0 ? btScalar(0) : node.m_im;
}

void apply_impulse(const Impact& impact, const btVector3& impulse) {
  for (int i = 0; i < 4; ++i) {
    btSoftBody::Node& node = *impact.nodes[i];
    node.m_v += impulse * (impact.weights[i] * movability(node));
  }
}

// Returns how fast the points approached each other. What an answer of nodes with small weights does not prevent the
// zones do.
btScalar make_inelastic(const Impact& impact) {
  btVector3 velocity(0, 0, 0);
  ContactInverseMass contact_inverse_mass;
  for (int i = 0; i < 4; ++i) {
    velocity += impact.nodes[i]->m_v * impact.weights[i];
    contact_inverse_mass.add(impact.weights[i], movability(*impact.nodes[i]));
  }
  const btScalar inverse_mass = contact_inverse_mass.value();
  const btScalar approach = -velocity.dot(impact.normal);
  if (!(approach > 0) || !(inverse_mass > 0)) return 0;

  const btVector3 tangential = velocity + impact.normal * approach;
  const btScalar sliding = tangential.safeNorm();
  btVector3 change = impact.normal * approach;
  if (sliding > SIMD_EPSILON) change -= tangential * btMin(impact.friction * approach / sliding, btScalar(1));
  apply_impulse(impact, change / inverse_mass);
  return approach;
}

}  // namespace

Impact impact_of(const MemberContact& found) {
  const Contact& contact = found.contact;
  const int count_a = contact.kind == ContactKind::vertex_triangle ? 1 : 2;
  Impact impact;
  impact.bodies[0] = found.a.body;
  impact.bodies[1] = found.b.body;
  for (int i = 0; i < 4; ++i) {
    btSoftBody& body = i < count_a ? *found.a.body : *found.b.body;
    impact.nodes[i] = &body.m_nodes[static_cast<int>(contact.vertices[i])];
    impact.weights[i] = btScalar(i < count_a ? contact.weights[i] : -contact.weights[i]);
  }
  impact.normal = to_bullet(contact.normal);
  impact.is_from_start = contact.time_of_impact <= 0;
  impact.friction = found.a.body->m_cfg.kDF * found.b.body->m_cfg.kDF;
  return impact;
}

void apply_inelastic_impulses(const std::vector<Impact>& impacts) {
  btScalar fastest = 0;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    btScalar fastest_now = 0;
    for (const Impact& impact : impacts) fastest_now = btMax(fastest_now, make_inelastic(impact));
    fastest = btMax(fastest, fastest_now);
    if (!(fastest_now > kNegligibleApproach * fastest)) return;
  }
}

ImpactZones::Node* ImpactZones::root_of(Node* node) {
  const auto [entry, is_new] = parents_.try_emplace(node, node);
  if (is_new) nodes_.push_back(node);
  Node* root = entry->second;
  while (parents_.at(root) != root) root = parents_.at(root);
  while (node != root) node = std::exchange(parents_.at(node), root);
  return root;
}

bool ImpactZones::join(const std::vector<Impact>& impacts) {
  bool has_joined = false;
  for (const Impact& impact : impacts) {
    Node* const root = root_of(impact.nodes[0]);
    for (Node* node : impact.nodes) {
      Node* const other = root_of(node);
      if (other == root) continue;
      parents_.at(other) = root;
      has_joined = true;
    }
  }
  return has_joined;
}

void ImpactZones::move_as_one() {
  average(&Node::m_v);
  average(&Node::m_splitv);
}

void ImpactZones::average(btVector3 Node::*velocity) {
  struct Motion {
    btVector3 momentum{0, 0, 0}, constrained{0, 0, 0}, fixed{0, 0, 0};
    btScalar mass = 0;
    int constrained_count = 0, fixed_count = 0;

    btVector3 velocity() const {
      if (fixed_count > 0) return fixed / btScalar(fixed_count);
      return constrained_count > 0 ? constrained / btScalar(constrained_count) : momentum / mass;
    }
  };
  std::unordered_map<const Node*, Motion> motions;
  for (Node* node : nodes_) {
    Motion& motion = motions[root_of(node)];
    if (!(node->m_im > 0)) {
      motion.fixed += node->*velocity;
      ++motion.fixed_count;
    } else if (node->m_constrained != 0) {
      motion.constrained += node->*velocity;
      ++motion.constrained_count;
    } else {
      motion.momentum += node->*velocity / node->m_im;
      motion.mass += 1 / node->m_im;
    }
  }
  for (Node* node : nodes_) {
    if (node->m_im > 0) node->*velocity = motions.at(root_of(node)).velocity();
  }
}

}  // namespace softcd::bullet
