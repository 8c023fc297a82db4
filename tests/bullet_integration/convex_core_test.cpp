// Cores of convex shapes, compared with Bullet's own support functions.

#include "bodies/convex_core.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <random>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btCapsuleShape.h"
#include "BulletCollision/CollisionShapes/btConeShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btCylinderShape.h"
#include "BulletCollision/CollisionShapes/btMultiSphereShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "BulletCollision/CollisionShapes/btTriangleShape.h"
#include "bodies/vectors.hpp"

namespace softcd::test {
namespace {

using bullet::ConvexCore;

/// By how much the core, with the shape's margin around it, is smaller than the shape, and larger, in 2000 directions.
struct Error {
  btScalar inside = 0, outside = 0;
};

Error error_of(const btConvexShape& shape) {
  ConvexCore core;
  EXPECT_TRUE(core.read(shape));
  std::mt19937 random(1);
  std::normal_distribution<btScalar> coordinate;
  Error error;
  for (int i = 0; i < 2000; ++i) {
    btVector3 direction;
    for (int axis = 0; axis < 3; ++axis) direction[axis] = coordinate(random);
    direction.normalize();
    const btScalar bullets = direction.dot(shape.localGetSupportVertexWithoutMarginNonVirtual(direction));
    btScalar ours = -BT_LARGE_FLOAT;
    for (const btVector3& vertex : core.vertices()) ours = btMax(ours, direction.dot(vertex));
    error.inside = btMax(error.inside, bullets - ours);
    error.outside = btMax(error.outside, ours - bullets);
  }
  return error;
}

void expect_exact(const btConvexShape& shape, std::size_t vertices, std::size_t triangles) {
  const Error error = error_of(shape);
  EXPECT_LT(error.inside, 1e-6) << shape.getName();
  EXPECT_LT(error.outside, 1e-6) << shape.getName();
  ConvexCore core;
  core.read(shape);
  EXPECT_EQ(core.vertices().size(), vertices) << shape.getName();
  EXPECT_EQ(core.triangles().size(), triangles) << shape.getName();
}

TEST(ConvexCores, of_polyhedra_spheres_and_capsules_are_exact) {
  btBoxShape box(btVector3(1, btScalar(0.5), 2));
  expect_exact(box, 8, 12);
  box.setLocalScaling(btVector3(2, 1, 3));
  expect_exact(box, 8, 12);
  expect_exact(btSphereShape(1), 1, 1);
  expect_exact(btCapsuleShape(btScalar(0.5), 1), 2, 1);
  expect_exact(btCapsuleShapeZ(btScalar(0.5), 1), 2, 1);
  const btVector3 tetrahedron[] = {btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 0), btVector3(0, 0, 1)};
  btConvexHullShape hull(&tetrahedron[0][0], 4, sizeof(btVector3));
  expect_exact(hull, 4, 4);
  hull.addPoint(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1)));  // within
  expect_exact(hull, 4, 4);
  btTriangleMesh mesh;
  for (int i = 0; i < 4; ++i) mesh.addTriangle(tetrahedron[i], tetrahedron[(i + 1) % 4], tetrahedron[(i + 2) % 4]);
  expect_exact(btConvexTriangleMeshShape(&mesh), 4, 4);
}

TEST(ConvexCores, may_be_flat_or_thin) {
  for (const int count : {1, 2, 3, 4}) {
    const btVector3 square[] = {btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(1, 1, 0), btVector3(0, 1, 0)};
    const btConvexHullShape hull(&square[0][0], count, sizeof(btVector3));
    const Error error = error_of(hull);
    EXPECT_LT(error.inside, 1e-6) << count;
    EXPECT_LT(error.outside, 1e-6) << count;
    ConvexCore core;
    core.read(hull);
    EXPECT_FALSE(core.triangles().empty()) << count;
  }
  ConvexCore of_nothing;
  of_nothing.read(btConvexHullShape());
  EXPECT_EQ(of_nothing.vertex_count(), 0U);
}

