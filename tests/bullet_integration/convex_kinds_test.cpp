// All kinds of convex shapes and of objects that have them, as they come, change and go.

#include <gtest/gtest.h>

#include "BulletCollision/CollisionShapes/btCapsuleShape.h"
#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btConeShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btCylinderShape.h"
#include "BulletCollision/CollisionShapes/btMultiSphereShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"
#include "convex_support.hpp"

namespace softcd::test {
namespace {

/// A shape with its parts, 0.1 to 0.3 high.
struct Made {
  std::unique_ptr<btCollisionShape> part, inner;
  std::unique_ptr<btCollisionShape> shape;
  const char* name;
};

Made only(std::unique_ptr<btCollisionShape> shape, const char* name) {
  return {nullptr, nullptr, std::move(shape), name};
}

std::unique_ptr<btConvexHullShape> make_octahedron() {
  auto hull = std::make_unique<btConvexHullShape>();
  for (int axis = 0; axis < 3; ++axis) {
    btVector3 corner(0, 0, 0);
    corner[axis] = btScalar(0.1);
    hull->addPoint(corner);
    hull->addPoint(-corner);
  }
  return hull;
}

/// Two compounds with the same child in one compound. Only the places of the two children differ.
Made make_nested() {
  Made made;
  made.name = "nested compounds";
  made.part = std::make_unique<btSphereShape>(btScalar(0.05));
  auto inner = std::make_unique<btCompoundShape>();
  inner->addChildShape(btTransform::getIdentity(), made.part.get());
  auto outer = std::make_unique<btCompoundShape>();
  for (const btScalar x : {btScalar(-0.3), btScalar(0.3)}) {
    outer->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(x, 0, 0)), inner.get());
  }
  made.inner = std::move(inner);
  made.shape = std::move(outer);
  return made;
}

std::vector<Made> make_shapes() {
  std::vector<Made> shapes;
  shapes.push_back(only(make_small_box(), "box"));
  shapes.push_back(only(make_octahedron(), "hull"));
  shapes.push_back(only(std::make_unique<btSphereShape>(btScalar(0.1)), "sphere"));
  shapes.push_back(only(std::make_unique<btCapsuleShape>(btScalar(0.05), btScalar(0.1)), "capsule"));
  shapes.push_back(only(std::make_unique<btCapsuleShapeX>(btScalar(0.05), btScalar(0.3)), "lying capsule"));
  shapes.push_back(
      only(std::make_unique<btCylinderShape>(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1))), "cylinder"));
  shapes.push_back(only(std::make_unique<btConeShape>(btScalar(0.1), btScalar(0.2)), "cone"));
  const btVector3 centers[] = {btVector3(0, 0, 0), btVector3(btScalar(0.1), 0, 0)};
  const btScalar radii[] = {btScalar(0.1), btScalar(0.05)};
  shapes.push_back(only(std::make_unique<btMultiSphereShape>(centers, radii, 2), "two spheres"));
  auto scaled = make_octahedron();
  scaled->setLocalScaling(btVector3(3, btScalar(0.5), 2));
  shapes.push_back(only(std::move(scaled), "scaled hull"));
  auto sharp = make_octahedron();
  sharp->setMargin(0);
  shapes.push_back(only(std::move(sharp), "hull without margin"));
  auto blunt = make_octahedron();
  blunt->setMargin(btScalar(0.2));
  shapes.push_back(only(std::move(blunt), "hull with a large margin"));
  shapes.push_back(make_nested());
  return shapes;
}

class ConvexKinds : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, ConvexKinds, kWorldsOfRun, world_name);

/// In the deformable world Bullet finds these contacts itself.
class ConvexKindsInClassicWorlds : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, ConvexKindsInClassicWorlds, kClassicWorlds, world_name);

class LinksOfMultiBodies : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, LinksOfMultiBodies,
                         testing::Values(World::multi_body, World::deformable, World::attached_deformable), world_name);

