#include "mesh_ways.hpp"

#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btConcaveShape.h"
#include "mesh_pairs.hpp"

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
  if (!object.isKinematicObject() || !is_moving(object)) return object.getWorldTransform();
  const auto known = last_.find(&object);
  return known != last_.end() ? known->second : poses_of(object, btTransform::getIdentity(), time_step).t0;
}

void MeshWays::keep_starts(const btCollisionObjectArray& objects, btScalar time_step) {
  starts_.clear();
  for (int i = 0; i < objects.size(); ++i) {
    const btCollisionObject& object = *objects[i];
    if (!is_standing(object) && has_meshes(object)) starts_.emplace(&object, start_of(object, time_step));
  }
  last_.clear();
  for (const auto& [object, start] : starts_) last_.emplace(object, object->getWorldTransform());
}

std::vector<MeshWay> MeshWays::find(const btCollisionObjectArray& objects) {
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
