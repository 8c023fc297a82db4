// Attached worlds give the results of softcd's own worlds, and detached ones those of Bullet's.

#include "attached_worlds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"

namespace softcd::test {
namespace {

using bullet::attach;
using bullet::Attachment;

std::unique_ptr<btSoftBody> make_grain(btSoftBodyWorldInfo& info, const btVector3& place, btScalar speed) {
  auto grain = std::make_unique<btSoftBody>(&info, 1, &place, nullptr);
  grain->setTotalMass(btScalar(0.02));
  grain->getCollisionShape()->setMargin(btScalar(0.03));
  grain->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  grain->setVelocity(btVector3(0, -speed, 0));
  return grain;
}

/// Two triangles that hang at two corners.
std::unique_ptr<btSoftBody> make_plate(btSoftBodyWorldInfo& info) {
  auto plate = make_sheet(info, {/*nodes_per_side=*/2, /*side=*/2, /*height=*/0, /*margin=*/btScalar(0.03)});
  for (const int node : {0, 3}) plate->setMass(node, 0);
  return plate;
}

/// Grains that fall onto a plate, and a cloth onto a rigid mesh. No body has more than one contact with faces of
/// others, which Bullet's deformable world would take in an order that depends on all worlds before it.
class Grains {
 public:
  static constexpr int kSteps = 50;

  Grains(World world, const MaybeSettings& of_softcds_own, btScalar speed) : simulation_(world, of_softcds_own) {
    triangles_.addTriangle(btVector3(-3, -1, -3), btVector3(0, -1, 6), btVector3(3, -1, -3));
    simulation_.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&triangles_, true), btVector3(0, 0, 0));
    simulation_.add(make_plate(simulation_.world_info()));
    for (int i = 0; i < 6; ++i) {
      const btVector3 place(btScalar(0.1) * btScalar(i) - btScalar(0.2), btScalar(0.25) + btScalar(0.05) * btScalar(i),
                            btScalar(0.5) - btScalar(0.02) * btScalar(i));
      simulation_.add(make_grain(simulation_.world_info(), place, speed));
    }
    auto cloth = make_sheet(simulation_.world_info(), {7, btScalar(0.8), btScalar(-0.75), btScalar(0.03)});
    cloth->translate(btVector3(btScalar(1.7), 0, btScalar(-1.7)));
    simulation_.add(std::move(cloth));
  }

  AnySimulation& simulation() { return simulation_; }
  btDiscreteDynamicsWorld& world() { return simulation_.world(); }
  void step() { simulation_.step_once(); }

 private:
  btTriangleMesh triangles_;
  AnySimulation simulation_;
};

/// Adds cloths with many contacts, where Bullet keeps them in order.
class Cloths {
 public:
  static constexpr int kSteps = 15;

  Cloths(World world, const MaybeSettings& of_softcds_own, btScalar speed) : grains_(world, of_softcds_own, speed) {
    SheetOptions options;
    options.nodes_per_side = 5;
    options.height = 1;
    options.fixed = true;
    simulation().add(make_sheet(simulation().world_info(), options));
    options.fixed = false;
    for (const btScalar height : {btScalar(1.2), btScalar(1.3)}) {
      options.height = height;
      ++options.nodes_per_side;
      options.side -= btScalar(0.1);
      btSoftBody& cloth = simulation().add(make_sheet(simulation().world_info(), options));
      cloth.setVelocity(btVector3(0, -speed, btScalar(0.2)));
      cloth.setSelfCollision(true);
    }
  }

  AnySimulation& simulation() { return grains_.simulation(); }
  btDiscreteDynamicsWorld& world() { return simulation().world(); }
  void step() { simulation().step_once(); }

 private:
  Grains grains_;
};
class AttachedWorlds : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, AttachedWorlds, kBulletsWorlds, world_name);

class AttachedClassicWorlds : public testing::TestWithParam<World> {};
INSTANTIATE_TEST_SUITE_P(Worlds, AttachedClassicWorlds, testing::Values(World::one_line, World::multi_body),
                         world_name);

/// Runs the scene in softcd's own world of that kind, and in Bullet's with softcd attached. Returns how many values the
/// contacts of all steps have.
template <class Scene>
std::size_t expect_the_same(World world, const bullet::Settings& settings, btScalar speed, bool finishes_steps) {
  Scene own(world, settings, speed);
  Scene bullets(world, std::nullopt, speed);
  Attachment attachment = attach(bullets.world(), settings);
  std::size_t values = 0;
  for (int step = 0; step < Scene::kSteps; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    own.step();
    bullets.step();
    const std::vector<btScalar> contacts = contacts_in(bullets.simulation());
    EXPECT_EQ(contacts, contacts_in(own.simulation()));
    values += contacts.size();
    if (finishes_steps) {
      attachment.finish_step();
      EXPECT_EQ(states_in(bullets.simulation()), states_in(own.simulation()));
    }
    if (testing::Test::HasFailure()) break;
  }
  attachment.detach();
  EXPECT_EQ(states_in(bullets.simulation()), states_in(own.simulation()));
  EXPECT_EQ(attachment.detection().contact_report().failed_steps(), 0U);
  return values;
}

