#include "scenes/penetration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "scenes/surface_mesh.hpp"

namespace softcd::test {
namespace {

using demo::find_intersections;
using demo::Intersections;
using demo::SurfaceMesh;

class Penetration : public testing::Test {
 protected:
  std::unique_ptr<btSoftBody> make(const SurfaceMesh& mesh) { return demo::make_body(world_info_, mesh, 1); }

  static long marked(const Intersections& found, std::size_t body) {
    return std::count(found.vertices[body].begin(), found.vertices[body].end(), true);
  }

  btSoftBodyWorldInfo world_info_;
};

TEST_F(Penetration, an_edge_through_a_triangle_is_counted_once) {
  const auto floor = make({{{0, 0, 0}, {4, 0, 0}, {0, 0, 4}, {-4, 0, 4}}, {{0, 2, 1}, {0, 3, 2}}});
  // Its first edge goes through the edge that the floor's triangles share.
  const auto fin = make({{{0, 1, 1}, {0, -1, 1}, {2, 1, 1}}, {{0, 1, 2}}});
  const Intersections found = find_intersections({floor.get(), fin.get()});
  EXPECT_EQ(found.edge_count, 2U + 1U) << "the shared edge, through the fin, and two of the fin's";
  EXPECT_EQ(marked(found, 0), 2);
  EXPECT_EQ(marked(found, 1), 3);
}

TEST_F(Penetration, what_rests_or_is_joined_is_not_counted) {
  const auto ball = make(demo::sphere_mesh(btVector3(0, 2, 0), 1, 2));
  const auto floor = make({{{-9, 0, -9}, {9, 0, -9}, {0, 0, 9}}, {{0, 2, 1}}});
  EXPECT_EQ(find_intersections({ball.get(), floor.get()}).edge_count, 0U);
}

TEST_F(Penetration, a_body_that_folds_through_itself_is_counted) {
  auto strip = make({{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}, {0, 0, 2}, {1, 0, 2}},
                     {{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}}});
  EXPECT_EQ(find_intersections({strip.get()}).edge_count, 0U);
  strip->m_nodes[4].m_x = btVector3(btScalar(0.2), btScalar(0.3), btScalar(0.3));
  strip->m_nodes[5].m_x = btVector3(btScalar(0.4), btScalar(-0.3), btScalar(0.2));
  EXPECT_GT(find_intersections({strip.get()}).edge_count, 0U);
}

TEST_F(Penetration, positions_that_are_not_finite_take_no_part) {
  auto ball = make(demo::sphere_mesh(btVector3(0, 0, 0), 1, 1));
  const auto other = make(demo::sphere_mesh(btVector3(btScalar(1.2), 0, 0), 1, 1));
  EXPECT_GT(find_intersections({ball.get(), other.get()}).edge_count, 0U);
  for (int i = 0; i < ball->m_nodes.size(); ++i) ball->m_nodes[i].m_x.setX(std::numeric_limits<btScalar>::infinity());
  EXPECT_EQ(find_intersections({ball.get(), other.get()}).edge_count, 0U);
}

TEST_F(Penetration, inside_and_below) {
  const auto ball = make(demo::sphere_mesh(btVector3(0, 0, 0), 1, 2));
  EXPECT_TRUE(demo::is_inside(*ball, btVector3(btScalar(0.9), 0, 0)));
  EXPECT_FALSE(demo::is_inside(*ball, btVector3(btScalar(1.1), 0, 0)));
  // A torus-like bowl: its hollow is outside.
  const auto bowl = make(demo::lathe_mesh({{0, 0}, {2, 0}, {2, 2}, {1, 2}, {1, 1}, {0, 1}}, 12));
  EXPECT_TRUE(demo::is_inside(*bowl, btVector3(btScalar(1.5), btScalar(1.5), 0)));
  EXPECT_FALSE(demo::is_inside(*bowl, btVector3(0, btScalar(1.5), 0)));

  const auto little = make(demo::sphere_mesh(btVector3(btScalar(0.1), 0, 0), btScalar(0.2), 0));
  std::vector<bool> marked(12, false);
  demo::mark_inside(*bowl, *little, marked);
  EXPECT_GT(std::count(marked.begin(), marked.end(), true), 0);
  EXPECT_LT(std::count(marked.begin(), marked.end(), true), 12);
}

}  // namespace
}  // namespace softcd::test
