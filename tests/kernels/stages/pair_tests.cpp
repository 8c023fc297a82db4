#include "softcd/stages/pair_tests.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::test {
namespace {

TriangleMotion random_motion(Random& random, double offset, double speed) {
  const Vec3d centre = random.in_box(offset);
  const Vec3d move = random.in_box(speed);
  TriangleMotion motion{};
  for (int corner = 0; corner < 3; ++corner) {
    const Vec3d start = centre + random.in_box(1.0);
    motion.t0[corner] = vec3_cast<float>(start);
    motion.t1[corner] = vec3_cast<float>(start + move + random.in_box(0.5));
  }
  return motion;
}

Vec3d point_at(const TriangleMotion& motion, const double (&w)[3], double time) {
  Vec3d p{0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    p = p + w[i] * lerp(vec3_cast<double>(motion.t0[i]), vec3_cast<double>(motion.t1[i]), time);
  }
  return p;
}

/// Returns the largest coordinate of two motions.
float furthest_of(const TriangleMotion& a, const TriangleMotion& b) {
  float furthest = 0.0F;
  for (const TriangleMotion* motion : {&a, &b}) {
    for (int corner = 0; corner < 3; ++corner) {
      furthest = larger(furthest, larger(max_norm(motion->t0[corner]), max_norm(motion->t1[corner])));
    }
  }
  return furthest;
}

EndVolumes ends_of(const TriangleMotion& motion, float margin) {
  Kdop18 t0 = empty_kdop();
  Kdop18 t1 = empty_kdop();
  for (int corner = 0; corner < 3; ++corner) {
    extend(t0, motion.t0[corner]);
    extend(t1, motion.t1[corner]);
  }
  inflate(t0, margin);
  inflate(t1, margin);
  return end_volumes(t0, t1);
}

Kdop18 volume_of(const Vec3f (&corners)[3]) {
  Kdop18 volume = empty_kdop();
  for (const Vec3f& corner : corners) extend(volume, corner);
  return volume;
}

/// Returns whether the corners lie apart along any of the nine axes throughout.
bool apart_as_points(const TriangleMotion& a, const TriangleMotion& b, float distance) {
  const AxisDistance reach = axis_distance(distance, furthest_of(a, b));
  const Kdop18 a_ends[] = {volume_of(a.t0), volume_of(a.t1)};
  const Kdop18 b_ends[] = {volume_of(b.t0), volume_of(b.t1)};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    const float gap = axis < 3 ? reach.straight : reach.diagonal;
    const auto is_below = [&](const Kdop18& p, const Kdop18& q) { return outward_up(p.hi[axis] + gap) < q.lo[axis]; };
    if (is_below(a_ends[0], b_ends[0]) && is_below(a_ends[1], b_ends[1])) return true;
    if (is_below(b_ends[0], a_ends[0]) && is_below(b_ends[1], a_ends[1])) return true;
  }
  return false;
}

struct FirstTouch {
  TriangleMotion a, b;
  float gap;
};

/// Returns triangles that come closer than the gap at one time of the step.
FirstTouch random_touch(Random& random) {
  const double offset = std::ldexp(1.0, static_cast<int>(random.below(12)));
  FirstTouch meeting{random_motion(random, offset, 8.0), random_motion(random, 0.0, 8.0), 0.0F};
  meeting.gap = static_cast<float>(random.chance(0.5) ? 0.001 * offset : 0.1);
  const double time = random.chance(0.2) ? (random.chance(0.5) ? 0.0 : 1.0) : random.unit();
  double w_a[3] = {random.unit(), random.unit(), 0.0};
  w_a[1] *= 1.0 - w_a[0];
  w_a[2] = 1.0 - w_a[0] - w_a[1];
  const double w_b[3] = {1.0, 0.0, 0.0};
  const Vec3d shift = point_at(meeting.a, w_a, time) - point_at(meeting.b, w_b, time) +
                      (0.9 * static_cast<double>(meeting.gap)) * random.direction();
  for (int corner = 0; corner < 3; ++corner) {
    meeting.b.t0[corner] = vec3_cast<float>(vec3_cast<double>(meeting.b.t0[corner]) + shift);
    meeting.b.t1[corner] = vec3_cast<float>(vec3_cast<double>(meeting.b.t1[corner]) + shift);
  }
  return meeting;
}

TEST(MotionTests, keep_what_meets_at_any_time) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const FirstTouch meeting = random_touch(random);
    const float furthest = furthest_of(meeting.a, meeting.b);
    ASSERT_TRUE(overlap_in_a_slab(meeting.a, meeting.b, meeting.gap, furthest)) << "pair " << i;
    ASSERT_FALSE(
        certainly_apart_throughout(ends_of(meeting.a, 0.5F * meeting.gap), ends_of(meeting.b, 0.5F * meeting.gap)))
        << "pair " << i;
    ASSERT_FALSE(apart_as_points(meeting.a, meeting.b, meeting.gap)) << "pair " << i;
  }
}

TEST(MotionTests, touching_needs_no_slack) {
  Random random(2);
  for (int i = 0; i < 100000; ++i) {
    const TriangleMotion a = random_motion(random, 100.0, 8.0);
    TriangleMotion b = random_motion(random, 100.0, 8.0);
    (random.chance(0.5) ? b.t0 : b.t1)[random.below(3)] = a.t0[0];
    b.t0[2] = a.t0[1];
    ASSERT_FALSE(certainly_apart_throughout(ends_of(a, 0.0F), ends_of(b, 0.0F)));
    ASSERT_FALSE(apart_as_points(a, b, 0.0F));
    ASSERT_TRUE(overlap_in_a_slab(a, b, 0.0F, furthest_of(a, b)));
  }
}