TEST_P(AttachedWorlds, finds_what_softcds_own_world_finds_byte_by_byte) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    for (const btScalar speed : {btScalar(1), btScalar(40)}) {
      for (const bool finishes_steps : {false, true}) {
        SCOPED_TRACE(testing::Message() << (detection == Detection::ccd ? "ccd, " : "dcd, ") << speed << " m/s");
        EXPECT_GT(expect_the_same<Grains>(GetParam(), cpu_settings(detection), speed, finishes_steps), 100U);
      }
    }
  }
}

TEST_P(AttachedClassicWorlds, finds_what_softcds_own_world_finds_where_cloths_and_edges_touch) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const bullet::Settings settings = careful_settings(detection);
    for (const bool finishes_steps : {false, true}) {
      EXPECT_GT(expect_the_same<Cloths>(GetParam(), settings, 10, finishes_steps), 5000U);
    }
  }
}

/// Puts the nodes of a deformable world where those of the other are, because Bullet solves contacts in a different
/// order in each run.
void put_where_others_are(AnySimulation& world, AnySimulation& other) {
  for (int b = 0; b < world.bodies().size(); ++b) {
    for (int n = 0; n < world.bodies()[b]->m_nodes.size(); ++n) {
      btSoftBody::Node& node = world.bodies()[b]->m_nodes[n];
      const btSoftBody::Node& from = other.bodies()[b]->m_nodes[n];
      node.m_x = from.m_x;
      node.m_q = from.m_q;
      node.m_v = from.m_v;
      node.m_vn = from.m_vn;
      node.m_n = from.m_n;
      node.m_f = from.m_f;
    }
  }
}

TEST(AttachedDeformableWorlds, finds_what_softcds_own_world_finds_where_cloths_and_edges_touch) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const bullet::Settings settings = careful_settings(detection);
    Cloths own(World::deformable, settings, 10);
    Cloths bullets(World::deformable, std::nullopt, 10);
    const Attachment attachment = attach(bullets.world(), settings);
    std::size_t values = 0;
    for (int step = 0; step < Cloths::kSteps; ++step) {
      SCOPED_TRACE("step " + std::to_string(step));
      put_where_others_are(own.simulation(), bullets.simulation());
      own.step();
      bullets.step();
      const std::vector<btScalar> contacts = contacts_in(bullets.simulation());
      ASSERT_EQ(contacts, contacts_in(own.simulation()));
      values += contacts.size();
    }
    EXPECT_GT(values, 5000U);
  }
}

/// Steps of a world that softcd is attached to between the two numbers of steps, and of one that it never is.
void expect_steps_as_if_never_attached(World world, int first, int last, bool reattaches) {
  Grains never(world, std::nullopt, 1);
  Grains bullets(world, std::nullopt, 1);
  std::optional<Attachment> attachment;
  std::size_t values = 0;
  for (int step = 0; step < 80; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    if (step >= first && step < last && !attachment.has_value()) attachment = attach(bullets.world(), cpu_settings());
    if (step == last || reattaches) attachment.reset();
    never.step();
    bullets.step();
    ASSERT_EQ(contacts_in(bullets.simulation()), contacts_in(never.simulation()));
    ASSERT_EQ(states_in(bullets.simulation()), states_in(never.simulation()));
    values += contacts_in(never.simulation()).size();
  }
  EXPECT_GT(values, 100U);
}

TEST_P(AttachedWorlds,
       a_world_whose_bodies_touched_only_after_it_was_detached_goes_on_as_if_it_had_never_been_attached) {
  expect_steps_as_if_never_attached(GetParam(), 1, 3, /*reattaches=*/false);
}

TEST_P(AttachedWorlds, and_detaching_between_any_two_steps_changes_no_byte) {
  expect_steps_as_if_never_attached(GetParam(), 0, 80, /*reattaches=*/true);
}

/// Bullet's face and node trees anew, as their shapes decide about the order of contacts.
void renew_trees(AnySimulation& world) {
  for (int b = 0; b < world.bodies().size(); ++b) {
    btSoftBody& body = *world.bodies()[b];
    body.rebuildNodeTree();
    if (body.m_faces.size() > 0) body.initializeFaceTree();
  }
}

TEST_P(AttachedWorlds, a_world_detached_in_mid_contact_goes_on_as_one_never_attached_in_that_state) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Grains bullets(GetParam(), std::nullopt, 1);
    Grains never(GetParam(), std::nullopt, 1);
    Attachment attachment = attach(bullets.world(), cpu_settings(detection));
    const int steps = GetParam() == World::deformable ? 50 : 14;
    for (int step = 0; step < steps; ++step) bullets.step();
    EXPECT_GT(attachment.detection().contact_report().statistics().vt_contacts, 0U);
    attachment.detach();
    never.step();  // Bullet prepares bodies in their first step.
    put_where_others_are(never.simulation(), bullets.simulation());
    renew_trees(bullets.simulation());
    renew_trees(never.simulation());
    std::size_t values = 0;
    for (int step = 0; step < 60; ++step) {
      SCOPED_TRACE("step " + std::to_string(step));
      bullets.step();
      never.step();
      ASSERT_EQ(contacts_in(bullets.simulation()), contacts_in(never.simulation()));
      ASSERT_EQ(states_in(bullets.simulation()), states_in(never.simulation()));
      values += contacts_in(never.simulation()).size();
    }
    EXPECT_GT(values, 100U);
  }
}

}  // namespace
}  // namespace softcd::test
