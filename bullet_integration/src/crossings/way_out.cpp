#include "crossings/way_out.hpp"

#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "LinearMath/btTransformUtil.h"
#include "bodies/inverse_mass.hpp"

namespace softcd::bullet {
namespace {

/// A way changes what others have done, so that they are passed through several times.
constexpr int kSweeps = 4;

}  // namespace

void WayOut::RigidEnd::add(const btVector3& direction_at_point, const btVector3& arm,
                           const btVector3& motion_of_point) {
  direction += direction_at_point;
  turn += arm.cross(direction_at_point);
  reach = btMax(reach, arm.length());
  motion += direction_at_point.dot(motion_of_point);
}

void NodesOnWaysOut::hold_anchored(const btSoftBody& body) {
  if (!seen_.insert(&body).second) return;
  for (int a = 0; a < body.m_anchors.size(); ++a) anchored_.insert(body.m_anchors[a].m_node);
  for (int a = 0; a < body.m_deformableAnchors.size(); ++a) anchored_.insert(body.m_deformableAnchors[a].m_node);
}

NodesOnWaysOut::Rigid& NodesOnWaysOut::rigid_of(const btCollisionObject& object) {
  const auto [entry, is_new] = rigid_.try_emplace(&object);
  Rigid& rigid = entry->second;
  if (!is_new) return rigid;
  auto* const writable = const_cast<btCollisionObject*>(&object);
  rigid.is_in_world = objects_.findLinearSearch(writable) != objects_.size();
  if (!rigid.is_in_world || object.isStaticOrKinematicObject()) return rigid;
  rigid.body = btRigidBody::upcast(writable);
  return rigid;
}

/// Returns false if the app has removed a body or nodes since the way was found.
bool NodesOnWaysOut::look_up(const WayOut& way) {
  moved_.clear();
  response_ = {};
  for (const WayOut::End& end : way.ends) {
    const WorldMirror::Member* const member = mirror_.find(end.body);
    if (member == nullptr || end.node >= static_cast<std::uint32_t>(member->body->m_nodes.size())) return false;
    btSoftBody& body = *member->body;
    hold_anchored(body);
    btSoftBody::Node& node = member->node(end.node);
    const bool is_held = !body.isActive() || anchored_.count(&node) > 0;
    moved_.push_back({&body, &node, end.direction, node.*kind_.ends.start, is_held ? btScalar(0) : node.m_im});
  }
  if (way.rigid.object == nullptr) return true;
  Rigid& rigid = rigid_of(*way.rigid.object);
  if (rigid.body != nullptr) {
    response_.rigid = &rigid;
    response_.linear = rigid.body->getInvMass() * rigid.body->getLinearFactor() * way.rigid.direction;
    response_.angular = rigid.body->getInvInertiaTensorWorld() * way.rigid.turn * rigid.body->getAngularFactor();
  }
  return rigid.is_in_world;
}

void NodesOnWaysOut::move(const std::vector<WayOut>& ways, btScalar time_step) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (const WayOut& way : ways) {
      if (look_up(way)) move_along(way, time_step);
    }
  }
  place_rigid_bodies();
}

void NodesOnWaysOut::move_along(const WayOut& way, btScalar time_step) {
  const btScalar greatest_shift = way.speed * time_step;
  ContactInverseMass inverse_mass;
  btScalar gone = way.rigid.motion;
  btScalar speed = 0;
  btScalar most = 0;
  for (const Moved& moved : moved_) {
    const btScalar weight = moved.direction.length();
    inverse_mass.add(weight, moved.inverse_mass);
    most = btMax(most, weight * moved.inverse_mass);
    gone += moved.direction.dot(moved.node->*kind_.ends.end - moved.start);
    speed += moved.direction.dot(moved.node->m_v);
  }
  if (Rigid* const rigid = response_.rigid) {
    inverse_mass.add(1, way.rigid.direction.dot(response_.linear) + way.rigid.turn.dot(response_.angular));
    most = btMax(most, response_.linear.length() + response_.angular.length() * way.rigid.reach);
    gone += way.rigid.direction.dot(rigid->shift) + way.rigid.turn.dot(rigid->turn);
    speed += way.rigid.direction.dot(rigid->body->getLinearVelocity()) +
             way.rigid.turn.dot(rigid->body->getAngularVelocity());
  } else {
    speed += way.rigid.motion / time_step;
  }
  if (!(most > 0)) return;
  const btScalar goal = btMin(way.distance, greatest_shift * inverse_mass.value() / most);
  const btScalar impulse = btMax(btScalar(0), -speed) / inverse_mass.value();
  const btScalar push = (goal - gone) / inverse_mass.value() - impulse * time_step;
  const btScalar shift = btClamped(push, btScalar(0), greatest_shift / most);
  if (!(impulse > 0) && !(shift > 0)) return;
  for (const Moved& moved : moved_) {
    const btVector3 share = moved.direction * moved.inverse_mass;
    const btVector3 change = kind_.push(*moved.node, impulse * share, shift * share, time_step);
    if (notes_impulses_) note_impulse(way, moved, change);
  }
  if (Rigid* const rigid = response_.rigid) {
    rigid->body->setLinearVelocity(rigid->body->getLinearVelocity() + impulse * response_.linear);
    rigid->body->setAngularVelocity(rigid->body->getAngularVelocity() + impulse * response_.angular);
    rigid->shift += (impulse * time_step + shift) * response_.linear;
    rigid->turn += (impulse * time_step + shift) * response_.angular;
  }
}

/// Notes a change of a node's velocity as an impulse from the other object of the way, if there is another one.
void NodesOnWaysOut::note_impulse(const WayOut& way, const Moved& moved, const btVector3& change) {
  if (!(moved.inverse_mass > 0)) return;
  const btCollisionObject* other = way.rigid.object;
  for (const Moved& each : moved_) {
    if (each.body != moved.body) other = each.body;
  }
  if (other != nullptr) impulses_.push_back({moved.body, other, change / moved.inverse_mass});
}

/// Bullet has already moved rigid bodies in this step.
void NodesOnWaysOut::place_rigid_bodies() {
  for (auto& [object, rigid] : rigid_) {
    if (rigid.body == nullptr || (rigid.shift.isZero() && rigid.turn.isZero())) continue;
    btTransform moved;
    btTransformUtil::integrateTransform(rigid.body->getWorldTransform(), rigid.shift, rigid.turn, 1, moved);
    rigid.body->proceedToTransform(moved);
    rigid.body->activate(true);
  }
}

}  // namespace softcd::bullet
