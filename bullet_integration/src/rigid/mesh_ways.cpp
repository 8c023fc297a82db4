#include "rigid/mesh_ways.hpp"

#include <utility>

#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "LinearMath/btTransformUtil.h"
#include "rigid/rigid_pairs.hpp"

namespace softcd::bullet {
namespace {

bool has_meshes(const btCollisionObject& object) {
  const auto is_mesh = [](const btCollisionShape& shape, const btTransform& /*place*/) {
    return is_triangle_mesh(shape);
  };
  const btCollisionShape* const shape = object.getCollisionShape();
  return shape != nullptr && any_simple_shape(*shape, btTransform::getIdentity(), is_mesh);
}

bool is_moving(const btCollisionObject& object) {
  return !object.getInterpolationLinearVelocity().isZero() || !object.getInterpolationAngularVelocity().isZero();
}

bool has_jumped(const btCollisionShape& shape, const btTransform& from, const btTransform& to) {
  btVector3 center;
  btScalar radius = 0;
  shape.getBoundingSphere(center, radius);
  return (to * center).distance(from * center) > 2 * radius;
}

void set_velocity(btRigidBody& body, const btVector3& linear, const btVector3& angular) {
  body.setLinearVelocity(linear);
  body.setAngularVelocity(angular);
}

void set_interpolation_velocity(btRigidBody& body, const btVector3& linear, const btVector3& angular) {
  body.setInterpolationLinearVelocity(linear);
  body.setInterpolationAngularVelocity(angular);
}

void add_ways(btCollisionObject& object, const btTransform& start, std::vector<MeshWay>& ways) {
  const RigidPoses poses = {start, object.getWorldTransform()};
  int child = 0;
  const auto add = [&](const btCollisionShape& shape, const btTransform& place) {
    if (!is_triangle_mesh(shape)) return false;
    const RigidPoses of_shape = {poses.t0 * place, poses.t1 * place};
    Bounds box = bounds_of(shape, of_shape.t0);
    box.add(bounds_of(shape, of_shape.t1));
    ways.push_back({&object, static_cast<const btConcaveShape*>(&shape), child++, of_shape, box, start});
    return false;
  };
  any_simple_shape(*object.getCollisionShape(), btTransform::getIdentity(), add);
}

}  // namespace

btTransform MeshWays::start_of(const btCollisionObject& object, btScalar time_step) const {
  const btTransform& now = object.getWorldTransform();
  if (!object.isKinematicObject()) return now;
  const auto known = tracks_.find(BodyKey(object));
  if (known == tracks_.end()) {
    return is_moving(object) ? poses_of(object, btTransform::getIdentity(), time_step).t0 : now;
  }
  const btTransform& last = known->second.last;
  return is_moving(object) || !has_jumped(*object.getCollisionShape(), last, now) ? last : now;
}

/// Sets velocities as btRigidBody::saveKinematicState does for bodies that are awake.
void MeshWays::lend_velocity(btCollisionObject& object, const btTransform& start, btScalar time_step) {
  btRigidBody* body = btRigidBody::upcast(&object);
  if (body == nullptr || start == object.getWorldTransform() || !(time_step > 0)) return;
  lent_.push_back({body, body->getLinearVelocity(), body->getAngularVelocity()});
  btVector3 linear;
  btVector3 angular;
  btTransformUtil::calculateVelocity(start, object.getWorldTransform(), time_step, linear, angular);
  set_velocity(*body, linear, angular);
  set_interpolation_velocity(*body, linear, angular);
}

void MeshWays::take_velocities_back(const btCollisionObjectArray& objects) {
  const btVector3 none(0, 0, 0);
  for (const Lent& lent : lent_) {
    if (objects.findLinearSearch(lent.body) == objects.size()) continue;
    set_velocity(*lent.body, lent.linear, lent.angular);
    set_interpolation_velocity(*lent.body, none, none);
  }
  lent_.clear();
}

void MeshWays::keep_starts(const btCollisionObjectArray& objects, btScalar time_step) {
  take_velocities_back(objects);
  decltype(tracks_) tracks;
  for (btCollisionObject* object : span_of(objects)) {
    if (is_standing(*object) || !has_meshes(*object)) continue;
    const btTransform start = start_of(*object, time_step);
    tracks.emplace(BodyKey(*object), Track{start, object->getWorldTransform()});
    if (object->isKinematicObject() && !is_moving(*object)) lend_velocity(*object, start, time_step);
  }
  tracks_ = std::move(tracks);
}

std::vector<MeshWay> MeshWays::find(const btCollisionObjectArray& objects) {
  take_velocities_back(objects);
  std::vector<MeshWay> ways;
  for (btCollisionObject* object : span_of(objects)) {
    if (!has_meshes(*object)) continue;
    const btTransform& end = object->getWorldTransform();
    const auto track = tracks_.find(BodyKey(*object));
    add_ways(*object, track != tracks_.end() ? track->second.start : end, ways);
    if (track != tracks_.end()) track->second.last = end;
  }
  return ways;
}

}  // namespace softcd::bullet
