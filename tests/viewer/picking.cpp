#include "viewer/picking.hpp"

#include <gtest/gtest.h>

#include "viewer/session.hpp"

namespace softcd::demo {
namespace {

constexpr Vec3d kA = {0, 0, 0};
constexpr Vec3d kB = {2, 0, 0};
constexpr Vec3d kC = {0, 2, 0};

TEST(DistanceToTriangle, is_found_from_both_sides) {
  EXPECT_EQ(distance_to_triangle({{0.5, 0.5, 3}, {0, 0, -1}}, kA, kB, kC), 3);
  EXPECT_EQ(distance_to_triangle({{0.5, 0.5, -4}, {0, 0, 1}}, kA, kB, kC), 4);
}

TEST(DistanceToTriangle, is_none_beside_behind_and_along) {
  EXPECT_FALSE(distance_to_triangle({{1.2, 1.2, 3}, {0, 0, -1}}, kA, kB, kC));
  EXPECT_FALSE(distance_to_triangle({{-0.1, 0.5, 3}, {0, 0, -1}}, kA, kB, kC));
  EXPECT_FALSE(distance_to_triangle({{0.5, -0.1, 3}, {0, 0, -1}}, kA, kB, kC));
  EXPECT_FALSE(distance_to_triangle({{0.5, 0.5, 3}, {0, 0, 1}}, kA, kB, kC));
  EXPECT_FALSE(distance_to_triangle({{0.5, 0.5, 0}, {1, 0, 0}}, kA, kB, kC));
  EXPECT_FALSE(distance_to_triangle({{0.5, 0.5, 3}, {0, 0, -1}}, kA, kB, kB));
}

TEST(MeetPlane, is_none_behind_and_along) {
  const auto met = meet_plane({{1, 2, 3}, {0, 0, -1}}, {5, 5, 1}, {0, 0, 1});
  ASSERT_TRUE(met);
  EXPECT_EQ(*met, (Vec3d{1, 2, 1}));
  EXPECT_FALSE(meet_plane({{1, 2, 3}, {0, 0, 1}}, {5, 5, 1}, {0, 0, 1}));
  EXPECT_FALSE(meet_plane({{1, 2, 3}, {1, 0, 0}}, {5, 5, 1}, {0, 0, 1}));
}

class Picking : public testing::Test {
 protected:
  Picking() : session_("two-cloths", small()) {}

  static SceneOptions small() {
    SceneOptions options;
    options.size = 8;
    options.settings.backend = Backend::cpu;
    return options;
  }

  Session session_;
};

// The second body falls onto the first, whose border is held.
TEST_F(Picking, takes_the_first_face_on_the_ray) {
  const Ray down = {{0.1, 10, 0.2}, {0, -1, 0}};
  const auto upper = pick_face(session_.bodies(), down);
  ASSERT_TRUE(upper);
  EXPECT_EQ(upper->body, 1U);
  EXPECT_NEAR(upper->position.y, 3.3, 1e-5);
  const auto lower = pick_face(session_.bodies(), {{0.1, -10, 0.2}, {0, 1, 0}});
  ASSERT_TRUE(lower);
  EXPECT_EQ(lower->body, 0U);
  EXPECT_NEAR(lower->position.y, 3.0, 1e-5);
  EXPECT_FALSE(pick_face(session_.bodies(), {{100, 10, 0}, {0, -1, 0}}));
}

TEST_F(Picking, takes_the_nearest_node_that_is_free) {
  const btSoftBody& held = *session_.bodies()[0];
  const btVector3 middle = held.m_nodes[3 * 8 + 3].m_x + btVector3(btScalar(0.01), -5, btScalar(0.02));
  const auto inside = pick_face(session_.bodies(), {to_vec3d(middle), {0, 1, 0}});
  ASSERT_TRUE(inside);
  EXPECT_EQ(nearest_free_node(held, *inside), 3 * 8 + 3);

  // A face at the corner has only held nodes, or one free node.
  const btVector3 corner = held.m_nodes[0].m_x + btVector3(btScalar(0.02), -5, btScalar(0.01));
  const auto border = pick_face(session_.bodies(), {to_vec3d(corner), {0, 1, 0}});
  ASSERT_TRUE(border);
  const int node = nearest_free_node(held, *border);
  EXPECT_TRUE(node == -1 || held.m_nodes[node].m_im > 0);
  PickedFace all_held = *border;
  for (all_held.face = 0; all_held.face < held.m_faces.size(); ++all_held.face) {
    const auto& nodes = held.m_faces[all_held.face].m_n;
    if (nodes[0]->m_im == 0 && nodes[1]->m_im == 0 && nodes[2]->m_im == 0) break;
  }
  ASSERT_LT(all_held.face, held.m_faces.size());
  EXPECT_EQ(nearest_free_node(held, all_held), -1);
}

}  // namespace
}  // namespace softcd::demo
