// Nodes that have passed through a face within the step get contacts that push them back.

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "scenes/soft_ball.hpp"
#include "still_sheets.hpp"

namespace softcd::test {
namespace {

/// Returns the normals' heights of the contacts of a sheet with a sheet at rest. The sheet begins the step at this
/// height, and moves like this in the step. Nodes beside the sheet at rest, whose normals are slanted, do not count.
std::vector<btScalar> normals_of_moving_sheet(Contacts contacts, btScalar height, const btVector3& motion,
                                              btScalar shift = 0) {
  Still still(settings_choosing(contacts));
  still.add(flat(0));
  btSoftBody& moving = still.add(flat(height, shift));
  moving.setVelocity(motion / kStep);
  moving.m_cfg.kDP = 0;
  still.step();
  std::vector<btScalar> heights;
  for (int i = 0; i < moving.m_scontacts.size(); ++i) {
    const btScalar along_y = moving.m_scontacts[i].m_normal.y();
    if (btFabs(along_y) > btScalar(0.99)) heights.push_back(along_y);
  }
  return heights;
}

TEST(ContactEconomy, what_moves_sideways_or_away_beyond_the_margins_gets_no_contact) {
  const btVector3 motions[] = {{btScalar(0.05), 0, 0}, {0, btScalar(0.05), 0}, {0, btScalar(-0.05), 0}};
  for (const btVector3& motion : motions) {
    for (const Contacts contacts : {Contacts::all, Contacts::closest_feature}) {
      const auto given = normals_of_moving_sheet(contacts, btScalar(0.13) - motion.y(), motion).size();
      if (motion.y() < 0) {
        EXPECT_GE(given, static_cast<std::size_t>((kNodes - 1) * (kNodes - 1))) << "it comes closer";
      } else {
        EXPECT_EQ(given, 0U) << "it moves sideways or away";
      }
    }
  }
}

TEST(ContactEconomy, pushes_nodes_back_that_have_passed_through_another_body) {
  const auto is_up = [](btScalar height) { return height > 0; };
  const auto is_down = [](btScalar height) { return height < 0; };
  for (const btScalar shift : {btScalar(0), kCell / 4, kCell / 2}) {  // over corners, in faces, over diagonals
    const auto all_are = [&](auto predicate, Contacts contacts, btScalar from, btScalar to) {
      const auto heights = normals_of_moving_sheet(contacts, from, btVector3(0, to - from, 0), shift);
      return heights.size() >= (kNodes - 1) * (kNodes - 1) && std::all_of(heights.begin(), heights.end(), predicate);
    };
    const btScalar height = btScalar(0.03);
    EXPECT_TRUE(all_are(is_up, Contacts::closest_feature, height, -height)) << shift << ", through, downwards";
    EXPECT_TRUE(all_are(is_down, Contacts::closest_feature, -height, height)) << shift << ", through, upwards";
    EXPECT_TRUE(all_are(is_up, Contacts::closest_feature, height, height / 2)) << shift << ", above";
    EXPECT_TRUE(all_are(is_down, Contacts::closest_feature, -height, -height / 2)) << shift << ", below";
    EXPECT_TRUE(all_are(is_down, Contacts::all, height, -height)) << shift << ", Bullet's own rule";
  }
}

/// A sheet that is bent down on both sides of the line x = 4 * kCell.
demo::ClothShape bent_sheet() {
  demo::ClothShape shape = flat(0);
  shape.position = [on = shape.position](int column, int row) {
    btVector3 x = on(column, row);
    x.setY(-btFabs(x.x() - kCell * btScalar(4)));
    return x;
  };
  return shape;
}

// Nodes that pass through one slope close to the ridge end above the ridge, as near to one slope as to the other.
TEST(ContactEconomy, pushes_nodes_back_that_end_near_another_face_than_they_have_passed_through) {
  for (const btScalar beside : {btScalar(-0.002), btScalar(0.002)}) {
    Still still(settings_choosing(Contacts::closest_feature));
    still.add(bent_sheet());
    demo::ClothShape below = bent_sheet();
    below.position = [=, on = below.position](int column, int row) {
      return on(column, row) + btVector3(beside, btScalar(-0.03), kCell / 4);
    };
    btSoftBody& moving = still.add(below);
    moving.setVelocity(btVector3(0, btScalar(0.06), 0) / kStep);
    moving.m_cfg.kDP = 0;
    still.step();
    int pushed_down = 0;
    for (int i = 0; i < moving.m_scontacts.size(); ++i) {
      const SContact& contact = moving.m_scontacts[i];
      const auto node = contact.m_node - &moving.m_nodes[0];
      if (node % kNodes != 4 || node / kNodes == kNodes - 1) continue;  // not over the ridge
      EXPECT_LT(contact.m_normal.y(), 0) << "beside the ridge by " << beside;
      ++pushed_down;
    }
    EXPECT_GE(pushed_down, kNodes - 1);
  }
}

// Contacts would push some nodes of sheets that are through each other to one side, and others to the other side.
TEST(ContactEconomy, leaves_nodes_alone_where_their_edges_start_through_the_face) {
  constexpr int kLastBelow = 3;
  Still still(settings_choosing(Contacts::closest_feature));
  still.add(flat(0));
  demo::ClothShape stair = flat(0);
  stair.position = [on = stair.position](int column, int row) {
    return on(column, row) + btVector3(kCell / 4, btScalar(column <= kLastBelow ? -0.01 : 0.05), kCell / 8);
  };
  btSoftBody& moving = still.add(stair);
  moving.setVelocity(btVector3(0, btScalar(0.02), 0) / kStep);
  moving.m_cfg.kDP = 0;
  still.step();
  int pushed_back = 0;
  for (int i = 0; i < moving.m_scontacts.size(); ++i) {
    const SContact& contact = moving.m_scontacts[i];
    const auto column = (contact.m_node - &moving.m_nodes[0]) % kNodes;
    if (column > kLastBelow || btFabs(contact.m_normal.y()) < btScalar(0.99)) continue;
    EXPECT_LT(column, kLastBelow);
    EXPECT_LT(contact.m_normal.y(), 0) << "column " << column;
    ++pushed_back;
  }
  EXPECT_GE(pushed_back, kLastBelow * (kNodes - 1));
}

/// Returns the greatest kinetic energy of two cloths that start through each other, at rest and without gravity.
double energy_of_crossed_cloths(Contacts contacts) {
  demo::SoftWorld world(demo::World::classic, PlugIn::one_line_world, settings_choosing(contacts));
  world.set_gravity(btVector3(0, 0, 0));
  for (const bool is_upright : {false, true}) {
    auto cloth = demo::make_cloth(world.world_info(), demo::horizontal_cloth(13, 1, 0), 1);
    if (is_upright) cloth->rotate(btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI));
    if (is_upright) cloth->translate(btVector3(btScalar(0.01), btScalar(0.03), btScalar(0.02)));
    cloth->getCollisionShape()->setMargin(btScalar(0.03));
    cloth->m_cfg.piterations = 4;
    world.add(std::move(cloth));
  }
  double most = 0;
  for (int step = 0; step < 120; ++step) {
    world.step();
    double energy = 0;
    for (const btSoftBody* body : world.bodies()) {
      for (int i = 0; i < body->m_nodes.size(); ++i) {
        energy += double(body->m_nodes[i].m_v.length2()) / double(body->m_nodes[i].m_im) / 2;
      }
    }
    most = std::max(most, energy);
  }
  return most;
}

TEST(ContactEconomy, cloths_that_start_through_each_other_stay_at_rest) {
  EXPECT_GT(energy_of_crossed_cloths(Contacts::all), 0.1) << "Bullet's own rule";
  EXPECT_LT(energy_of_crossed_cloths(Contacts::closest_feature), 0.05);
}

TEST(ContactEconomy, pushes_nodes_out_of_closed_bodies_whichever_way_they_go) {
  for (const btScalar from : {btScalar(1.9), btScalar(2.1)}) {
    Still still(settings_choosing(Contacts::closest_feature));
    auto ball = demo::make_soft_ball(still.simulation().world_info(), demo::World::classic,
                                     {{0, 0, 0}, /*radius=*/2, /*subdivisions=*/3, /*mass=*/1, kThickness});
    ball->m_cfg.piterations = 0;
    still.simulation().add(std::move(ball));
    demo::ClothShape patch;
    patch.columns = patch.rows = 3;
    patch.position = [=](int column, int row) {
      return btVector3(btScalar(0.05) + btScalar(0.02) * btScalar(column), from, btScalar(0.02) * btScalar(row));
    };
    btSoftBody& moving = still.add(patch);
    moving.setVelocity(btVector3(0, 2 * (2 - from), 0) / kStep);
    moving.m_cfg.kDP = 0;
    still.step();
    EXPECT_GE(moving.m_scontacts.size(), 9) << "from " << from;
    for (int i = 0; i < moving.m_scontacts.size(); ++i) {
      EXPECT_GT(moving.m_scontacts[i].m_normal.y(), btScalar(0.5)) << "from " << from;
    }
  }
}

}  // namespace
}  // namespace softcd::test
