#pragma once

#include <memory>
#include <vector>

#include "BulletCollision/CollisionDispatch/btCollisionWorld.h"
#include "softcd/export.hpp"
#include "softcd/softcd.hpp"
#include "softcd/version.hpp"

class btConvexShape;
class btSoftBody;

namespace softcd::bullet {
inline namespace SOFTCD_VERSION_NAMESPACE {

/// The part ids of a soft body's side in results of WorldProbe's contact tests, which say what the indices beside them
/// count: nodes, as in m_nodes;
constexpr int kNodePart = 0;
/// faces, as in m_faces;
constexpr int kFacePart = 1;
/// and edges of all faces, or of a rope's links, numbered as in Contact.
constexpr int kEdgePart = 2;

/// A convex shape that is put somewhere, for Probe::overlaps(). Bullet takes a shape for all that is within its margin
/// of a core, and so does this: spheres, capsules, boxes, hulls and other polyhedra are what they are to Bullet. The
/// cores of cylinders and cones are inscribed, with circles of 32 corners: of a circle's radius 0.5 % may be missing.
/// What is curved in another way has 16 corners from pole to pole.
class SOFTCD_EXPORT ShapeHull {
 public:
  /// Reads the shape; where it has no corners, or one is not finite, the hull overlaps nothing.
  ShapeHull(const btConvexShape& shape, const btTransform& place);
  /// Valid as long as this.
  QueryHull query() const { return {points_, radius_}; }

 private:
  std::vector<Vec3d> points_;
  double radius_;
};

/// Asks what soft bodies of a world are where, with their nodes where they are now. Whatever the world is, Bullet's
/// own, one of softcd's, under a softcd::bullet::Dispatcher, or attached to: Bullet's functions of these names build
/// face trees in time quadratic in the faces (rayTest), or find nothing of soft bodies and leave contacts in them
/// (contactTest).
///
/// A body is read whenever something is asked that it may answer; what an app has done to it is noticed then. On the
/// CPU. One thread at a time. Throws OutOfMemory.
class SOFTCD_EXPORT WorldProbe {
 public:
  /// The world outlives it. `log` as Scene::set_log().
  explicit WorldProbe(btCollisionWorld& world, LogCallback log = {});
  ~WorldProbe();
  /// The one that it was moved from can only be destroyed or assigned to.
  WorldProbe(WorldProbe&&) noexcept;
  WorldProbe& operator=(WorldProbe&&) noexcept;

  /// All of a Probe's questions about all soft bodies of the world, which this call reads. Vertices are nodes and
  /// triangles are faces, as in m_nodes and m_faces; triangles behind a body's faces stand for single nodes without
  /// one, and then for links of a body that has nothing else (ropes). Valid until the world's bodies, or their
  /// topologies, change.
  Probe& soft_bodies();
  /// Who a soft body is in its questions and answers. Throws InvalidInput where it was not in the world at the last
  /// call of soft_bodies().
  BodyId body_id(const btSoftBody& body) const;
  /// Whom a body of its answers stands for; null where it was not in the world at the last call of soft_bodies().
  btSoftBody* soft_body(BodyId body) const;

  /// btCollisionWorld::rayTest, as softcd's own worlds have it: see SoftWorld::rayTest. Each ray compares all nodes and
  /// faces of the bodies that it comes near with those that were read: many rays are faster in one batch, by
  /// Probe::first_hits() of soft_bodies().
  void ray_test(const btVector3& from, const btVector3& to, btCollisionWorld::RayResultCallback& callback);

  /// btCollisionWorld::contactTest with soft bodies: Bullet's own results, and those of pairs with a soft body. The
  /// callback is told every pair of features, of nodes and faces and of edges, that is no further apart than both
  /// margins and its m_closestDistanceThreshold, where things are now: the point on both sides, the normal on
  /// `object`'s side of the other's, and the distance between what lies at the margins, less than 0 where these
  /// overlap. `object` is the callback's first. A soft body's side has one of these part ids and the number of the
  /// node, face or edge; a rigid one's has -1 for both. What it returns is not asked for.
  ///
  /// Rigid shapes: convex ones and compounds of these, all within their margin of a core (Settings::convex_shapes says
  /// how exact), and triangle meshes. Nodes inside a convex core are told with the nearest of its faces, whose distance
  /// is less than 0. A plane, and a soft body inside a triangle mesh, is not told.
  void contact_test(btCollisionObject& object, btCollisionWorld::ContactResultCallback& callback);
  /// The same of two objects, or of a soft body and itself.
  void contact_pair_test(btCollisionObject& a, btCollisionObject& b, btCollisionWorld::ContactResultCallback& callback);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