/// The height of a triangle that has fallen with 3 m/s on the shape's origin, a metre below.
btScalar fall_on(World world, const bullet::Settings& settings, Made& made) {
  AnySimulation simulation(world, settings);
  simulation.add_rigid(std::move(made.shape), btVector3(0, -1, 0));
  btSoftBody& triangle = simulation.add(make_triangle(simulation.world_info(), 1));
  triangle.m_cfg.collisions |= btSoftBody::fCollision::SDF_RDF;
  triangle.setVelocity(btVector3(0, -3, 0));
  for (int step = 0; step < 22; ++step) simulation.step();
  return mean_height(triangle);
}

TEST_P(ConvexKinds, are_met_by_a_large_triangle) {
  const std::size_t count = make_shapes().size();
  for (std::size_t i = 0; i < count; ++i) {
    Made made = std::move(make_shapes()[i]);
    EXPECT_GT(fall_on(GetParam(), with_faces_and_edges(), made), -1.15) << made.name;
    if (is_deformable(GetParam())) continue;
    made = std::move(make_shapes()[i]);
    EXPECT_LT(fall_on(GetParam(), test_settings(), made), -1.4) << made.name;
  }
}

/// Drops a triangle from near on a static sphere; `change` is called before each step.
template <class Change>
btScalar lie_on_sphere(World world, const bullet::Settings& settings, Change change) {
  btSphereShape large(btScalar(0.3));
  AnySimulation simulation(world, settings);
  btRigidBody& body = simulation.add_rigid(std::make_unique<btSphereShape>(btScalar(0.1)), btVector3(0, -1, 0));
  btCollisionShape* const little = body.getCollisionShape();
  auto made = make_triangle(simulation.world_info(), 1);
  made->translate(btVector3(0, btScalar(-0.85), btScalar(1) / 3));  // its middle above the sphere's
  btSoftBody& triangle = simulation.add(std::move(made));
  triangle.m_cfg.collisions |= btSoftBody::fCollision::SDF_RDF;
  for (int step = 0; step < 30; ++step) {
    change(simulation, body, large, step);
    simulation.step();
  }
  body.setCollisionShape(little);
  return mean_height(triangle);
}

TEST_P(ConvexKinds, that_do_not_respond_or_are_masked_are_left_alone) {
  EXPECT_NEAR(lie_on_sphere(GetParam(), with_faces_and_edges(), [](auto&&...) {}), -0.88, 0.03);
  const auto without_response = [](auto&, btRigidBody& body, auto&, int) {
    body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  };
  const btScalar height = lie_on_sphere(GetParam(), with_faces_and_edges(), without_response);
  EXPECT_EQ(height, lie_on_sphere(GetParam(), test_settings(), without_response));
  if (!is_deformable(GetParam())) {
    EXPECT_LT(height, -1.5) << "the deformable world does not ask";
  }
  const auto masked = [](auto&, btRigidBody& body, auto&, int) {
    body.getBroadphaseProxy()->m_collisionFilterMask = 0;
  };
  EXPECT_LT(lie_on_sphere(GetParam(), with_faces_and_edges(), masked), -1.5);
}

TEST_P(ConvexKinds, may_be_replaced_and_scaled) {
  const auto replace = [](AnySimulation& simulation, btRigidBody& body, btSphereShape& large, int step) {
    if (step != 10) return;
    body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-1.2), 0)));
    body.setCollisionShape(&large);
    simulation.world().updateSingleAabb(&body);
  };
  EXPECT_NEAR(lie_on_sphere(GetParam(), with_faces_and_edges(), replace), -0.88, 0.03);
  const auto scale = [](AnySimulation& simulation, btRigidBody& body, btSphereShape&, int step) {
    if (step != 10) return;
    body.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-1.1), 0)));
    body.getCollisionShape()->setLocalScaling(btVector3(2, 2, 2));
    simulation.world().updateSingleAabb(&body);
  };
  EXPECT_NEAR(lie_on_sphere(GetParam(), with_faces_and_edges(), scale), -0.88, 0.03);
}

TEST_P(ConvexKindsInClassicWorlds, can_be_asked_for_and_left_to_bullet_at_any_time) {
  const auto turn_on = [](AnySimulation& simulation, auto&, auto&, int step) {
    if (step == 1) simulation.detection().set_settings(with_faces_and_edges());
  };
  EXPECT_NEAR(lie_on_sphere(GetParam(), test_settings(), turn_on), -0.88, 0.03);
  const auto turn_off = [](AnySimulation& simulation, auto&, auto&, int step) {
    if (step == 5) simulation.detection().set_settings(test_settings());
  };
  EXPECT_LT(lie_on_sphere(GetParam(), with_faces_and_edges(), turn_off), -1.5);
}

