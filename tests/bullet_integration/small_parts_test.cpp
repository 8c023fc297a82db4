// Small parts of the worlds: reading of bodies and meshes, boxes, constraints, and writing of contacts.

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "bodies/body_mesh.hpp"
#include "bodies/rigid_mesh.hpp"
#include "bodies/rigid_placement.hpp"
#include "crossings/constrained_nodes.hpp"
#include "random.hpp"
#include "rigid/rigid_contact_writer.hpp"
#include "soft_body_support.hpp"
#include "worlds/step_driver.hpp"

namespace softcd::test {
namespace {

TEST(BodyMesh, is_out_of_date_whichever_corner_of_a_face_is_another_node) {
  btSoftBodyWorldInfo info;
  const std::unique_ptr<btSoftBody> sheet = make_sheet(info, {});
  const bullet::BodyMesh mesh = bullet::read_mesh(*sheet);
  EXPECT_TRUE(bullet::is_up_to_date(mesh, *sheet));
  btSoftBody::Face& face = sheet->m_faces[sheet->m_faces.size() / 2];
  for (btSoftBody::Node*& corner : face.m_n) {
    btSoftBody::Node* const before = corner;
    corner = &sheet->m_nodes[0];
    EXPECT_FALSE(bullet::is_up_to_date(mesh, *sheet));
    corner = before;
  }
  EXPECT_TRUE(bullet::is_up_to_date(mesh, *sheet));
}

TEST(BodyMesh, of_a_rope_has_no_edges_where_it_only_bends) {
  btSoftBodyWorldInfo info;
  const std::unique_ptr<btSoftBody> rope(
      btSoftBodyHelpers::CreateRope(info, btVector3(0, 0, 0), btVector3(1, 0, 0), 8, 0));
  const std::size_t segments = bullet::read_mesh(*rope).segments.size();
  EXPECT_EQ(segments, 9U);
  rope->generateBendingConstraints(2);
  ASSERT_GT(rope->m_links.size(), int(segments));
  EXPECT_EQ(bullet::read_mesh(*rope).segments.size(), segments);
}

TEST(NodeConstraint, leaves_what_is_across_all_of_its_directions) {
  bullet::NodeConstraint constraint;
  constraint.add_direction({1, 0, 0});
  constraint.add_direction(btVector3(3, 4, 0) / 5);
  EXPECT_EQ(constraint.count(), 2);
  EXPECT_LT(constraint.direction(0).dot(constraint.direction(1)), 1e-6);
  const btVector3 left = constraint.free_part({1, 2, 3});
  EXPECT_NEAR(double(left.x()), 0, 1e-5);
  EXPECT_NEAR(double(left.y()), 0, 1e-5);
  EXPECT_NEAR(double(left.z()), 3, 1e-5);
}

// Two boxes that overlap: the triangles between them are in both.
TEST(RigidMeshPart, has_each_triangle_once) {
  btTriangleMesh triangles;
  constexpr int kStrip = 8;
  for (int x = 0; x < kStrip; ++x) {
    triangles.addTriangle(btVector3(btScalar(x), 0, 0), btVector3(btScalar(x + 1), 0, 0), btVector3(btScalar(x), 0, 1));
  }
  const btBvhTriangleMeshShape shape(&triangles, /*useQuantizedAabbCompression=*/false);
  bullet::RigidMesh mesh;
  const bullet::Bounds left = {{-1, -1, -1}, {5, 1, 2}};
  const bullet::Bounds right = {{3, -1, -1}, {9, 1, 2}};
  EXPECT_TRUE(mesh.read(shape, {left, right}));
  EXPECT_EQ(mesh.triangles().size(), std::size_t(kStrip));
  EXPECT_EQ(mesh.vertex_count(), 2U * kStrip + 1U);
}

btVector3 place_in_box(Random& random, double half_size) {
  const Vec3d p = random.in_box(half_size);
  return {btScalar(p.x), btScalar(p.y), btScalar(p.z)};
}

// While a shape turns its vertices take straight ways, and come by what no turning shape would reach.
TEST(BoxInShape, holds_all_vertices_that_pass_through_the_box) {
  Random random(1);
  const btVector3 half(btScalar(0.1), btScalar(0.1), btScalar(0.1));
  for (int i = 0; i < 2000; ++i) {
    const btVector3 axis = place_in_box(random, 1).safeNormalize();
    const btTransform t0(btQuaternion::getIdentity(), place_in_box(random, 1));
    const btTransform t1(btQuaternion(axis, btScalar(random.uniform(0.5, 2.0))), place_in_box(random, 1));
    const btVector3 centre = place_in_box(random, 2);
    const bullet::Bounds inside = bullet::box_in_shape({centre - half, centre + half}, {t0, t1});
    for (int sample = 0; sample < 50; ++sample) {
      const btVector3 place = centre + place_in_box(random, 0.1);
      const auto time = btScalar(random.unit());
      const btMatrix3x3 turn = t0.getBasis() * (1 - time) + t1.getBasis() * time;
      const btVector3 vertex = turn.inverse() * (place - t0.getOrigin().lerp(t1.getOrigin(), time));
      for (int k = 0; k < 3; ++k) {
        ASSERT_GE(vertex[k], inside.low[k] - btScalar(1e-4)) << i;
        ASSERT_LE(vertex[k], inside.high[k] + btScalar(1e-4)) << i;
      }
    }
  }
}

TEST(SweepBox, is_around_both_ends_with_the_margin) {
  btSoftBodyWorldInfo info;
  const std::unique_ptr<btSoftBody> sheet = make_sheet(info, {});
  btDbvtBroadphase broadphase;
  const btVector3 nothing(0, 0, 0);
  btBroadphaseProxy* const proxy =
      broadphase.createProxy(nothing, nothing, SOFTBODY_SHAPE_PROXYTYPE, sheet.get(), 1, -1, nullptr);
  sheet->setBroadphaseHandle(proxy);
  const btScalar margin = sheet->getCollisionShape()->getMargin();
  for (const btScalar move : {btScalar(-3), btScalar(3)}) {
    for (int i = 0; i < sheet->m_nodes.size(); ++i)
      sheet->m_nodes[i].m_q = sheet->m_nodes[i].m_x + btVector3(0, move, 0);
    btSoftBody* const bodies[] = {sheet.get()};
    bullet::sweep_boxes({bodies, 1}, bullet::Settings(), broadphase, nullptr);
    btVector3 low, high;
    broadphase.getAabb(proxy, low, high);
    for (int i = 0; i < sheet->m_nodes.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        ASSERT_GE(high[k], sheet->m_nodes[i].m_q[k] + margin);
        ASSERT_LE(low[k], sheet->m_nodes[i].m_q[k] - margin);
        ASSERT_GE(high[k], sheet->m_nodes[i].m_x[k]);
        ASSERT_LE(low[k], sheet->m_nodes[i].m_x[k]);
      }
    }
  }
  sheet->setBroadphaseHandle(nullptr);
  broadphase.destroyProxy(proxy, nullptr);
}

TEST(RigidContacts, wake_what_sleeps) {
  btSoftBodyWorldInfo info;
  const std::unique_ptr<btSoftBody> sheet = make_sheet(info, {});
  sheet->m_sst.sdt = kStep;
  btSphereShape shape(btScalar(0.1));
  btRigidBody ball(1, nullptr, &shape, btVector3(1, 1, 1));
  ball.setActivationState(ISLAND_SLEEPING);
  bullet::write_rigid_contact(*sheet, sheet->m_nodes[0],
                              {&ball, btVector3(0, 1, 0), btScalar(0.05), {0, 0, 0}, {0, 0, 0}, 1.0F});
  EXPECT_EQ(sheet->m_rcontacts.size(), 1);
  EXPECT_TRUE(ball.isActive());
}

}  // namespace
}  // namespace softcd::test
