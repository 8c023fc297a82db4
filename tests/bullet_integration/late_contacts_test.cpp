// Contacts that Bullet's solver leaves behind: later bodies have pushed earlier ones through each other.

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "any_simulation.hpp"
#include "native/arrays.hpp"
#include "scenes/penetration.hpp"
#include "scenes/soft_world.hpp"
#include "still_sheets.hpp"

namespace softcd::test {
namespace {

/// Returns the number of frames of a second in which edges of a pile of sheets that fall on a floor and on each other
/// intersect triangles. The first sheet of the world is the lowest one, or the highest.
int frames_with_crossings(const bullet::Settings& settings, int start, bool is_built_upwards) {
  demo::SoftWorld world(demo::World::classic, PlugIn::one_line_world, settings);
  world.add_rigid(std::make_unique<btBoxShape>(btVector3(20, 1, 20)), btVector3(0, -1, 0));
  constexpr int kSheets = 4;
  for (int i = 0; i < kSheets; ++i) {
    const int layer = is_built_upwards ? i : kSheets - 1 - i;
    const btScalar height = btScalar(0.3) + btScalar(0.4) * btScalar(layer) + btScalar(1e-3) * btScalar(start);
    auto sheet = demo::make_cloth(world.world_info(), demo::horizontal_cloth(11 + layer % 3, 1, height), btScalar(0.3));
    sheet->getCollisionShape()->setMargin(btScalar(0.03));
    sheet->m_cfg.kDF = btScalar(0.5);
    sheet->m_cfg.piterations = 4;
    sheet->rotate(btQuaternion(btVector3(0, 1, 0), btScalar(layer) / 2));
    world.add(std::move(sheet));
  }
  int frames = 0;
  for (int step = 0; step < 60; ++step) {
    world.step(kStep);
    const auto are_two = [](const btSoftBody& a, const btSoftBody& b) { return &a != &b; };
    const demo::Intersections found = demo::find_intersections({world.bodies().begin(), world.bodies().end()}, are_two);
    frames += found.edge_count > 0 ? 1 : 0;
  }
  return frames;
}

TEST(LateContacts, keep_sheets_from_being_pushed_through_each_other_by_the_next_one) {
  for (const bool is_built_upwards : {true, false}) {
    int frames = 0;
    for (int start = 0; start < 4; ++start) {
      frames += frames_with_crossings(settings_choosing(Contacts::closest_feature), start, is_built_upwards);
    }
    EXPECT_EQ(frames, 0) << "in four starts; built upwards: " << is_built_upwards;
  }
}

/// Adds three sheets above each other, the lowest first. The highest is heavy, and pushes the middle one down.
std::vector<btSoftBody*> add_pressed_sheets(AnySimulation& simulation) {
  std::vector<btSoftBody*> sheets;
  for (int i = 0; i < 3; ++i) {
    SheetOptions options;
    options.height = btScalar(0.06) * btScalar(i);
    sheets.push_back(&simulation.add(make_sheet(simulation.world_info(), options)));
  }
  sheets[2]->setTotalMass(50);
  sheets[2]->setVelocity(btVector3(0, -10, 0));
  return sheets;
}

TEST(LateContacts, leave_the_normals_of_all_nodes_as_their_faces_are) {
  AnySimulation simulation(World::one_line, settings_choosing(Contacts::closest_feature));
  const std::vector<btSoftBody*> sheets = add_pressed_sheets(simulation);
  sheets[2]->rotate(btQuaternion(btVector3(1, 0, 0), btScalar(0.05)));  // so that sheets bend
  for (int step = 0; step < 10; ++step) {
    simulation.step_once();
    for (btSoftBody* sheet : sheets) {
      std::vector<btVector3> normals;
      for (const btSoftBody::Node& node : bullet::span_of(sheet->m_nodes)) normals.push_back(node.m_n);
      sheet->updateNormals();
      for (int i = 0; i < sheet->m_nodes.size(); ++i) {
        ASSERT_EQ(sheet->m_nodes[i].m_n, normals[static_cast<std::size_t>(i)]) << "node " << i << ", step " << step;
      }
    }
  }
}

/// Returns whether nodes of the lowest of three sheets move when an attached world ends its step, which it does after
/// the app's turn. The app may remove the middle one.
bool moves_lowest_sheet_late(bool removes_middle) {
  const bullet::Settings settings = settings_choosing(Contacts::closest_feature);
  AnySimulation simulation(World::attached, settings);
  const std::vector<btSoftBody*> sheets = add_pressed_sheets(simulation);
  simulation.world().stepSimulation(kStep, 0);
  std::vector<btVector3> places;
  for (const btSoftBody::Node& node : bullet::span_of(sheets[0]->m_nodes)) places.push_back(node.m_x);
  if (removes_middle) simulation.remove(*sheets[1]).reset();
  simulation.attach_again(settings);  // detaching ends the step
  bool moves = false;
  for (int i = 0; i < sheets[0]->m_nodes.size(); ++i) {
    moves |= sheets[0]->m_nodes[i].m_x != places[static_cast<std::size_t>(i)];
  }
  return moves;
}

TEST(LateContacts, with_a_body_that_is_removed_before_the_end_of_the_step_are_left_out) {
  EXPECT_TRUE(moves_lowest_sheet_late(/*removes_middle=*/false));
  EXPECT_FALSE(moves_lowest_sheet_late(/*removes_middle=*/true));
}

}  // namespace
}  // namespace softcd::test