TEST(MotionTests, slabs_reject_what_passes_at_different_times) {
  const TriangleMotion a{{{-10, 0, 0}, {-9.5F, 0, 0}, {-10, 0.5F, 0}}, {{10, 0, 0}, {10.5F, 0, 0}, {10, 0.5F, 0}}};
  const TriangleMotion b{{{0, -0.8F, 0}, {0.5F, -0.8F, 0}, {0, -0.3F, 0}},
                         {{0, 3.2F, 0}, {0.5F, 3.2F, 0}, {0, 3.7F, 0}}};
  EXPECT_FALSE(certainly_apart_throughout(ends_of(a, 0.0F), ends_of(b, 0.0F)));
  EXPECT_TRUE(move_past(ends_of(a, 0.0F), ends_of(b, 0.0F)));
  EXPECT_FALSE(overlap_in_a_slab(a, b, 0.0F, 30.0F));
}

TEST(MotionTests, reject_what_moves_along_at_a_distance) {
  const TriangleMotion a{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{50, 0, 0}, {51, 0, 0}, {50, 1, 0}}};
  const TriangleMotion b{{{1.5F, 0, 0}, {2.5F, 0, 0}, {1.5F, 1, 0}}, {{51.5F, 0, 0}, {52.5F, 0, 0}, {51.5F, 1, 0}}};
  EXPECT_TRUE(certainly_apart_throughout(ends_of(a, 0.125F), ends_of(b, 0.125F)));
  EXPECT_FALSE(certainly_apart_throughout(ends_of(a, 0.375F), ends_of(b, 0.375F)));
  EXPECT_TRUE(apart_as_points(a, b, 0.25F));
  EXPECT_FALSE(apart_as_points(a, b, 0.75F));
  EXPECT_FALSE(move_past(ends_of(a, 0.0F), ends_of(b, 0.0F)));
}

Mesh soup(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 120;
  options.half_extent = 1.5;
  options.size_ratio = 20.0;
  options.joined_share = 0.5;
  options.seed = seed;
  return triangle_soup(options);
}

using Pairs = std::set<std::uint64_t>;

/// Returns every pair that passes PairTest, by testing all.
Pairs pairs_of_all(const SceneView& scene, const HostVolumes& bounds) {
  Pairs pairs;
  for (std::uint32_t a = 0; a < scene.triangle_count; ++a) {
    for (std::uint32_t b = a + 1; b < scene.triangle_count; ++b) {
      const bool feature = ((scene.ownership[a] | scene.ownership[b]) & 7U) != 0 ||
                           ((scene.ownership[a] >> 3) != 0 && (scene.ownership[b] >> 3) != 0);
      if (!feature || !overlap(bounds.volumes[a], bounds.volumes[b])) continue;
      const Triangle& ta = scene.triangles[a];
      const Triangle& tb = scene.triangles[b];
      const float distance = 2.0F * scene.bodies[scene.triangle_body[a]].margin;
      if (share_vertex(ta, tb) && !SharedVertexTest<false>{scene}.may_touch(ta, tb, distance)) continue;
      if (scene.bodies_may_touch(scene.triangle_body[a], scene.triangle_body[b])) pairs.insert(pair_key(a, b));
    }
  }
  return pairs;
}

TEST(TestAgainstBig, pairs_each_triangle_with_each_big_one_once) {
  const HostScene host({{soup(1), {}, 0.01F}, {soup(2), {}, 0.01F, false}}, false);
  const SceneView scene = host.view();
  HostVolumes bounds(scene);
  const std::vector<std::uint32_t> bigs{200, 3, 77, 78, 5};
  for (const std::uint32_t t : bigs) bounds.shapes[t].flags |= kBigTriangle;
  const std::uint64_t big_count = bigs.size();
  const TestAgainstBig<false> stage{
      {scene, bounds.volumes.data(), nullptr, bounds.shapes.data()}, bigs.data(), {&big_count, big_count}};
  Collector<std::uint64_t> pairs, patch_pairs;
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) stage(t, pairs, patch_pairs);
  EXPECT_TRUE(patch_pairs.items.empty());

  Pairs expected;
  const std::set<std::uint32_t> is_big(bigs.begin(), bigs.end());
  for (const std::uint64_t pair : pairs_of_all(scene, bounds)) {
    if (is_big.contains(static_cast<std::uint32_t>(pair >> 32)) || is_big.contains(static_cast<std::uint32_t>(pair))) {
      expected.insert(pair);
    }
  }
  EXPECT_GT(expected.size(), 20U);
  EXPECT_EQ(Pairs(pairs.items.begin(), pairs.items.end()), expected);
  EXPECT_EQ(pairs.items.size(), expected.size());
}

TEST(PairKey, does_not_depend_on_the_order) {
  EXPECT_EQ(pair_key(3, 9), pair_key(9, 3));
  EXPECT_EQ(pair_key(3, 9), (3ULL << 32) | 9ULL);
}

TEST(KeepFirst, leaves_one_of_each) {
  SceneView scene;
  scene.triangle_count = 8;
  scene.patch_count = 2;
  const std::vector<std::uint64_t> keys{1, 1, 1, 4, 7, 7, 9, 9};
  Collector<std::uint64_t> kept, kept_patches;
  const KeepFirst stage{keys.data(), scene};
  for (std::uint32_t i = 0; i < keys.size(); ++i) stage(i, kept, kept_patches);
  EXPECT_EQ(kept.items, (std::vector<std::uint64_t>{1, 4, 7}));
  EXPECT_EQ(kept_patches.items, (std::vector<std::uint64_t>{9}));
}

}  // namespace
}  // namespace softcd::test
