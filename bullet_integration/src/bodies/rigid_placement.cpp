#include "bodies/rigid_placement.hpp"

#include <algorithm>

#include "LinearMath/btTransformUtil.h"
#include "bodies/vectors.hpp"

namespace softcd::bullet {

RigidPoses poses_of(const btCollisionObject& object, const btTransform& shape_in_object, btScalar time_step) {
  const btTransform& now = object.getWorldTransform();
  RigidPoses poses = {now, now};
  if (object.isKinematicObject()) {
    btTransformUtil::integrateTransform(now, -object.getInterpolationLinearVelocity(),
                                        -object.getInterpolationAngularVelocity(), time_step, poses.t0);
  } else if (!is_standing(object)) {
    poses.t1 = object.getInterpolationWorldTransform();
  }
  return {poses.t0 * shape_in_object, poses.t1 * shape_in_object};
}

namespace {

/// Returns a bound on how far the box, in the coordinates of a turning shape, may leave its boxes at the step's ends.
/// The shape turns by an angle of 2 a. At the time s a vertex v is at M v + p. In the plane of the turn, M = cos(a) +
/// (2 s - 1) sin(a) J in the axes half-way, where J is the quarter turn. The vertex that meets a point x differs from
/// the mean, by weights (1 - s) and s, of those that meet it at the ends. The difference is at most tan(a)^2 (cos(a) +
/// sin(a)) |x - p| + sin(a) |p1 - p0| / 2.
btScalar bulge(const Bounds& box, const RigidPoses& poses) {
  if (poses.t0.getBasis() == poses.t1.getBasis()) return 0;
  const btScalar angle = poses.t0.getRotation().angleShortestPath(poses.t1.getRotation()) / 2;
  constexpr btScalar kLeastCosine = btScalar(1e-3);
  const btScalar tangent = btSin(angle) / btMax(btCos(angle), kLeastCosine);
  btScalar distance = 0;
  for (const btTransform* pose : {&poses.t0, &poses.t1}) {
    const btVector3& origin = pose->getOrigin();
    btVector3 farthest = (box.low - origin).absolute();
    farthest.setMax((box.high - origin).absolute());
    distance = btMax(distance, farthest.length());
  }
  return btScalar(1.5) * tangent * tangent * distance +
         btSin(angle) * (poses.t1.getOrigin() - poses.t0.getOrigin()).length() / 2;
}

}  // namespace

Bounds box_in_shape(const Bounds& box, const RigidPoses& poses) {
  const btVector3 center = (box.low + box.high) / 2;
  const btVector3 half = (box.high - box.low) / 2;
  const auto box_at = [&](const btTransform& pose) -> Bounds {
    const btTransform inverse = pose.inverse();
    const btVector3 local_center = inverse * center;
    const btVector3 local_half(half.dot3(inverse.getBasis()[0].absolute(), inverse.getBasis()[1].absolute(),
                                         inverse.getBasis()[2].absolute()));
    return {local_center - local_half, local_center + local_half};
  };
  Bounds result = box_at(poses.t0);
  result.add(box_at(poses.t1));
  return result.grown(bulge(box, poses));
}

void RigidShape::clear() {
  vertices_.clear();
  triangles_.clear();
  x_t0_.clear();
}

bool RigidShape::place(const RigidPoses& poses) {
  if (x_t0_.size() == vertices_.size() && poses.t0 == placed_.t0 && poses.t1 == placed_.t1) return false;
  placed_ = poses;
  x_t0_.clear();
  x_t1_.clear();
  for (const btVector3& vertex : vertices_) {
    x_t0_.push_back(to_doubles(poses.t0 * vertex));
    x_t1_.push_back(to_doubles(poses.t1 * vertex));
  }
  return true;
}

bool are_equal(const std::vector<btVector3>& a, const std::vector<btVector3>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const btVector3& p, const btVector3& q) {
    return p.x() == q.x() && p.y() == q.y() && p.z() == q.z();
  });
}

}  // namespace softcd::bullet
