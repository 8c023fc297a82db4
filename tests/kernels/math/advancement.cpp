#include "softcd/math/impact/advancement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random.hpp"

namespace softcd::test {
namespace {

using detail::first_touch;
using detail::Motion;

/// Returns the point with these coordinates, in an order that begins with `axis`.
Vec3d turned(int axis, double x, double y, double z) {
  return axis == 0 ? Vec3d{x, y, z} : axis == 1 ? Vec3d{z, x, y} : Vec3d{y, z, x};
}

/// Returns a motion in which one feature comes straight down by 1 from `height` onto the other's middle, along `axis`.
template <ContactKind kKind>
Motion<double> falling_by_one(int axis, double height, double margin) {
  const double u = kKind == ContactKind::edge_edge ? -0.5 : 0.25;
  const double v = kKind == ContactKind::edge_edge ? 0.5 : 0.25;
  const Vec3d b = turned(axis, 0, 1, 0);
  const Vec3d c = turned(axis, 0, 0, 1);
  return {{turned(axis, height, u, v), b, c}, {turned(axis, height - 1, u, v), b, c}, margin, 0};
}

// The bound on the approach of features is tight here: they come nearer by exactly that distance.
template <ContactKind kKind>
void expect_that_hits_need_the_whole_step() {
  constexpr double kMargin = 0.01;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double left : {0.999 * kMargin, 1.001 * kMargin}) {
      const Motion<double> motion = falling_by_one<kKind>(axis, 1.0 + left, kMargin);
      const auto touch = first_touch<kKind>(motion, 0.0, [] { return 1.0; });
      EXPECT_EQ(touch.is_hit, left < kMargin) << axis;
    }
  }
}

TEST(Advancement, finds_vertices_that_touch_at_the_very_end_of_a_step) {
  expect_that_hits_need_the_whole_step<ContactKind::vertex_triangle>();
}

TEST(Advancement, finds_edges_that_touch_at_the_very_end_of_a_step) {
  expect_that_hits_need_the_whole_step<ContactKind::edge_edge>();
}

// Edges lie close beside each other and turn. For some, no step is long enough to show that they stay apart.
TEST(Advancement, counts_as_a_hit_what_its_steps_do_not_settle) {
  Random random(1);
  int used_up = 0;
  for (int i = 0; i < 4000; ++i) {
    const double width = std::exp2(random.uniform(-20.0, -10.0));
    const auto pair = [&random, width] {
      const Vec3d along = random.direction();
      return detail::RelativePair<double>{width * random.in_box(1.0), along, along + width * random.in_box(1.0)};
    };
    const Motion<double> motion = {pair(), pair(), std::exp2(random.uniform(-30.0, -12.0)), 0.0};
    detail::ApproachSearch<ContactKind::edge_edge, double> search(motion);
    int steps = 1;
    while (!search.advance()) ++steps;
    if (steps < detail::kMostApproachSteps || search.touch().is_settled) continue;
    const detail::Touch<double>& touch = search.touch();
    const double fraction =
        detail::advance_far<ContactKind::edge_edge>(motion, motion.at(touch.time), motion.t1, touch.nearest, steps - 1);
    ASSERT_EQ(touch.is_hit, fraction < 1.0) << i;
    used_up += touch.is_hit ? 1 : 0;
  }
  EXPECT_GT(used_up, 20);
}

}  // namespace
}  // namespace softcd::test
