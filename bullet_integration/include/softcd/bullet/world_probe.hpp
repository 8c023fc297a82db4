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

/// Part id in results of WorldProbe's contact tests: the index is that of a node, as in m_nodes.
constexpr int kNodePart = 0;
/// Part id: the index is that of a face, as in m_faces.
constexpr int kFacePart = 1;
/// Part id: the index is that of an edge of a face, or of a rope's link, numbered as in Contact.
constexpr int kEdgePart = 2;

/// A convex shape at a place, for Probe::overlaps(). Like Bullet's own, it is all points within the shape's margin of a
/// core. Spheres, capsules, boxes, hulls and other polyhedra are exact. Cores of cylinders and cones are inscribed,
/// with circles of 32 corners, up to 0.5 % of the radius too small; other curved shapes have 16 corners from pole to
/// pole.
class SOFTCD_EXPORT ShapeHull {
 public:
  /// Reads the shape. If it has no corners, or one is not finite, the hull overlaps nothing.
  ShapeHull(const btConvexShape& shape, const btTransform& place);
  /// Returns a view for Probe::overlaps(), valid as long as this object.
  ProbeHull query() const { return {points_, radius_}; }

 private:
  std::vector<Vec3d> points_;
  double radius_;
};

/// Ray tests, contact tests and spatial queries of a world's soft bodies, at the current positions of their nodes.
/// Works on any world: Bullet's own, softcd's, one under a Dispatcher, or one that softcd is attached to. Bullet's own
/// rayTest builds face trees in time quadratic in the faces, and its contactTest ignores soft bodies and leaves
/// contacts in them.
///
/// Each call reads the bodies that it needs, and so notices all changes by the app. Runs on the CPU, from one thread at
/// a time. Throws OutOfMemory.
class SOFTCD_EXPORT WorldProbe {
 public:
  /// The world outlives it. `log` receives warnings: see Scene::set_log().
  explicit WorldProbe(btCollisionWorld& world, LogCallback log = {});
  ~WorldProbe();
  /// A moved-from object can only be destroyed or assigned to.
  WorldProbe(WorldProbe&&) noexcept;
  WorldProbe& operator=(WorldProbe&&) noexcept;

  /// Reads all soft bodies of the world and returns a Probe of them. Vertices are nodes and triangles are faces, as in
  /// m_nodes and m_faces. Further triangles stand for nodes without a face, and then for links of ropes. Intersections
  /// are exact for the nodes' positions, in a Bullet with doubles, too. Valid until the world's bodies or their
  /// topologies change.
  Probe& soft_bodies();
  /// Returns the body's id in that Probe. Throws InvalidInput if it was not in the world at the last soft_bodies().
  BodyId body_id(const btSoftBody& body) const;
  /// Returns the soft body with this id in that Probe; null if it was not in the world at the last soft_bodies().
  btSoftBody* soft_body(BodyId body) const;

  /// Tests a ray as SoftWorld::rayTest does. Each ray compares all nodes and faces of the bodies near it with those
  /// last read. For many rays, a batch is faster: soft_bodies().first_hits().
  void ray_test(const btVector3& from, const btVector3& to, btCollisionWorld::RayResultCallback& callback);

  /// Tests like btCollisionWorld::contactTest, and also pairs with soft bodies. Calls the callback for every pair of
  /// features, nodes with faces and edges with edges, at most both margins plus m_closestDistanceThreshold apart. It
  /// passes the points on both sides, the normal from the other object towards `object`, and the distance between the
  /// margins, negative if they overlap. `object` is the callback's first. A soft side has a part id from above and the
  /// number of its node, face or edge; a rigid side has -1 for both. The callback's return value is ignored.
  ///
  /// Rigid shapes are convex shapes, within their margin of a core, compounds of them, and triangle meshes. A node
  /// inside a convex core is reported with the core's nearest face, at a negative distance. Planes, and soft bodies
  /// inside of triangle meshes, are not reported.
  void contact_test(btCollisionObject& object, btCollisionWorld::ContactResultCallback& callback);
  /// Tests two objects, or a soft body with itself, in the same way.
  void contact_pair_test(btCollisionObject& a, btCollisionObject& b, btCollisionWorld::ContactResultCallback& callback);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace SOFTCD_VERSION_NAMESPACE
}  // namespace softcd::bullet
