#include "viewer/node_drag.hpp"

#include <gtest/gtest.h>

#include "viewer/session.hpp"

namespace softcd::demo {
namespace {

constexpr int kNodesPerSide = 8;
constexpr int kCorner = 0;
constexpr std::size_t kUpper = 1;

class Dragging : public testing::Test {
 protected:
  Dragging() : session_("two-cloths", small()), camera_(session_.scene().view()) {}

  static SceneOptions small() {
    SceneOptions options;
    options.size = kNodesPerSide;
    options.settings.backend = Backend::cpu;
    return options;
  }

  Vec3d corner() const { return to_vec3d(session_.bodies()[kUpper]->m_nodes[kCorner].m_x); }
  Ray towards(Vec3d point) const { return {camera_.eye(), unit(point - camera_.eye())}; }

  Session session_;
  OrbitCamera camera_;
  NodeDrag drag_;
};

TEST_F(Dragging, pulls_the_node_towards_the_cursor) {
  const Vec3d goal = corner() + 1.5 * camera_.frame().up - 0.5 * camera_.frame().right;
  drag_.take(session_.bodies(), kUpper, kCorner, camera_, towards(corner()));
  drag_.follow(towards(goal));
  EXPECT_NEAR(squared_norm(drag_.line(session_.bodies()).goal - goal), 0, 1e-9) << "parallel to the screen";
  for (int i = 0; i < 120; ++i) {
    drag_.pull(session_.bodies());
    session_.step();
  }
  EXPECT_LT(squared_norm(corner() - goal), 0.04) << "the cloth hangs from the node";
  const Vec3d opposite = to_vec3d(session_.bodies()[kUpper]->m_nodes[kNodesPerSide * kNodesPerSide - 1].m_x);
  EXPECT_LT(opposite.y, goal.y - 0.5);
}

TEST_F(Dragging, the_node_does_not_jump_to_the_cursor) {
  const Ray beside = towards(corner() + 0.1 * camera_.frame().right);
  drag_.take(session_.bodies(), kUpper, kCorner, camera_, beside);
  drag_.follow(beside);
  EXPECT_NEAR(squared_norm(drag_.line(session_.bodies()).goal - corner()), 0, 1e-9);
  drag_.follow(towards(corner() + 0.4 * camera_.frame().right));
  EXPECT_NEAR(squared_norm(drag_.line(session_.bodies()).goal - corner() - 0.3 * camera_.frame().right), 0, 1e-9);
}

TEST_F(Dragging, lets_go) {
  drag_.take(session_.bodies(), kUpper, kCorner, camera_, towards(corner()));
  drag_.follow(towards(corner() + camera_.frame().up));
  drag_.release();
  EXPECT_FALSE(drag_.is_active());
  drag_.pull(session_.bodies());
  EXPECT_EQ(session_.bodies()[kUpper]->m_nodes[kCorner].m_v, btVector3(0, 0, 0));
}

TEST_F(Dragging, goes_on_in_another_world) {
  drag_.take(session_.bodies(), kUpper, kCorner, camera_, towards(corner()));
  drag_.follow(towards(corner() + camera_.frame().up));
  session_.go_on_with(session_.options());
  drag_.pull(session_.bodies());
  EXPECT_GT(session_.bodies()[kUpper]->m_nodes[kCorner].m_v.length(), 1);
}

}  // namespace
}  // namespace softcd::demo
