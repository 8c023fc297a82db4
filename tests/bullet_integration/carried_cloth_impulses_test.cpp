// The impulses of body_contacts() on a cloth that hangs or lies, compared with its weight and its change of momentum.

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "any_simulation.hpp"
#include "contact_impulses.hpp"
#include "small_scenes.hpp"

namespace softcd::test {
namespace {

using Pairs = std::vector<bullet::BodyPairContacts>;

class CarriedClothImpulses : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, CarriedClothImpulses,
                         testing::Values(World::one_line, World::multi_body, World::deformable, World::attached,
                                         World::attached_deformable),
                         world_name);

void add_box(btTriangleMesh& mesh, btScalar half_side) {
  const auto corner = [&](int i) {
    return half_side * btVector3(btScalar(i & 1) * 2 - 1, btScalar(i & 2) - 1, btScalar(i & 4) / 2 - 1);
  };
  constexpr int kSides[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& side : kSides) {
    mesh.addTriangle(corner(side[0]), corner(side[1]), corner(side[2]));
    mesh.addTriangle(corner(side[0]), corner(side[2]), corner(side[3]));
  }
}

/// A cloth of 200 grams, 1.5 metres wide, between two fingers.
class HeldCloth {
 public:
  HeldCloth(World world, Detection detection, bool has_meshes, int nodes_per_side)
      : world_(world), simulation_(world, settings(detection)) {
    demo::ClothShape shape;
    shape.columns = shape.rows = nodes_per_side;
    const btScalar last = btScalar(nodes_per_side - 1);
    shape.position = [last](int column, int row) {
      const btVector3 place(btScalar(column) / last, btScalar(row) / last, 0);
      return btScalar(1.5) * (place - btVector3(btScalar(0.5), btScalar(0.5), 0));
    };
    add_box(mesh_, kHalfFinger);
    auto made = demo::make_cloth(simulation_.world_info(), shape, kMass);
    made->getCollisionShape()->setMargin(btScalar(0.02));
    made->m_cfg.piterations = 8;
    made->m_cfg.kDF = 1;
    cloth_ = &simulation_.add(std::move(made));
    cloth_->m_cfg.collisions |= btSoftBody::fCollision::SDF_RDF;
    cloth_->setActivationState(DISABLE_DEACTIVATION);
    node_mass_ = cloth_->getMass(0);
    set_masses(0);
    for (std::size_t side = 0; side < 2; ++side) {
      std::unique_ptr<btCollisionShape> shape_of_finger;
      if (has_meshes) {
        shape_of_finger = std::make_unique<btBvhTriangleMeshShape>(&mesh_, true);
        shape_of_finger->setMargin(btScalar(0.01));
      } else {
        shape_of_finger = std::make_unique<btBoxShape>(btVector3(1, 1, 1) * kHalfFinger);
      }
      fingers_[side] = &simulation_.add_rigid(std::move(shape_of_finger), place(side));
      fingers_[side]->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
      fingers_[side]->setFriction(1);
    }
  }

  static constexpr btScalar kMass = btScalar(0.2);
  struct Forces {
    btVector3 on_cloth{0, 0, 0}, on_fingers{0, 0, 0};
    btVector3 expected{0, 0, 0};  ///< by the momentum of the cloth
    bool has_crossings = false;   ///< whether the last pass of a step held it
  };

  /// Newtons, over a second while the cloth hangs there.
  Forces forces() {
    Forces sums;
    const bool has_short_steps = is_deformable(world_);
    const btScalar time = has_short_steps ? kStep / 4 : kStep;
    const int per_second = has_short_steps ? 240 : 60;
    for (int step = 0; step < 3 * per_second; ++step) {
      if (step == per_second / 2) set_masses(node_mass_);
      time_ += time;
      for (std::size_t side = 0; side < 2; ++side) {
        fingers_[side]->setWorldTransform(btTransform(btQuaternion::getIdentity(), place(side)));
      }
      const btVector3 before = momentum(*cloth_, &btSoftBody::Node::m_v);
      const btVector3 start = momentum(*cloth_, &btSoftBody::Node::m_x);
      simulation_.step(time);
      if (step < 2 * per_second) continue;
      const Pairs& pairs = simulation_.detection().body_contacts();
      sums.on_cloth += given_to(*cloth_, pairs, /*has_crossings=*/true);
      for (const btRigidBody* finger : fingers_) {
        sums.on_fingers += given_to(*finger, pairs, /*has_crossings=*/true);
      }
      sums.has_crossings = sums.has_crossings || simulation_.detection().crossing_answers().impacts > 0;
      sums.expected += momentum_at_end(world_, *cloth_, start, time) - before;
      sums.expected += btVector3(0, kGravity * kMass * time, 0);
    }
    return sums;
  }

 private:
  static constexpr btScalar kHalfFinger = btScalar(0.05);