TEST(ConvexCores, of_round_shapes_are_inscribed_by_half_a_percent_of_their_radius) {
  const btVector3 half(1, 1, 1);
  const btVector3 centers[] = {btVector3(0, 0, 0), btVector3(1, 0, 0)};
  const btScalar radii[] = {1, btScalar(0.5)};
  const btCylinderShape cylinder(half);
  const btCylinderShapeX cylinder_x(half);
  const btConeShapeZ cone(1, 2);
  const btMultiSphereShape spheres(centers, radii, 2);
  for (const btConvexShape* shape : std::initializer_list<const btConvexShape*>{&cylinder, &cylinder_x, &cone}) {
    const Error error = error_of(*shape);
    EXPECT_GT(error.inside, 0.003) << shape->getName();
    EXPECT_LT(error.inside, 0.005) << shape->getName();
    EXPECT_LT(error.outside, 1e-6) << shape->getName();
  }
  const Error error = error_of(spheres);
  EXPECT_LT(error.inside, 0.012) << "twice as much: it is curved in two directions";
  EXPECT_LT(error.outside, 1e-6);
}

TEST(ConvexCores, are_read_anew_when_a_shape_changes) {
  btBoxShape box(btVector3(1, 1, 1));
  ConvexCore core;
  EXPECT_TRUE(core.read(box));
  EXPECT_FALSE(core.read(box));
  box.setLocalScaling(btVector3(2, 1, 1));
  EXPECT_TRUE(core.read(box));
  EXPECT_TRUE(core.read(btSphereShape(1)));
  EXPECT_EQ(core.vertex_count(), 1U);
}

TEST(ConvexCores, have_edges_but_no_diagonals) {
  ConvexCore core;
  core.read(btBoxShape(btVector3(1, 1, 1)));
  int edges = 0;
  for (std::uint32_t a = 0; a < 8; ++a) {
    for (std::uint32_t b = a + 1; b < 8; ++b) edges += core.is_edge(a, b);
  }
  EXPECT_EQ(edges, 12);
}

TEST(ConvexCores, tell_in_front_from_behind_and_within) {
  ConvexCore core;
  core.read(btSphereShape(1));
  const bullet::RigidPoses poses = {btTransform::getIdentity(), btTransform::getIdentity()};
  core.place(poses);
  EXPECT_TRUE(core.is_farthest(btVector3(0, 0, 0), btVector3(0, 1, 0), 0));
  btBoxShape box(btVector3(1, 1, 1));
  box.setMargin(0);
  core.read(box);
  core.place(poses);
  EXPECT_TRUE(core.is_farthest(btVector3(1, 1, 1), btVector3(0, 1, 0), 0));
  EXPECT_TRUE(core.is_farthest(btVector3(1, 1, 1), btVector3(0, 1, 1).normalized(), 0));
  EXPECT_FALSE(core.is_farthest(btVector3(1, 1, 1), btVector3(0, -1, 0), 0));
  EXPECT_FALSE(core.is_farthest(btVector3(1, 1, 1), btVector3(-1, 1, 1).normalized(), 0));
  EXPECT_TRUE(core.is_pierced(btVector3(0, btScalar(-0.5), 0), btVector3(0, 1, 0)));
  EXPECT_FALSE(core.is_pierced(btVector3(0, btScalar(0.5), 0), btVector3(0, 1, 0))) << "nearer to the other end";
  EXPECT_FALSE(core.is_pierced(btVector3(2, btScalar(-0.5), 0), btVector3(0, 1, 0))) << "beside it";
}

/// A contact's point is rounded in another order than the core's vertices are, and would be one of them.
TEST(ConvexCore, no_vertex_is_further_than_itself) {
  std::mt19937 random(1);
  std::uniform_real_distribution<btScalar> coordinate(-3, 3);
  const auto pose = [&] {
    const btVector3 axis(coordinate(random), coordinate(random), coordinate(random));
    return btTransform(btQuaternion(axis, coordinate(random)), {coordinate(random), coordinate(random), 0});
  };
  ConvexCore core;
  core.read(btBoxShape(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.1))));
  for (int i = 0; i < 1000; ++i) {
    const btTransform start = pose();
    const btTransform end(start.getRotation(), start.getOrigin() + btVector3(0, coordinate(random), 0));
    core.place({start, end});
    const float time = static_cast<float>(i) / 1000;
    for (std::size_t v = 0; v < core.vertices().size(); ++v) {
      const btVector3 outward = (start.getBasis() * core.vertices()[v]).normalized();
      const btVector3 point =
          lerp(bullet::to_bullet(core.x_t0()[v]), bullet::to_bullet(core.x_t1()[v]), btScalar(time));
      const btScalar share = btScalar(1e-3);
      EXPECT_TRUE(core.is_farthest(point, outward, double(time))) << i;
      EXPECT_FALSE(core.is_farthest(point - share * outward, outward, double(time))) << i;
    }
  }
}

}  // namespace
}  // namespace softcd::test
