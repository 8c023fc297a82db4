// Ropes are thrown at each other and at rigid meshes, over hundreds of steps. Crossings on the straight paths of a step
// are counted in exact arithmetic.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "any_simulation.hpp"
#include "exact_ccd.hpp"
#include "scenes/vectors.hpp"
#include "soft_body_steps.hpp"

namespace softcd::test {
namespace {

using bullet::EdgeContacts;

constexpr btScalar kFastMargin = btScalar(0.03);
constexpr int kLinks = 15;
constexpr int kFastSteps = 200;  // of 1/60 s

using Edge = std::array<std::size_t, 2>;

/// Edges and corners, and where they were when a step began and ended.
struct Way {
  std::vector<Edge> edges;
  std::vector<std::array<std::size_t, 3>> triangles;
  std::vector<Vec3d> x_t0, x_t1;
};

Way way_of(const btSoftBody& rope) {
  Way way;
  for (int i = 0; i < rope.m_links.size(); ++i) {
    const auto node = [&](int end) { return static_cast<std::size_t>(rope.m_links[i].m_n[end] - &rope.m_nodes[0]); };
    way.edges.push_back({node(0), node(1)});
  }
  way.x_t1 = positions_of(rope);
  return way;
}

void go_on(Way& way, const btSoftBody& rope) {
  way.x_t0 = std::exchange(way.x_t1, positions_of(rope));
}

/// Whether the boxes around both ways have a point in common.
bool are_near(std::span<const Vec3d, 8> rows, std::size_t first_of_b) {
  for (int axis = 0; axis < 3; ++axis) {
    double lo[2] = {1e300, 1e300};
    double hi[2] = {-1e300, -1e300};
    for (std::size_t i = 0; i < 8; ++i) {
      const int side = i % 4 < first_of_b ? 0 : 1;
      lo[side] = std::min(lo[side], rows[i][axis]);
      hi[side] = std::max(hi[side], rows[i][axis]);
    }
    if (lo[0] > hi[1] || lo[1] > hi[0]) return false;
  }
  return true;
}

/// Returns the number of feature pairs that touch during the step: an edge of a and one of b, or a vertex of a and a
/// triangle of b.
int count_passes(const Way& a, const Way& b) {
  int count = 0;
  std::array<Vec3d, 8> rows{};
  const auto set = [&](std::size_t row, const Way& way, std::size_t vertex) {
    rows[row] = way.x_t0[vertex];
    rows[row + 4] = way.x_t1[vertex];
  };
  for (const Edge& e : a.edges) {
    for (const Edge& g : b.edges) {
      for (std::size_t i = 0; i < 2; ++i) {
        set(i, a, e[i]);
        set(2 + i, b, g[i]);
      }
      count += are_near(rows, 2) && collides_edge_edge(rows) ? 1 : 0;
    }
  }
  for (std::size_t v = 0; v < a.x_t0.size(); ++v) {
    for (const auto& triangle : b.triangles) {
      set(0, a, v);
      for (std::size_t i = 0; i < 3; ++i) set(1 + i, b, triangle[i]);
      count += are_near(rows, 1) && collides_vertex_triangle(rows) ? 1 : 0;
    }
  }
  return count;
}

bullet::Settings rope_settings(EdgeContacts edge_contacts) {
  bullet::Settings settings = test_settings(Detection::ccd);
  settings.edge_contacts = edge_contacts;
  return settings;
}

/// Half a kilogram, straight.
std::unique_ptr<btSoftBody> make_rope(btSoftBodyWorldInfo& info, const btVector3& from, const btVector3& to) {
  std::vector<btVector3> nodes;
  for (int i = 0; i <= kLinks; ++i) nodes.push_back(from.lerp(to, btScalar(i) / btScalar(kLinks)));
  auto rope = std::make_unique<btSoftBody>(&info, kLinks + 1, nodes.data(), nullptr);
  for (int i = 0; i < kLinks; ++i) rope->appendLink(i, i + 1);
  rope->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
  rope->m_cfg.piterations = 10;
  rope->m_cfg.kDP = btScalar(0.02);
  rope->getCollisionShape()->setMargin(kFastMargin);
  rope->setTotalMass(btScalar(0.5));
  return rope;
}

/// The crossings in all steps, and the contacts that needed a response.
struct Count {
  int passes = 0;
  std::size_t contacts = 0;
};

/// One rope is thrown across another one that is held at its ends.
Count throw_at_rope(World world, EdgeContacts edge_contacts, btScalar speed) {
  AnySimulation simulation(world, rope_settings(edge_contacts));
  auto held = make_rope(simulation.world_info(), btVector3(-1, 0, 0), btVector3(1, 0, btScalar(0.1)));
  for (const int end : {0, kLinks}) held->setMass(end, 0);
  const btSoftBody& lower = simulation.add(std::move(held));
  btSoftBody& upper = simulation.add(
      make_rope(simulation.world_info(), btVector3(0, btScalar(0.3), -1), btVector3(btScalar(0.1), btScalar(0.4), 1)));
  upper.setVelocity(btVector3(0, -speed, 0));
  Way a = way_of(upper);
  Way b = way_of(lower);
  Count count;
  const auto look = [&] {
    go_on(a, upper);
    go_on(b, lower);
    count.passes += count_passes(a, b);
  };
  for (int step = 0; step < kFastSteps; ++step) {
    simulation.step([&](btScalar) { look(); });
    count.contacts += simulation.detection().edge_contacts().size();
  }
  look();
  return count;
}

/// A roof with its ridge along x, at height 0, which is closed below.
const std::array<btVector3, 6> kCorners = {{{-2, 0, 0}, {2, 0, 0}, {-2, -1, -1}, {2, -1, -1}, {-2, -1, 1}, {2, -1, 1}}};
constexpr std::array<std::array<std::size_t, 3>, 8> kTriangles = {
    {{0, 1, 3}, {0, 3, 2}, {0, 4, 5}, {0, 5, 1}, {2, 3, 5}, {2, 5, 4}, {0, 2, 4}, {1, 5, 3}}};

Way way_of_roof() {
  Way way;
  std::set<Edge> edges;
  for (const auto& t : kTriangles) {
    way.triangles.push_back(t);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(t[i], t[(i + 1) % 3]);
      edges.insert({low, high});
    }
  }
  way.edges.assign(edges.begin(), edges.end());
  for (const btVector3& corner : kCorners) way.x_t0.push_back(demo::to_vec3d(corner));
  way.x_t1 = way.x_t0;
  return way;
}

/// A rope is thrown across the ridge.
Count throw_at_roof(World world, EdgeContacts edge_contacts, btScalar speed) {
  btTriangleMesh mesh;
  for (const auto& t : kTriangles) mesh.addTriangle(kCorners[t[0]], kCorners[t[1]], kCorners[t[2]]);
  AnySimulation simulation(world, rope_settings(edge_contacts));
  auto shape = std::make_unique<btBvhTriangleMeshShape>(&mesh, true);
  shape->setMargin(kFastMargin);
  simulation.add_rigid(std::move(shape), btVector3(0, 0, 0));
  btSoftBody& rope = simulation.add(make_rope(simulation.world_info(), btVector3(btScalar(0.1), btScalar(0.3), -1),
                                              btVector3(btScalar(0.2), btScalar(0.4), 1)));
  rope.setVelocity(btVector3(0, -speed, 0));
  const Way roof = way_of_roof();
  Way way = way_of(rope);
  Count count;
  const auto look = [&] {
    go_on(way, rope);
    count.passes += count_passes(way, roof);
  };
  for (int step = 0; step < kFastSteps; ++step) {
    simulation.step([&](btScalar) { look(); });
    count.contacts += static_cast<std::size_t>(AnySimulation::count_contacts(rope));
  }
  look();
  return count;
}

class FastRopes : public testing::TestWithParam<World> {
 protected:
  static void expect_no_passes(Count (*throw_rope)(World, EdgeContacts, btScalar)) {
    for (const btScalar speed : {btScalar(1), btScalar(3), btScalar(10), btScalar(30), btScalar(100)}) {
      const Count count = throw_rope(GetParam(), EdgeContacts::respond, speed);
      EXPECT_EQ(count.passes, 0) << speed << " m/s";
      EXPECT_GT(count.contacts, 0U) << speed << " m/s";
    }
    EXPECT_GT(throw_rope(GetParam(), EdgeContacts::off, 10).passes, 0) << "where nobody answers";
  }
};
// A softcd::bullet::Dispatcher prevents no crossings.
INSTANTIATE_TEST_SUITE_P(Worlds, FastRopes, kLookingWorlds, world_name);

TEST_P(FastRopes, never_pass_through_each_other) {
  expect_no_passes(throw_at_rope);
}

TEST_P(FastRopes, never_pass_through_a_rigid_mesh) {
  expect_no_passes(throw_at_roof);
}

}  // namespace
}  // namespace softcd::test