  static bullet::Settings settings(Detection detection) {
    bullet::Settings settings = reading_impulses();
    settings.detection = detection;
    settings.convex_shapes = bullet::ConvexShapes::faces_and_edges;
    return settings;
  }
  btVector3 place(std::size_t side) const {
    const btScalar distance = btScalar(0.2) - btMin(2 * time_, btScalar(1)) * btScalar(0.145);
    return {btScalar(0.1), btScalar(0.15), side == 0 ? -distance : distance};
  }
  void set_masses(btScalar mass) {
    for (int i = 0; i < cloth_->m_nodes.size(); ++i) cloth_->setMass(i, mass);
  }

  World world_;
  btTriangleMesh mesh_;
  AnySimulation simulation_;
  btSoftBody* cloth_;
  btScalar node_mass_;
  btScalar time_ = 0;
  std::array<btRigidBody*, 2> fingers_;
};

void expect_what_the_cloth_gets(const HeldCloth::Forces& forces) {
  constexpr btScalar kPercent = btScalar(0.01) * HeldCloth::kMass * kGravity;
  EXPECT_GT(forces.expected.y(), 90 * kPercent) << "it hangs";
  EXPECT_LT(forces.on_cloth.distance(forces.expected), kPercent);
  EXPECT_LT(forces.on_fingers.distance(-forces.expected), kPercent);
}

// By the middle of a face.
TEST_P(CarriedClothImpulses, of_a_gripper_are_what_the_cloth_gets) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    SCOPED_TRACE(detection == Detection::ccd ? "ccd" : "dcd");
    expect_what_the_cloth_gets(HeldCloth(GetParam(), detection, /*has_meshes=*/false, 4).forces());
  }
}

// Without friction for faces the classic solver lets go of it; the last pass holds the nodes around the fingers.
TEST_P(CarriedClothImpulses, of_a_gripper_of_meshes_are_what_the_cloth_gets_to_be_held) {
  const int nodes_per_side = is_deformable(GetParam()) ? 4 : 16;
  const HeldCloth::Forces forces = HeldCloth(GetParam(), Detection::ccd, /*has_meshes=*/true, nodes_per_side).forces();
  expect_what_the_cloth_gets(forces);
  EXPECT_TRUE(forces.has_crossings);
}

/// The floor under a sheet of one kilogram.
enum class Floor { box, mesh, cloth };

/// With the sheet, which rests after a second.
class LyingSheet {
 public:
  LyingSheet(World world, Floor ground) : simulation_(world, settings()) {
    triangles_.addTriangle(btVector3(-3, 0, -3), btVector3(0, 0, 6), btVector3(3, 0, -3));
    if (ground == Floor::box) simulation_.add_rigid(std::make_unique<btBoxShape>(btVector3(2, 1, 2)), {0, -1, 0});
    if (ground == Floor::mesh) {
      simulation_.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&triangles_, true), {0, 0, 0});
    }
    SheetOptions options;
    if (ground == Floor::cloth) {
      options.fixed = true;
      options.side = 3;
      simulation_.add(make_sheet(simulation_.world_info(), options));
      options = {};
    }
    options.nodes_per_side = 5;
    options.height = btScalar(0.1);
    sheet_ = &simulation_.add(make_sheet(simulation_.world_info(), options));
  }

  btSoftBody& sheet() { return *sheet_; }
  void run(int steps) {
    for (int step = 0; step < steps; ++step) simulation_.step();
  }
  /// Newtons, over half a second.
  btScalar mean_force() {
    btScalar given = 0;
    bullet::Settings settings = simulation_.detection().settings();
    settings.on_contacts = [&](const Pairs& pairs) { given += given_to(*sheet_, pairs).y(); };
    simulation_.detection().set_settings(settings);
    run(30);
    return given / (30 * kStep);
  }

 private:
  static bullet::Settings settings() {
    bullet::Settings settings = reading_impulses();
    settings.detection = Detection::ccd;
    return settings;
  }

  btTriangleMesh triangles_;
  AnySimulation simulation_;
  btSoftBody* sheet_;
};

TEST_P(CarriedClothImpulses, carry_the_weight_of_a_cloth_that_rests) {
  for (const Floor ground : {Floor::box, Floor::mesh, Floor::cloth}) {
    SCOPED_TRACE(static_cast<int>(ground));
    LyingSheet lying(GetParam(), ground);
    lying.sheet().setActivationState(DISABLE_DEACTIVATION);
    lying.run(60);
    EXPECT_NEAR(lying.mean_force(), kGravity, 0.01 * kGravity);
  }
}

// Soft bodies fall asleep in the deformable world, and rest on rigid bodies as before.
TEST(CarriedClothImpulses, carry_the_weight_of_a_cloth_that_sleeps) {
  for (const World world : {World::deformable, World::attached_deformable}) {
    for (const Floor ground : {Floor::box, Floor::mesh}) {
      SCOPED_TRACE(static_cast<int>(ground));
      LyingSheet lying(world, ground);
      lying.run(300);
      ASSERT_FALSE(lying.sheet().isActive());
      EXPECT_NEAR(lying.mean_force(), kGravity, 0.01 * kGravity);
    }
  }
}

}  // namespace
}  // namespace softcd::test
