#include "crossings/velocity_response.hpp"

#include "bodies/inverse_mass.hpp"
#include "bodies/vectors.hpp"

namespace softcd::bullet {
namespace {

constexpr int kMostSweeps = 10;
/// Sweeps end when no approach is faster than this share of the fastest.
constexpr btScalar kNegligibleApproach = btScalar(1e-3);

/// Returns the part of a unit vector along which an impulse can move the node. Rounding errors in this part depend on
/// the direction. So each impulse is reduced to its free part before impulses are added; otherwise they would move
/// nodes that were not counted.
btVector3 free_part(const Impact& impact, int node, const btVector3& direction) {
  const NodeConstraint* constraint = impact.constraints[node];
  return constraint == nullptr ? direction : constraint->free_part(direction);
}

/// The motion of the first point relative to the second, along a unit vector.
struct RelativeMotion {
  btScalar speed;
  btScalar inverse_mass;
};

/// The rigid body of an impact whose velocity impulses change, and the place of the impact on it.
class PushedBody {
 public:
  PushedBody(const Impact& impact, RigidResponse response)
      : body_(response == RigidResponse::impulses ? impact.rigid : nullptr), sign_(impact.rigid_sign) {
    if (body_ == nullptr) return;
    for (int i = 0; i < 4; ++i) {
      if (is_of_body(impact.weights[i])) place_ += sign_ * impact.weights[i] * impact.nodes[i]->m_x;
    }
  }

  /// Returns the velocity of one of the impact's nodes.
  btVector3 velocity(const Impact& impact, int node) const {
    const btSoftBody::Node& of = *impact.nodes[node];
    return is_of_body(impact.weights[node]) ? body_->getVelocityInLocalPoint(of.m_x - origin()) : of.m_v;
  }
  btScalar inverse_mass(const btVector3& direction) const {
    return body_ == nullptr ? btScalar(0) : body_->computeImpulseDenominator(place_, direction);
  }
  /// Applies an impulse to the first point of the impact, and its opposite to the second.
  void push(const btVector3& impulse) const {
    if (body_ == nullptr) return;
    body_->activate();
    body_->applyImpulse(sign_ * impulse, place_ - origin());
  }

 private:
  /// The nodes of the first point have weights of at least 0, those of the second of at most 0.
  bool is_of_body(btScalar weight) const { return body_ != nullptr && sign_ * weight > 0; }
  const btVector3& origin() const { return body_->getCenterOfMassPosition(); }

  btRigidBody* body_;
  btScalar sign_;
  btVector3 place_{0, 0, 0};
};

/// Leaves out motion in the directions of contacts with rigid objects: an impulse in other directions that compensates
/// it would add energy. Massless and anchored nodes count with their whole motion, since the app or the anchor moves
/// them. A node that can move along a small part of the direction counts with that part of its weight, so that it is
/// not thrown.
RelativeMotion motion_along(const Impact& impact, const PushedBody& pushed, const btVector3& direction) {
  btScalar speed = 0;
  ContactInverseMass inverse_mass;
  for (int i = 0; i < 4; ++i) {
    const NodeConstraint* constraint = impact.constraints[i];
    const bool is_in_contact = constraint != nullptr && !constraint->is_anchored();
    const btVector3 moving = free_part(impact, i, direction);
    speed += impact.weights[i] * (is_in_contact ? moving : direction).dot(pushed.velocity(impact, i));
    const btScalar free_share = moving.length();
    if (free_share > 0) inverse_mass.add(impact.weights[i] * free_share, impact.nodes[i]->m_im);
  }
  return {speed, inverse_mass.value() + pushed.inverse_mass(direction)};
}

// Returns the speed at which the points approached each other. If nodes with small weights cannot stop the approach,
// the zones do.
btScalar make_inelastic(const Impact& impact, RigidResponse rigid) {
  const PushedBody pushed(impact, rigid);
  btVector3 velocity(0, 0, 0);
  for (int i = 0; i < 4; ++i) velocity += pushed.velocity(impact, i) * impact.weights[i];
  const RelativeMotion normal = motion_along(impact, pushed, impact.normal);
  const btScalar approach = btMin(-velocity.dot(impact.normal), -normal.speed);
  if (!(approach > 0) || !(normal.inverse_mass > 0)) return 0;

  const btScalar push = approach / normal.inverse_mass;
  const btVector3 tangential = velocity - impact.normal * velocity.dot(impact.normal);
  const btScalar sliding = tangential.safeNorm();
  btVector3 direction(0, 0, 0);
  btScalar drag = 0;
  if (sliding > SIMD_EPSILON) {
    direction = tangential / sliding;
    const RelativeMotion along = motion_along(impact, pushed, direction);
    if (along.speed > 0 && along.inverse_mass > 0) {
      drag = btMin(impact.friction * push, btMin(sliding, along.speed) / along.inverse_mass);
    }
  }
  for (int i = 0; i < 4; ++i) {
    btSoftBody::Node& node = *impact.nodes[i];
    const btVector3 impulse = push * free_part(impact, i, impact.normal) - drag * free_part(impact, i, direction);
    node.m_v += node.m_im * impact.weights[i] * impulse;
  }
  pushed.push(push * impact.normal - drag * direction);
  return approach;
}

}  // namespace

Impact impact_of(const MemberContact& found) {
  const Contact& contact = found.contact;
  Impact impact;
  impact.contact = contact;
  impact.bodies[0] = found.a.body;
  impact.bodies[1] = found.b.body;
  for (int i = 0; i < 4; ++i) {
    impact.nodes[i] = &found.node(i);
    impact.weights[i] = btScalar(found.is_of_a(i) ? contact.weights[i] : -contact.weights[i]);
  }
  impact.normal = to_bullet(contact.normal);
  impact.friction = found.a.body->m_cfg.kDF * found.b.body->m_cfg.kDF;
  return impact;
}

void apply_inelastic_impulses(const std::vector<Impact>& impacts, RigidResponse rigid) {
  btScalar fastest = 0;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    btScalar fastest_now = 0;
    for (const Impact& impact : impacts) fastest_now = btMax(fastest_now, make_inelastic(impact, rigid));
    fastest = btMax(fastest, fastest_now);
    if (!(fastest_now > kNegligibleApproach * fastest)) return;
  }
}

bool set_apart(const std::vector<Impact>& impacts, btVector3 btSoftBody::Node::*velocity, btScalar share,
               btScalar time_step) {
  bool has_moved = false;
  for (const Impact& impact : impacts) {
    const PushedBody none(impact, RigidResponse::none);
    const btScalar inverse_mass = motion_along(impact, none, impact.normal).inverse_mass;
    if (impact.contact.time_of_impact <= 0 || !(inverse_mass > 0)) continue;
    btScalar extent = 0;
    for (const btSoftBody::Node* node : impact.nodes) {
      const btVector3 x = node->m_x.absolute();
      extent = btMax(extent, x[x.maxAxis()]);
    }
    const btScalar push = share * extent / (time_step * inverse_mass);
    for (int i = 0; i < 4; ++i) {
      btSoftBody::Node& node = *impact.nodes[i];
      node.*velocity += node.m_im * impact.weights[i] * push * free_part(impact, i, impact.normal);
    }
    has_moved = true;
  }
  return has_moved;
}

}  // namespace softcd::bullet