TEST_P(ConvexKindsInClassicWorlds, are_reported_with_depth_and_time) {
  bullet::Settings settings = with_faces_and_edges();
  settings.read_out = bullet::ReadOut::contacts;
  bool has_read = false;
  const auto read = [&](AnySimulation& simulation, btRigidBody& body, auto&, int step) {
    if (step == 0) return;
    for (const bullet::BodyPairContacts& pair : simulation.detection().body_contacts()) {
      EXPECT_EQ(pair.b, &body);
      for (const bullet::BodyContact& contact : pair.contacts) {
        has_read = true;
        EXPECT_GT(contact.normal.y(), 0.9);
        EXPECT_LT(btFabs(contact.depth), 0.05);
      }
    }
  };
  lie_on_sphere(GetParam(), settings, read);
  EXPECT_TRUE(has_read);
}

/// Attached softcd ends a step when the app has had the world again.
TEST(ConvexKinds, may_be_gone_when_a_step_ends_late) {
  AnySimulation simulation(World::attached, with_faces_and_edges(Detection::ccd));
  btSoftBody& triangle = simulation.add(make_triangle(simulation.world_info(), 1));
  triangle.setVelocity(btVector3(0, -10, 0));
  auto box = make_small_box();
  auto body = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, box.get()));
  body->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-0.15), 0)));
  body->setInterpolationWorldTransform(body->getWorldTransform());
  simulation.world().addRigidBody(body.get());
  simulation.world().stepSimulation(kStep, /*maxSubSteps=*/0);
  EXPECT_GT(triangle.m_rcontacts.size(), 0);
  const btScalar height = mean_height(triangle);
  simulation.world().removeRigidBody(body.get());
  body.reset();
  simulation.finish_step();
  EXPECT_EQ(mean_height(triangle), height);
}

/// A sphere at the end of a multibody that hangs on nothing, or is held.
class Link {
 public:
  Link(btMultiBodyDynamicsWorld& world, const btVector3& place, bool is_held)
      : world_(world), body_(0, 1, btVector3(1, 1, 1), is_held, false), collider_(&body_, -1) {
    body_.setBaseWorldTransform(btTransform(btQuaternion::getIdentity(), place));
    body_.finalizeMultiDof();
    collider_.setCollisionShape(&sphere_);
    collider_.setWorldTransform(body_.getBaseWorldTransform());
    collider_.setInterpolationWorldTransform(body_.getBaseWorldTransform());
    body_.setBaseCollider(&collider_);
    world_.addCollisionObject(&collider_);
    world_.addMultiBody(&body_);
  }
  ~Link() {
    world_.removeMultiBody(&body_);
    world_.removeCollisionObject(&collider_);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

 private:
  btMultiBodyDynamicsWorld& world_;
  btSphereShape sphere_{btScalar(0.1)};
  btMultiBody body_;
  btMultiBodyLinkCollider collider_;
};

btScalar fall_on_link(World world, const bullet::Settings& settings, btScalar speed) {
  AnySimulation simulation(world, settings);
  Link link(dynamic_cast<btMultiBodyDynamicsWorld&>(simulation.world()), btVector3(0, -1, 0), /*is_held=*/true);
  btSoftBody& triangle = simulation.add(make_triangle(simulation.world_info(), 1));
  triangle.m_cfg.collisions |= btSoftBody::fCollision::SDF_MDF;
  triangle.setVelocity(btVector3(0, -speed, 0));
  for (int step = 0; step < 16; ++step) simulation.step();
  const btScalar height = mean_height(triangle);
  simulation.remove(triangle);
  return height;
}

TEST_P(LinksOfMultiBodies, are_met_as_shapes_of_rigid_bodies_are) {
  EXPECT_GT(fall_on_link(GetParam(), with_faces_and_edges(), 5), -1.05);
  EXPECT_GT(fall_on_link(GetParam(), with_faces_and_edges(), 100), -6);
  EXPECT_LT(fall_on_link(GetParam(), test_settings(), 100), -20);
}

}  // namespace
}  // namespace softcd::test
