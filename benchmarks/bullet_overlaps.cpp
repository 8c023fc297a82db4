#include "bullet_overlaps.hpp"

#include <cmath>

#include "btBulletCollisionCommon.h"

namespace softcd::benchmarks {
namespace {

btVector3 to_bullet(Vec3d v) {
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

/// Counts the mesh's triangles. Bullet reports all points of one triangle one after the other.
struct TriangleCount final : btCollisionWorld::ContactResultCallback {
  explicit TriangleCount(const btCollisionObject& mesh) : mesh_(mesh) {}

  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int /*part_a*/, int index_a,
                           const btCollisionObjectWrapper* /*b*/, int /*part_b*/, int index_b) override {
    const int triangle = a->getCollisionObject() == &mesh_ ? index_a : index_b;
    if (point.getDistance() > 0 || triangle == last_) return 0;
    last_ = triangle;
    ++count;
    return 0;
  }

  std::size_t count = 0;

 private:
  const btCollisionObject& mesh_;
  int last_ = -1;
};

std::vector<btVector3> scaled(const std::vector<Vec3f>& x, double scale) {
  std::vector<btVector3> positions;
  positions.reserve(x.size());
  for (const Vec3f& position : x) positions.push_back(to_bullet(scale * vec3_cast<double>(position)));
  return positions;
}

btIndexedMesh indexed(const std::vector<Triangle>& triangles, const std::vector<btVector3>& x) {
  btIndexedMesh mesh;
  mesh.m_numTriangles = static_cast<int>(triangles.size());
  mesh.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(triangles.data());
  mesh.m_triangleIndexStride = sizeof(Triangle);
  mesh.m_numVertices = static_cast<int>(x.size());
  mesh.m_vertexBase = reinterpret_cast<const unsigned char*>(x.data());
  mesh.m_vertexStride = sizeof(btVector3);
  mesh.m_vertexType = sizeof(btScalar) == sizeof(float) ? PHY_FLOAT : PHY_DOUBLE;
  return mesh;
}

}  // namespace

struct BulletOverlaps::State {
  State(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x, double unit)
      : scale(1 / unit), positions(scaled(x, scale)) {
    meshes.addIndexedMesh(indexed(triangles, positions));
    shape = std::make_unique<btBvhTriangleMeshShape>(&meshes, /*useQuantizedAabbCompression=*/true);
    shape->setMargin(0);
    mesh.setCollisionShape(shape.get());
  }

  std::size_t count(btConvexShape& convex, const btTransform& transform) {
    btCollisionObject object;
    object.setCollisionShape(&convex);
    object.setWorldTransform(transform);
    TriangleCount triangles(mesh);
    world.contactPairTest(&mesh, &object, triangles);
    return triangles.count;
  }

  double scale;
  std::vector<btVector3> positions;
  btTriangleIndexVertexArray meshes;
  std::unique_ptr<btBvhTriangleMeshShape> shape;
  btCollisionObject mesh;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btCollisionWorld world{&dispatcher, &broadphase, &configuration};
};

BulletOverlaps::BulletOverlaps(const std::vector<Triangle>& triangles, const std::vector<Vec3f>& x, double unit)
    : state_(std::make_unique<State>(triangles, x, unit)) {}

BulletOverlaps::~BulletOverlaps() = default;

std::size_t BulletOverlaps::count(Span<const ProbeCapsule> capsules) const {
  std::size_t triangles = 0;
  for (const ProbeCapsule& capsule : capsules) {
    const btVector3 along = to_bullet(state_->scale * (capsule.to - capsule.from));
    btCapsuleShape shape(btScalar(state_->scale * capsule.radius), along.length());  // along y
    const btTransform transform(shortestArcQuat(btVector3(0, 1, 0), along.normalized()),
                                to_bullet(0.5 * state_->scale * (capsule.from + capsule.to)));
    triangles += state_->count(shape, transform);
  }
  return triangles;
}

std::size_t BulletOverlaps::count(Span<const ProbeHull> hulls) const {
  std::size_t triangles = 0;
  for (const ProbeHull& hull : hulls) {
    btConvexHullShape shape;
    for (const Vec3d& point : hull.points) shape.addPoint(to_bullet(state_->scale * (point - hull.points[0])), false);
    shape.setMargin(btScalar(state_->scale * hull.radius));
    shape.recalcLocalAabb();
    triangles +=
        state_->count(shape, btTransform(btQuaternion::getIdentity(), to_bullet(state_->scale * hull.points[0])));
  }
  return triangles;
}

}  // namespace softcd::benchmarks
