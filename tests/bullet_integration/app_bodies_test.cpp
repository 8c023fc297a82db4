// Everything that an app can set on its bodies while the simulation runs, compared with Bullet's own result.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "exact_contacts.hpp"
#include "small_scenes.hpp"

namespace softcd::test {
namespace {

using demo::PlugIn;
using demo::Simulation;
using Flags = btSoftBody::fCollision;

class AppBodies : public testing::TestWithParam<PlugIn> {};
INSTANTIATE_TEST_SUITE_P(PlugIns, AppBodies, testing::ValuesIn(kPlugIns), plug_in_name);

/// How the same thing ends with `plug_in` and with Bullet alone.
void expect_as_with_bullet(PlugIn plug_in, const std::function<btScalar(PlugIn)>& outcome, double tolerance) {
  EXPECT_NEAR(double(outcome(plug_in)), double(outcome(PlugIn::none)), tolerance);
}

// A subclass of the app's may decide for itself.
class PickyBody : public btSoftBody {
 public:
  PickyBody(btSoftBodyWorldInfo* world_info, int node_count, const btVector3* positions)
      : btSoftBody(world_info, node_count, positions, nullptr) {
    m_checkCollideWith = 1;
  }
  bool checkCollideWithOverride(const btCollisionObject*) const override { return answer; }
  bool answer = false;
};

TEST_P(AppBodies, a_subclasses_own_filter_is_asked) {
  Simulation simulation(GetParam(), cpu_settings());
  simulation.world_info().m_gravity.setZero();
  btSoftBody& sheet = simulation.add(make_sheet(simulation.world_info(), {}));
  const btScalar y = btScalar(0.03);
  const btVector3 corners[] = {{0, y, 0}, {1, y, 0}, {0, y, 1}};
  auto triangle = std::make_unique<PickyBody>(&simulation.world_info(), 3, corners);
  triangle->appendFace(0, 2, 1);
  triangle->m_cfg.collisions = Flags::VF_SS;
  PickyBody& picky = *triangle;
  simulation.add(std::move(triangle));
  simulation.step(kStep);
  EXPECT_EQ(picky.m_scontacts.size() + sheet.m_scontacts.size(), 0);
  picky.answer = true;
  simulation.step(kStep);
  EXPECT_GT(picky.m_scontacts.size(), 0);
}

TEST_P(AppBodies, no_contact_response_means_as_much_as_in_bullet) {
  const auto contacts = [](PlugIn plug_in, int flag) {
    TwoSheets sheets(plug_in);
    sheets.add();
    sheets.lower().setCollisionFlags(sheets.lower().getCollisionFlags() | flag);
    const int count = sheets.step();
    sheets.lower().setCollisionFlags(sheets.lower().getCollisionFlags() & ~flag);
    EXPECT_EQ(sheets.step(), count);
    return count;
  };
  for (const int flag : {btCollisionObject::CF_NO_CONTACT_RESPONSE, btCollisionObject::CF_KINEMATIC_OBJECT,
                         btCollisionObject::CF_STATIC_OBJECT, btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK}) {
    EXPECT_EQ(contacts(GetParam(), flag), contacts(PlugIn::none, flag)) << "flag " << flag;
    EXPECT_GT(contacts(GetParam(), flag), 0) << "flag " << flag;
  }
}

TEST_P(AppBodies, a_box_without_contact_response_lets_a_cloth_through) {
  const auto height = [](PlugIn plug_in, bool responds) {
    ClothOnSheet scene(plug_in);
    scene.simulation.remove(*scene.sheet);
    btRigidBody& box = scene.simulation.add_static_box(btVector3(1, 1, 1), btVector3(0, -1, 0));
    if (!responds) box.setCollisionFlags(box.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
    scene.cloth->m_cfg.kKHR = 1;
    scene.run(30);
    return mean_height(*scene.cloth);
  };
  for (const bool responds : {true, false}) {
    const double bullets = double(height(PlugIn::none, responds));
    EXPECT_NEAR(double(height(GetParam(), responds)), bullets, 0.005);
    EXPECT_EQ(bullets > 0, responds);
  }
}

TEST_P(AppBodies, rigid_collision_can_be_switched_off_and_on_again) {
  TwoSheets sheets(GetParam());
  sheets.add();
  sheets.simulation().add_static_box(btVector3(1, 1, 1), btVector3(0, -1, 0));
  EXPECT_GT(sheets.step(), 0);
  EXPECT_GT(sheets.lower().m_rcontacts.size(), 0);
  for (btSoftBody* body : {&sheets.lower(), &sheets.upper()}) body->m_cfg.collisions = Flags::VF_SS;
  EXPECT_GT(sheets.step(), 0);
  EXPECT_EQ(sheets.lower().m_rcontacts.size(), 0);
  sheets.lower().m_cfg.collisions |= Flags::SDF_RS;
  EXPECT_GT(sheets.step(), 0);
  EXPECT_GT(sheets.lower().m_rcontacts.size(), 0);
}

/// Joints are there between detection and solver only.
struct JointCounts {
  const ClusteredBalls& clustered;
  std::vector<int> counts;

  static void append(btDynamicsWorld* world, btScalar) {
    auto& joints = *static_cast<JointCounts*>(world->getWorldUserInfo());
    for (const btSoftBody* ball : joints.clustered.balls) joints.counts.push_back(ball->m_joints.size());
  }
};

struct ClusterHistory {
  std::vector<int> joints;
  std::vector<btScalar> coordinates;
};

/// Clustered balls beside sheets that touch each other with VF_SS.
ClusterHistory cluster_history(PlugIn plug_in, int flags) {
  TwoSheets sheets(plug_in);
  sheets.add();
  const ClusteredBalls clustered(sheets.simulation(), flags);
  JointCounts joints{clustered, {}};
  sheets.simulation().world().setInternalTickCallback(JointCounts::append, &joints);
  for (int step = 0; step < 5; ++step) EXPECT_GT(sheets.step(), 0);
  std::vector<btScalar> coordinates;
  for (const btSoftBody* ball : clustered.balls) append(coordinates, coordinates_of(*ball));
  return {joints.counts, coordinates};
}

TEST_P(AppBodies, clusters_beside_vertex_face_bodies_have_bullets_joints) {
  for (const int flags : {int(Flags::CL_SS), int(Flags::CL_RS), Flags::CL_SS | Flags::CL_RS,
                          Flags::CL_SS | Flags::CL_RS | Flags::CL_SELF, Flags::CL_RS | Flags::VF_SS | Flags::CL_SELF}) {
    const ClusterHistory ours = cluster_history(GetParam(), flags);
    const ClusterHistory bullets = cluster_history(PlugIn::none, flags);
    EXPECT_EQ(ours.joints, bullets.joints) << "flags " << flags;
    EXPECT_EQ(ours.coordinates, bullets.coordinates) << "flags " << flags;
    EXPECT_GT(*std::max_element(bullets.joints.begin(), bullets.joints.end()), 0) << "flags " << flags;
  }
}

TEST_P(AppBodies, sleepers_stay_and_get_no_contacts) {
  ClothOnSheet scene(GetParam());
  scene.cloth->m_cfg.piterations = 0;
  scene.run(8);
  const int contacts = scene.cloth->m_scontacts.size();
  EXPECT_GT(contacts, 0);
  const btScalar height = mean_height(*scene.cloth);
  for (btSoftBody* body : {scene.sheet, scene.cloth}) body->forceActivationState(ISLAND_SLEEPING);
  scene.run(5);
  EXPECT_EQ(scene.cloth->m_scontacts.size(), contacts);
  EXPECT_EQ(mean_height(*scene.cloth), height);
}

TEST_P(AppBodies, an_active_neighbour_wakes_a_sleeper) {
  const auto height = [](PlugIn plug_in) {
    ClothOnSheet scene(plug_in);
    for (btSoftBody* body : {scene.sheet, scene.cloth}) body->forceActivationState(ISLAND_SLEEPING);
    scene.run(3);
    scene.sheet->activate(/*forceActivation=*/true);
    scene.run(2);
    EXPECT_TRUE(scene.cloth->isActive());
    scene.run(30);
    return mean_height(*scene.cloth);
  };
  expect_as_with_bullet(GetParam(), height, 0.005);
  EXPECT_GT(height(GetParam()), 0.05);
}

TEST_P(AppBodies, nodes_can_be_fixed_and_freed_at_run_time) {
  const auto height = [](PlugIn plug_in) {
    ClothOnSheet scene(plug_in);
    scene.run(10);
    btSoftBody::tNodeArray& nodes = scene.cloth->m_nodes;
    const int corner = nodes.size() - 1;
    scene.cloth->setMass(0, 0);
    nodes[0].m_v.setZero();
    const btVector3 held_at = nodes[0].m_x;
    scene.simulation.remove(*scene.sheet);
    scene.run(20);
    EXPECT_EQ(nodes[0].m_x, held_at);
    EXPECT_LT(nodes[corner].m_x.y(), 0);
    scene.cloth->setMass(0, 1 / nodes[corner].m_im);
    scene.run(10);
    EXPECT_LT(nodes[0].m_x.y(), held_at.y());
    return mean_height(*scene.cloth);
  };
  expect_as_with_bullet(GetParam(), height, 0.01);
}

// Whose nodes have no mass moves as its velocities say, and pushes.
TEST_P(AppBodies, a_body_of_fixed_nodes_pushes_as_with_bullet) {
  const auto height = [](PlugIn plug_in) {
    Simulation simulation(plug_in, cpu_settings());
    simulation.world_info().m_gravity.setZero();
    btSoftBody& cloth = simulation.add(make_sheet(simulation.world_info(), {}));
    auto made = demo::make_ball(simulation.world_info(), btVector3(0, btScalar(-0.6), 0), btScalar(0.4), 2);
    made->getCollisionShape()->setMargin(btScalar(0.05));
    btSoftBody& ball = simulation.add(std::move(made));
    for (int i = 0; i < ball.m_nodes.size(); ++i) ball.m_nodes[i].m_v = btVector3(0, 1, 0);
    for (int step = 0; step < 40; ++step) simulation.step(kStep);
    EXPECT_NEAR(double(mean_height(ball)), 40.0 / 60 - 0.6, 1e-3);
    return mean_height(cloth);
  };
  expect_as_with_bullet(GetParam(), height, 0.05);
  EXPECT_GT(height(GetParam()), 0.3);
}

TEST_P(AppBodies, contacts_share_the_correction_by_the_masses_of_the_step) {
  const auto nodes_share = [](PlugIn plug_in) {
    TwoSheets sheets(plug_in);
    sheets.add();
    sheets.step();
    const btScalar before = sheets.lower().m_scontacts[0].m_cfm[0];
    sheets.upper().setTotalMass(9);
    EXPECT_GT(sheets.step(), 0);
    EXPECT_NE(sheets.lower().m_scontacts[0].m_cfm[0], before);
    return sheets.lower().m_scontacts[0].m_cfm[0];
  };
  expect_as_with_bullet(GetParam(), nodes_share, 1e-5);
  EXPECT_NEAR(double(nodes_share(GetParam())), 0.9, 1e-5);  // times kSHR, which is 1
}

TEST_P(AppBodies, contacts_are_exact_after_every_transformation) {
  const auto turned = [](btScalar angle) { return btTransform(btQuaternion(btVector3(1, 1, 0).normalized(), angle)); };
  const auto scaled = [](btScalar factor) {
    return [=](btSoftBody& body) {
      body.scale(btVector3(factor, factor, factor));
      body.getCollisionShape()->setMargin(body.getCollisionShape()->getMargin() * factor);
    };
  };
  const std::function<void(btSoftBody&)> changes[] = {
      [&](btSoftBody& body) { body.transform(turned(btScalar(0.7))); },
      [&](btSoftBody& body) { body.rotate(btQuaternion(btVector3(0, 0, 1), 1)); },
      scaled(100),
      scaled(btScalar(0.001)),
      scaled(10),
      [](btSoftBody& body) { body.translate(btVector3(1000, -500, 200)); },
      [](btSoftBody& body) { body.translate(btVector3(-1000, 500, -200)); },
  };
  TwoSheets sheets(GetParam());
  sheets.add();
  for (const auto& change : changes) {
    for (btSoftBody* body : {&sheets.lower(), &sheets.upper()}) change(*body);
    sheets.step();
    expect_exact_contacts_between(sheets.lower(), sheets.upper());
  }
}

TEST_P(AppBodies, a_body_far_away_does_not_blur_the_others_contacts) {
  TwoSheets sheets(GetParam());
  sheets.add();
  SheetOptions options;
  options.height = 1000;
  btSoftBody& far_away = sheets.simulation().add(make_sheet(sheets.simulation().world_info(), options));
  sheets.step();
  expect_exact_contacts_between(sheets.lower(), sheets.upper());
  EXPECT_EQ(far_away.m_scontacts.size(), 0);
}

TEST_P(AppBodies, a_link_cut_at_run_time_is_noticed) {
  TwoSheets sheets(GetParam());
  sheets.add();
  sheets.step();
  const int faces = sheets.upper().m_faces.size();
  ASSERT_TRUE(sheets.upper().cutLink(40, 41, btScalar(0.4)));
  ASSERT_GT(sheets.upper().m_faces.size(), faces);
  sheets.step();
  expect_exact_contacts_between(sheets.lower(), sheets.upper());
}

TEST_P(AppBodies, a_body_comes_back_with_a_new_group_and_mask) {
  TwoSheets sheets(GetParam());
  sheets.add(/*group_a=*/1, /*mask_a=*/1);
  EXPECT_GT(sheets.step(), 0);
  btSoftBody& lower = sheets.lower();
  lower.m_scontacts.resize(0);
  auto upper = sheets.simulation().remove(sheets.upper());
  btSoftBody& again = sheets.simulation().add(std::move(upper), /*filter_group=*/2, /*filter_mask=*/-1);
  EXPECT_EQ(sheets.step(), 0);
  upper = sheets.simulation().remove(again);
  sheets.simulation().add(std::move(upper), /*filter_group=*/1, /*filter_mask=*/1);
  EXPECT_GT(sheets.step(), 0);
}

TEST_P(AppBodies, a_body_moves_to_another_world) {
  TwoSheets from(GetParam());
  TwoSheets to(GetParam());
  from.add();
  to.add();
  EXPECT_GT(from.step(), 0);
  EXPECT_GT(to.step(), 0);
  to.simulation().remove(to.upper()).reset();
  btSoftBody& moved = to.simulation().add(from.simulation().remove(from.upper()));
  from.simulation().step(kStep);
  to.simulation().step(kStep);
  EXPECT_EQ(from.lower().m_scontacts.size(), 0);
  expect_exact_contacts_between(to.lower(), moved);
}

}  // namespace
}  // namespace softcd::test
