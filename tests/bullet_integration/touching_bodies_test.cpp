// Bodies that touch at the start of a step, at distances of exactly 0. They are free to separate and to slide, and
// bodies that touch from one side stay on it. Bodies that intersect by such touches alone are released like other
// intersecting bodies.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "soft_body_steps.hpp"
#include "warned_simulation.hpp"

namespace softcd::test {
namespace {

/// All coordinates are small multiples of powers of two, so that bodies touch exactly.
class TouchingBodies : public WarnedSimulation {
 protected:
  using Shape = std::function<btVector3(btScalar x, btScalar z)>;
  btSoftBody& add_cloth(int nodes_per_side, btScalar side, const Shape& shape, bool fixed = false) {
    demo::ClothShape cloth = demo::horizontal_cloth(nodes_per_side, side, 0);
    cloth.position = [flat = cloth.position, shape](int column, int row) {
      const btVector3 x = flat(column, row);
      return shape(x.x(), x.z());
    };
    if (fixed) cloth.is_fixed = [](int, int) { return true; };
    auto body = demo::make_cloth(simulation.world_info(), cloth, 1);
    body->getCollisionShape()->setMargin(btScalar(0.001));
    return simulation.add(std::move(body));
  }
  btSoftBody& add_floor() {
    return add_cloth(
        9, 2, [](btScalar x, btScalar z) { return btVector3(x, 0, z); }, /*fixed=*/true);
  }
  /// On the floor, whose nodes its own are between.
  btSoftBody& add_flat() {
    const btScalar off = btScalar(0.0625);
    return add_cloth(5, 1, [off](btScalar x, btScalar z) { return btVector3(x + off, 0, z + off); });
  }
  /// Stands on the floor with the row in its middle.
  btSoftBody& add_valley() {
    return add_cloth(5, 1, [](btScalar x, btScalar z) { return btVector3(x, btFabs(x) / 2, z); });
  }
  /// Upright, with the row in its middle in the floor.
  btSoftBody& add_upright() {
    return add_cloth(5, 1, [](btScalar x, btScalar z) { return btVector3(0, x, z); });
  }

