#include "softcd/math/impact/advancement.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace softcd::test
