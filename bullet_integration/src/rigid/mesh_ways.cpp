#include "rigid/mesh_ways.hpp"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "LinearMath/btTransformUtil.h"
#include "rigid/rigid_pairs.hpp"

namespace softcd::bullet {
namespace {

bool has_meshes(const btCollisionShape& shape) {
  if (!shape.isCompound()) return is_triangle_mesh(shape);
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    if (has_meshes(*compound.getChildShape(i))) return true;
  }
  return false;
}

bool has_meshes(const btCollisionObject& object) {
  return object.getCollisionShape() != nullptr && has_meshes(*object.getCollisionShape());
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

RigidBox box_of(const btCollisionShape& shape, const RigidPoses& poses) {
  RigidBox box;
  RigidBox end;
  shape.getAabb(poses.t0, box.low, box.high);
  shape.getAabb(poses.t1, end.low, end.high);
  box.low.setMin(end.low);
  box.high.setMax(end.high);
  return box;
}

void add_ways(btCollisionObject& object, const btCollisionShape& shape, const RigidPoses& poses, int& child,
              std::vector<MeshWay>& ways) {
  if (shape.isCompound()) {
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i) {
      const btTransform& place = compound.getChildTransform(i);
      add_ways(object, *compound.getChildShape(i), {poses.t0 * place, poses.t1 * place}, child, ways);
    }
  } else if (is_triangle_mesh(shape)) {
    ways.push_back({&object, static_cast<const btConcaveShape*>(&shape), child++, poses, box_of(shape, poses)});
  }
}

}  // namespace

btTransform MeshWays::start_of(const btCollisionObject& object, btScalar time_step) const {
  const btTransform& now = object.getWorldTransform();
  if (!object.isKinematicObject()) return now;
  const auto known = last_.find(&object);
  if (known == last_.end()) {
    return is_moving(object) ? poses_of(object, btTransform::getIdentity(), time_step).t0 : now;
  }
  const btTransform& last = known->second;
  return is_moving(object) || !has_jumped(*object.getCollisionShape(), last, now) ? last : now;
}

/// As btRigidBody::saveKinematicState does for bodies that are awake.
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
  starts_.clear();
  for (int i = 0; i < objects.size(); ++i) {
    btCollisionObject& object = *objects[i];
    if (is_standing(object) || !has_meshes(object)) continue;
    const btTransform start = start_of(object, time_step);
    starts_.emplace(&object, start);
    if (object.isKinematicObject() && !is_moving(object)) lend_velocity(object, start, time_step);
  }
  last_.clear();
  for (const auto& [object, start] : starts_) last_.emplace(object, object->getWorldTransform());
}

std::vector<MeshWay> MeshWays::find(const btCollisionObjectArray& objects) {
  take_velocities_back(objects);
  std::vector<MeshWay> ways;
  for (int i = 0; i < objects.size(); ++i) {
    btCollisionObject& object = *objects[i];
    if (!has_meshes(object)) continue;
    const btTransform& end = object.getWorldTransform();
    const auto start = starts_.find(&object);
    const RigidPoses poses = {start != starts_.end() ? start->second : end, end};
    if (start != starts_.end()) last_[&object] = end;
    int child = 0;
    add_ways(object, *object.getCollisionShape(), poses, child, ways);
  }
  return ways;
}

}  // namespace softcd::bullet