  void step(btSoftBody& pushed, const btVector3& velocity, int count) {
    for (int i = 0; i < count; ++i) {
      simulation.step([&](btScalar) {
        for (int n = 0; n < pushed.m_nodes.size(); ++n) pushed.m_nodes[n].m_v = velocity;
      });
    }
  }
  static btVector3 center(const btSoftBody& body) {
    btVector3 sum(0, 0, 0);
    for (int n = 0; n < body.m_nodes.size(); ++n) sum += body.m_nodes[n].m_x;
    return sum / btScalar(body.m_nodes.size());
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, TouchingBodies, kLookingWorlds, world_name);

TEST_P(TouchingBodies, in_one_plane_come_apart) {
  btSoftBody& floor = add_floor();
  btSoftBody& cloth = add_flat();
  EXPECT_GT(count_edges({&floor, &cloth}), 0U);
  step(cloth, btVector3(0, 1, 0), 6);
  EXPECT_EQ(count_edges({&floor, &cloth}), 0U);
  EXPECT_NEAR(center(cloth).y(), 0.1, 0.01);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(TouchingBodies, in_one_plane_slide) {
  add_floor();
  btSoftBody& cloth = add_flat();
  const btVector3 start = center(cloth);
  step(cloth, btVector3(0, 0, 1), 6);
  EXPECT_NEAR((center(cloth) - start).z(), 0.1, 0.01);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(TouchingBodies, on_one_side_come_apart) {
  btSoftBody& floor = add_floor();
  btSoftBody& cloth = add_valley();
  const btScalar start = center(cloth).y();
  step(cloth, btVector3(0, 1, 0), 6);
  EXPECT_EQ(count_edges({&floor, &cloth}), 0U);
  EXPECT_NEAR(center(cloth).y() - start, 0.1, 0.01);
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

TEST_P(TouchingBodies, on_one_side_stay_there_when_they_are_pressed_together) {
  btSoftBody& floor = add_floor();
  btSoftBody& cloth = add_valley();
  step(cloth, btVector3(0, -1, 0), 10);
  step(cloth, btVector3(0, 1, 0), 20);
  EXPECT_EQ(count_edges({&floor, &cloth}), 0U);
  for (int n = 0; n < cloth.m_nodes.size(); ++n) EXPECT_GT(cloth.m_nodes[n].m_x.y(), 0) << "node " << n;
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

class TouchingUnderADispatcher : public TouchingBodies {};
INSTANTIATE_TEST_SUITE_P(Worlds, TouchingUnderADispatcher, testing::Values(World::dispatcher), world_name);

// This world prevents no crossings: it has contacts only.
TEST_P(TouchingUnderADispatcher, have_contacts) {
  add_floor();
  const btSoftBody& cloth = add_valley();
  simulation.world_info().m_gravity = btVector3(0, btScalar(-10), 0);
  simulation.step();
  EXPECT_GT(cloth.m_scontacts.size(), 0);
}

TEST_P(TouchingBodies, that_are_through_each_other_there_come_apart) {
  btSoftBody& floor = add_floor();
  btSoftBody& cloth = add_upright();
  EXPECT_GT(count_edges({&floor, &cloth}), 0U);
  step(cloth, btVector3(0, 1, 0), 90);
  EXPECT_EQ(count_edges({&floor, &cloth}), 0U);
  EXPECT_GT(center(cloth).y(), btScalar(0.5)) << "above the floor";
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("soft bodies 0 and 1 "), std::string::npos) << warnings[0];
}

/// A cloth that touches the floor, and one that intersects it, many times: Bullet solves contacts of deformable bodies
/// in a different order each time.
class TouchingBodiesAgain : public TouchingBodies {
 protected:
  template <class Visit>
  void simulate_again(int times, int steps, Visit visit_step) {
    add_floor();
    for (int time = 0; time < times; ++time) {
      std::vector<btSoftBody*> cloths = {&add_valley(), &add_upright()};
      for (int i = 0; i < steps; ++i) {
        simulation.step();
        visit_step(cloths);
      }
      for (btSoftBody* cloth : cloths) simulation.remove(*cloth);
    }
  }
  /// Kinetic, and potential in the gravity.
  static double energy(const btSoftBody& body, const btVector3& gravity) {
    double sum = 0;
    for (int n = 0; n < body.m_nodes.size(); ++n) {
      const btSoftBody::Node& node = body.m_nodes[n];
      sum += double(node.m_v.length2() / 2 - gravity.dot(node.m_x)) / double(node.m_im);
    }
    return sum;
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, TouchingBodiesAgain, kLookingWorlds, world_name);

TEST_P(TouchingBodiesAgain, get_no_energy_when_nothing_moves_them) {
  double most_energy = 0;
  btScalar fastest = 0;
  simulate_again(2, 5, [&](const std::vector<btSoftBody*>& cloths) {
    most_energy = std::max(most_energy, simulation.detection().crossing_answers().energy);
    for (const btSoftBody* cloth : cloths) {
      for (int n = 0; n < cloth->m_nodes.size(); ++n) fastest = btMax(fastest, cloth->m_nodes[n].m_v.length());
    }
  });
  EXPECT_LT(most_energy, 1e-6);
  EXPECT_LT(fastest, btScalar(0.1));
}

TEST_P(TouchingBodiesAgain, get_no_more_energy_than_gravity_gives_them) {
  const btVector3 gravity(0, btScalar(-10), 0);
  simulation.set_gravity(gravity);
  btSoftBody* const still[] = {&add_valley(), &add_upright()};
  const double start = energy(*still[0], gravity) + energy(*still[1], gravity);
  for (btSoftBody* cloth : still) simulation.remove(*cloth);
  double most = start;
  simulate_again(5, 30, [&](const std::vector<btSoftBody*>& cloths) {
    most = std::max(most, energy(*cloths[0], gravity) + energy(*cloths[1], gravity));
  });
  EXPECT_LT(most, start + 1e-3);
}

/// Bodies at distances below every rounding. They do not touch, so they have sides, and must stay on them.
class NearlyTouchingBodies : public TouchingBodies {
 protected:
  btSoftBody& add_flat_at(int nodes_per_side, btScalar shift, btScalar height) {
    return add_cloth(nodes_per_side, 1,
                     [=](btScalar x, btScalar z) { return btVector3(x + shift, height, z + shift); });
  }
  /// Throws a cloth at the floor, whose border alone is held if `is_drum`. Returns the number of steps in which a node
  /// meets a face, or that end with an edge in a face.
  int throw_at_floor(btSoftBody& floor, btSoftBody& cloth, btScalar speed, btScalar step_length, bool is_drum) {
    for (int n = 0; n < floor.m_nodes.size(); ++n) {
      const btVector3& x = floor.m_nodes[n].m_x;
      if (is_drum && btMax(btFabs(x.x()), btFabs(x.z())) < 1) floor.setMass(n, 16);
    }
    cloth.setVelocity(btVector3(0, -speed, 0));
    CrossingFinder finder({&floor, &cloth});
    int crossed = 0;
    for (int i = 0; i < 12; ++i) {
      simulation.step(step_length);
      const bool is_passed = !finder.find().empty();
      crossed += is_passed || count_edges({&floor, &cloth}) > 0 ? 1 : 0;
    }
    return crossed;
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, NearlyTouchingBodies, kLookingWorlds, world_name);

// With and without contacts that push them apart.
TEST_P(NearlyTouchingBodies, stay_on_their_sides) {
  for (const bool is_drum : {false, true}) {
    for (const btScalar shift : {btScalar(0), btScalar(0.03125), btScalar(0.625)}) {
      for (const int iterations : {0, 4}) {
        SCOPED_TRACE(testing::Message() << is_drum << ' ' << shift << ' ' << iterations);
        btSoftBody& floor = add_floor();
        btSoftBody& cloth = add_flat_at(6, shift, btScalar(0x1p-54));
        floor.m_cfg.piterations = cloth.m_cfg.piterations = iterations;
        EXPECT_EQ(throw_at_floor(floor, cloth, 20, btScalar(1) / 240, is_drum), 0);
        EXPECT_TRUE(warnings.empty()) << warnings[0];
        warnings.clear();
        simulation.remove(floor);
        simulation.remove(cloth);
      }
    }
  }
}

class NearlyTouchingInTheClassicWorld : public NearlyTouchingBodies {};
INSTANTIATE_TEST_SUITE_P(Worlds, NearlyTouchingInTheClassicWorld, testing::Values(World::one_line), world_name);

TEST_P(NearlyTouchingInTheClassicWorld, have_contacts) {
  add_floor();
  const btSoftBody& cloth = add_flat_at(6, btScalar(0.03125), btScalar(0x1p-54));
  simulation.step();
  EXPECT_GT(cloth.m_scontacts.size(), 0);
}

// In double precision the cloth ends a step 2^-53 m above the floor.
TEST_P(NearlyTouchingBodies, that_a_step_brings_there_do_not_pass) {
  for (const btScalar shift : {btScalar(0), btScalar(0.5), btScalar(0.53)}) {
    btSoftBody& floor = add_floor();
    btSoftBody& cloth = add_flat_at(11, shift, btScalar(0.5));
    EXPECT_EQ(throw_at_floor(floor, cloth, 20, btScalar(1) / 240, /*is_drum=*/true), 0) << shift;
    simulation.remove(floor);
    simulation.remove(cloth);
  }
  EXPECT_TRUE(warnings.empty()) << warnings[0];
}

}  // namespace
}  // namespace softcd::test
