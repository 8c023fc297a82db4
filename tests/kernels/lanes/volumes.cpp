#include "lanes/volumes.hpp"

#include <gtest/gtest.h>

#include <cfloat>
#include <cstdint>
#include <cstring>
#include <vector>

#include "each_target.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

/// Triangles of three bodies with random corners. `size` is that of the coordinates.
struct MovingTriangles {
  static constexpr std::uint32_t kTriangles = 90;
  static constexpr std::uint32_t kVertices = 60;
  static constexpr std::uint32_t kBodies = 3;

  std::vector<Vec3f> x_t0, x_t1;
  std::vector<Triangle> triangles;
  std::vector<Ownership> ownership;
  std::vector<std::uint32_t> triangle_body, vertex_body;
  std::vector<SceneBody> bodies;
  SceneView view;

  MovingTriangles(Random& random, float size) {
    const auto coordinate = [&] {
      if (random.chance(0.02)) return random.chance(0.5) ? 0.0F : -0.0F;
      if (random.chance(0.005)) return random.chance(0.5) ? 1.0e37F : FLT_TRUE_MIN;
      return size * static_cast<float>(random.uniform(-1.0, 1.0));
    };
    for (std::uint32_t v = 0; v < kVertices; ++v) {
      x_t1.push_back({coordinate(), coordinate(), coordinate()});
      x_t0.push_back(random.chance(0.3) ? x_t1.back() : Vec3f{coordinate(), coordinate(), coordinate()});
      vertex_body.push_back(v * kBodies / kVertices);
    }
    const bool has_left_out = random.chance(0.5);
    for (std::uint32_t t = 0; t < kTriangles; ++t) {
      const std::uint32_t body = t * kBodies / kTriangles;
      const auto corner = [&] { return (body * kVertices + random.below(kVertices)) / kBodies; };
      triangles.push_back({{corner(), corner(), corner()}});
      ownership.push_back(
          static_cast<Ownership>(random.below(64) | (has_left_out && random.chance(0.02) ? kLeftOut : 0U)));
      triangle_body.push_back(body);
    }
    for (std::uint32_t b = 0; b < kBodies; ++b) {
      SceneBody body{};
      body.margin = random.chance(0.3) ? 0.0F : size * static_cast<float>(random.uniform(0.0, 0.1));
      body.vertex_triangle = random.chance(0.7);
      body.edge_edge = random.chance(0.7);
      body.is_rounded = random.chance(0.3);
      const bool is_near_all = random.chance(0.6);
      const float lo = is_near_all ? -FLT_MAX : 0.6F * size;
      const float hi = is_near_all ? FLT_MAX : 0.7F * size;
      body.partner_box = {{lo, lo, lo}, {hi, hi, hi}};
      bodies.push_back(body);
    }
    view.x_t0 = x_t0.data();
    view.x_t1 = x_t1.data();
    view.triangles = triangles.data();
    view.ownership = ownership.data();
    view.triangle_body = triangle_body.data();
    view.vertex_body = vertex_body.data();
    view.bodies = bodies.data();
    view.vertex_count = kVertices;
    view.triangle_count = kTriangles;
    view.body_count = kBodies;
    view.is_swept = random.chance(0.5);
    view.motion_margin = random.chance(0.3) ? 2.0F : 0.0F;
    view.contact_rule = random.chance(0.3) ? ContactRule::slab : ContactRule::distance;
  }
};

/// The stage's results for the triangles begin <= t < end; those of other triangles are as they were.
struct Bounded {
  static constexpr std::uint32_t kTriangles = MovingTriangles::kTriangles;

  std::vector<Kdop18> volumes{kTriangles};
  std::vector<EndVolumes> end_volumes{kTriangles};
  std::vector<TriangleShape> shapes{kTriangles};

  BoundTriangle stage(const SceneView& scene) { return {scene, volumes.data(), end_volumes.data(), shapes.data()}; }
};

template <class T>
bool are_same_bytes(const T& a, const T& b, std::size_t size = sizeof(T)) {
  return std::memcmp(&a, &b, size) == 0;
}

void expect_as_one_by_one(float size, int& empty_count) {
  constexpr std::uint32_t kTriangles = MovingTriangles::kTriangles;
  Random random(3);
  for (int round = 0; round < 300; ++round) {
    const MovingTriangles scene(random, size);
    const std::uint32_t begin = random.below(kTriangles);
    const std::uint32_t end = begin + random.below(kTriangles - begin + 1);
    Bounded at_once;
    cpu::for_range(at_once.stage(scene.view), begin, end);
    Bounded one_by_one;
    for (std::uint32_t t = begin; t < end; ++t) one_by_one.stage(scene.view)(t);
    for (std::uint32_t t = 0; t < kTriangles; ++t) {
      constexpr std::size_t kWithoutPadding = 2 * kKdopAxes * sizeof(float);
      ASSERT_TRUE(are_same_bytes(at_once.volumes[t], one_by_one.volumes[t], kWithoutPadding)) << "triangle " << t;
      ASSERT_TRUE(are_same_bytes(at_once.end_volumes[t], one_by_one.end_volumes[t])) << "triangle " << t;
      ASSERT_TRUE(are_same_bytes(at_once.shapes[t], one_by_one.shapes[t])) << "triangle " << t;
      if (t >= begin && t < end) empty_count += is_empty(at_once.volumes[t]) ? 1 : 0;
    }
  }
}

TEST(VolumesInLanes, are_the_bytes_of_one_by_one) {
  for_each_target([] {
    int empty_count = 0;
    for (const float size : {1.0F, 1e-12F, 1e18F, 1e30F}) expect_as_one_by_one(size, empty_count);
    // There are some 27,000 triangles.
    EXPECT_GT(empty_count, 2000);
    EXPECT_LT(empty_count, 20000);
  });
}

}  // namespace
}  // namespace softcd::test
