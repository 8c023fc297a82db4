// Bullet's own continuous vertex-face test, compared with softcd's and with exact arithmetic, on random motions.

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "random.hpp"

#include "BulletSoftBody/btSoftBodyInternals.h"
#include "exact_ccd.hpp"
#include "queries.hpp"
#include "softcd/math/impact/impact.hpp"

namespace softcd::test {
namespace {

/// Every coordinate is a float.
Rows rounded(Rows rows) {
  for (Vec3d& row : rows) row = vec3_cast<double>(vec3_cast<float>(row));
  return rows;
}

/// A triangle with edges of about `edge` and a vertex that meets it inside, near the given time, when both move on
/// straight lines by up to `motion`.
Rows hitting_motion(Random& random, double edge, double motion) {
  Rows rows{};
  const double time = random.uniform(0.1, 0.9);
  for (std::size_t i = 1; i < 4; ++i) {
    rows[i] = random.in_box(edge);
    rows[i + 4] = rows[i] + random.in_box(motion);
  }
  const double u = random.uniform(0.1, 0.8);
  const double v = random.uniform(0.1, 0.9 - u);
  const auto lerped = [&](std::size_t i) { return lerp(rows[i], rows[i + 4], time); };
  const Vec3d hit = (1 - u - v) * lerped(1) + u * lerped(2) + v * lerped(3);
  const Vec3d velocity = random.in_box(motion);
  rows[0] = hit - time * velocity;
  rows[4] = hit + (1 - time) * velocity;
  return rounded(rows);
}

Rows free_motion(Random& random, double edge, double motion) {
  Rows rows{};
  for (std::size_t i = 0; i < 4; ++i) {
    rows[i] = random.in_box(edge);
    rows[i + 4] = rows[i] + random.in_box(motion);
  }
  return rounded(rows);
}

btVector3 to_bullet(Vec3d v) {
  return {btScalar(v.x), btScalar(v.y), btScalar(v.z)};
}

bool bullet_hits(const Rows& rows) {
  btSoftBody::Node nodes[4];
  for (std::size_t i = 0; i < 4; ++i) {
    nodes[i].m_x = to_bullet(rows[i]);
    nodes[i].m_q = to_bullet(rows[i + 4]);
    nodes[i].m_v = nodes[i].m_q - nodes[i].m_x;  // with a step of 1
  }
  btSoftBody::Face face;
  for (int i = 0; i < 3; ++i) face.m_n[i] = &nodes[i + 1];
  const auto doubled_area = [&](btVector3 btSoftBody::Node::*field) {
    return (nodes[2].*field - nodes[1].*field).cross(nodes[3].*field - nodes[1].*field);
  };
  face.m_n0 = doubled_area(&btSoftBody::Node::m_x);
  face.m_n1 = doubled_area(&btSoftBody::Node::m_q);
  face.m_vn = doubled_area(&btSoftBody::Node::m_v);
  btVector3 weights;
  return bernsteinCCD(&face, &nodes[0], /*dt=*/1, SAFE_EPSILON, weights);
}

bool softcd_hits(const Rows& r) {
  return impact_of<double>({ContactKind::vertex_triangle, r}, 0.0).state == ImpactState::hit;
}

struct Counts {
  int true_hits = 0;
  int missed_by_softcd = 0;
  int false_alarms_of_softcd = 0;
  int missed_by_bullet = 0;
  int bullet_alone = 0;  ///< Bullet reports a hit, exact arithmetic none, nor does softcd
};

Counts count(std::uint64_t seed, double edge, double motion) {
  constexpr int kQueries = 1500;
  Random random(seed);
  Counts counts;
  for (int i = 0; i < kQueries; ++i) {
    const Rows rows = i % 2 == 0 ? hitting_motion(random, edge, motion) : free_motion(random, edge, motion);
    const bool is_hit = collides_vertex_triangle(rows);
    const bool ours = softcd_hits(rows);
    const bool bullets = bullet_hits(rows);
    counts.true_hits += is_hit;
    counts.missed_by_softcd += is_hit && !ours;
    counts.false_alarms_of_softcd += !is_hit && ours;
    counts.missed_by_bullet += is_hit && !bullets;
    counts.bullet_alone += !is_hit && bullets && !ours;
  }
  std::printf(
      "edge %.3g: %d true hits; missed by softcd %d, by Bullet %d (%.0f %%); false alarms of softcd %d; "
      "reported by Bullet alone %d\n",
      edge, counts.true_hits, counts.missed_by_softcd, counts.missed_by_bullet,
      100.0 * counts.missed_by_bullet / counts.true_hits, counts.false_alarms_of_softcd, counts.bullet_alone);
  return counts;
}

class NativeContinuousTest : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(EdgeLengths, NativeContinuousTest, testing::Values(0.01, 0.05, 0.3, 1.0, 10.0));

TEST_P(NativeContinuousTest, is_covered_by_ours_which_is_exact) {
  const double edge = GetParam();
  const Counts counts = count(42, edge, edge);
  EXPECT_GT(counts.true_hits, 500);
  EXPECT_EQ(counts.missed_by_softcd, 0);
  // Motions this wild touch clearly or not at all; the tolerance of `precise` is some 1e-15 of the coordinates.
  EXPECT_EQ(counts.false_alarms_of_softcd, 0);
}

// Motion along an axis: Bullet takes an axis without relative motion for a separating one.
TEST(NativeContinuousTest, misses_motion_along_an_axis_which_is_found) {
  const Rows rows = {Vec3d{0.1, 0.5, 0.1},  {-1, 0, -1}, {1, 0, -1}, {0, 0, 1},
                     Vec3d{0.1, -0.5, 0.1}, {-1, 0, -1}, {1, 0, -1}, {0, 0, 1}};
  EXPECT_TRUE(collides_vertex_triangle(rows));
  EXPECT_TRUE(softcd_hits(rows));
  EXPECT_FALSE(bullet_hits(rows)) << "Bullet has learnt it: update the documentation";
}

}  // namespace
}  // namespace softcd::test
