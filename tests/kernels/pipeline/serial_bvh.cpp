#include "softcd/pipeline/serial_bvh.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "random.hpp"
#include "softcd/stages/ray_casting.hpp"

namespace softcd::test {
namespace {

/// Triangles with vertices of their own, which can be moved.
struct Pieces {
  std::vector<Vec3f> x;
  std::vector<Triangle> triangles;
  std::vector<Ownership> ownership;
  std::vector<std::uint32_t> bodies;

  explicit Pieces(std::uint32_t count) : x(3 * count), ownership(count, 0), bodies(count, 0) {
    for (std::uint32_t t = 0; t < count; ++t) triangles.push_back({{3 * t, 3 * t + 1, 3 * t + 2}});
  }

  /// Makes small triangles anywhere in a box.
  void scatter(std::uint64_t seed, double size) {
    Random random(seed);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Vec3d centre = random.in_box(size);
      for (std::size_t i = 0; i < 3; ++i) x[3 * t + i] = vec3_cast<float>(centre + random.in_box(0.1));
    }
  }

  BvhInput input() const {
    Box bounds = empty_box();
    for (const Vec3f& vertex : x) bounds = merged(bounds, box_of(vertex));
    return {x.data(), triangles.data(), ownership.data(), bodies.data(), std::uint32_t(triangles.size()), bounds};
  }

  /// Expects the hierarchy to find the same first hits as a test of all triangles.
  void expect_hits(const SerialBvh& bvh, double size) const {
    ProbedBody body{};
    body.is_asked = true;
    ProbedSceneView scene{};
    scene.bvh = bvh.view();
    scene.bodies = &body;
    scene.extent = 0.5 * max_norm(vec3_cast<double>(bvh.bounds().hi) - vec3_cast<double>(bvh.bounds().lo));
    scene.centre = 0.5 * (vec3_cast<double>(bvh.bounds().hi) + vec3_cast<double>(bvh.bounds().lo));
    Random random(9);
    int hits = 0;
    for (int i = 0; i < 300; ++i) {
      const Ray ray = {random.in_box(size), random.direction()};
      ShearedRay sheared{};
      ASSERT_TRUE(shear(ray, {0, 0, 0}, sheared));
      double first = INFINITY;
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (ownership[t] != 0) continue;
        const Vec3f corners[3] = {x[3 * t], x[3 * t + 1], x[3 * t + 2]};
        RayCrossing crossing{};
        if (find_crossing(sheared, corners, crossing) && crossing.t >= 0 && crossing.t < first) first = crossing.t;
      }
      RayHit hit;
      FindFirstHit{scene, &ray, &hit}(0);
      EXPECT_EQ(hit.has_hit() ? hit.t : INFINITY, first);
      hits += hit.has_hit() ? 1 : 0;
    }
    EXPECT_TRUE(hits > 10 || triangles.size() < 100);
  }
};

TEST(SerialBvh, finds_what_a_test_of_all_triangles_finds) {
  for (const std::uint32_t count : {1U, 2U, 3U, 400U}) {
    Pieces pieces(count);
    pieces.scatter(1, 0.3);
    SerialBvh bvh;
    bvh.build(pieces.input());
    pieces.expect_hits(bvh, 0.3);
    pieces.scatter(2, 0.4);
    bvh.follow(pieces.input());
    pieces.expect_hits(bvh, 0.4);
    if (count < 3) continue;
    pieces.ownership[1] = static_cast<Ownership>(kLeftOut);
    bvh.follow(pieces.input());
    pieces.expect_hits(bvh, 0.4);
  }
}

TEST(SerialBvh, is_built_again_where_neighbours_have_come_apart) {
  Pieces pieces(1000);
  SerialBvh bvh;
  bvh.build(pieces.input());  // all in one point
  pieces.scatter(1, 10.0);
  bvh.follow(pieces.input());
  const double cost_of_following = bvh.cost();
  bvh.build(pieces.input());
  EXPECT_LE(cost_of_following, 2.0 * bvh.cost());
}

}  // namespace
}  // namespace softcd::test
