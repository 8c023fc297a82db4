#include "softcd/stages/bounding_volumes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "host_scene.hpp"
#include "random.hpp"

namespace softcd::test {
namespace {

Mesh uneven_soup(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 400;
  options.size_ratio = 100.0;
  options.degenerate_share = 0.1;
  options.needle_share = 0.1;
  options.seed = seed;
  return triangle_soup(options);
}

HostScene scene_of(bool continuous, float margin) {
  const Mesh mesh = uneven_soup(1);
  Positions3 start = jittered(mesh.positions, 0.3, 2);
  snap_to_grid(start, 17);
  return HostScene({{mesh, start, margin}, {moved(uneven_soup(2), {0.5, 0, 0}), {}, 2.0F * margin}}, continuous);
}

bool holds(const Kdop18& volume, Vec3d p) {
  const double projections[kKdopAxes] = {p.x,       p.y,       p.z,       p.x + p.y, p.x + p.z,
                                         p.y + p.z, p.x - p.y, p.x - p.z, p.y - p.z};
  for (int axis = 0; axis < kKdopAxes; ++axis) {
    if (projections[axis] < volume.lo[axis] || projections[axis] > volume.hi[axis]) return false;
  }
  return true;
}

// Coordinates are on a coarse grid: sums of two are exact, so volumes really contain the points.
TEST(BoundTriangle, holds_the_moving_triangle_and_its_margin) {
  Random random(1);
  for (const bool continuous : {false, true}) {
    for (const float margin : {0.0F, 0.01F}) {
      const HostScene host = scene_of(continuous, margin);
      const SceneView scene = host.view();
      const HostVolumes bounds(scene);
      for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
        const double own_margin = static_cast<double>(scene.bodies[scene.triangle_body[t]].margin);
        for (int sample = 0; sample < 20; ++sample) {
          const double time = continuous ? (sample < 3 ? 0.0 : random.unit()) : 1.0;
          double w[3] = {random.unit(), random.unit(), random.unit()};
          const double sum = w[0] + w[1] + w[2];
          Vec3d p = (own_margin * 0.9999) * random.direction();
          for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t v = scene.triangles[t].v[corner];
            const double weight = sample < 6 ? (sample % 3 == corner ? 1.0 : 0.0) : w[corner] / sum;
            p = p + weight * lerp(vec3_cast<double>(scene.x_t0[v]), vec3_cast<double>(scene.x_t1[v]), time);
          }
          // Convex combinations in double are rounded, so the volume may be missed by that much.
          const Kdop18& exact = bounds.volumes[t];
          Kdop18 volume = exact;
          inflate(volume, 1e-7F);
          ASSERT_TRUE(holds(sample < 6 && margin == 0.0F && !continuous ? exact : volume, p)) << "triangle " << t;
        }
      }
    }
  }
}

TEST(BoundTriangle, is_no_larger_than_needed) {
  const HostScene host = scene_of(false, 0.0F);
  const SceneView scene = host.view();
  const HostVolumes bounds(scene);
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
    Kdop18 expected = empty_kdop();
    for (const std::uint32_t v : scene.triangles[t].v) extend(expected, scene.x_t1[v]);
    for (int axis = 0; axis < kKdopAxes; ++axis) {
      ASSERT_EQ(bounds.volumes[t].lo[axis], expected.lo[axis]);
      ASSERT_EQ(bounds.volumes[t].hi[axis], expected.hi[axis]);
    }
  }
}

TEST(BoundTriangle, motion_margin_grows_by_the_fastest_corner) {
  const HostScene host = scene_of(false, 0.01F);
  SceneView scene = host.view();
  scene.motion_margin = 2.0F;
  const HostVolumes bounds(scene);
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
    double furthest = 0.0;
    for (const std::uint32_t v : scene.triangles[t].v) {
      const Vec3d move = vec3_cast<double>(scene.x_t1[v]) - vec3_cast<double>(scene.x_t0[v]);
      furthest = std::max(furthest, std::sqrt(squared_norm(move)));
    }
    const double margin = static_cast<double>(scene.bodies[scene.triangle_body[t]].margin);
    ASSERT_NEAR(bounds.shapes[t].growth, margin + 2.0 * furthest, 1e-5);
  }
}

TEST(BoundTriangle, radius_covers_both_ends) {
  const HostScene host = scene_of(true, 0.01F);
  const SceneView scene = host.view();
  const HostVolumes bounds(scene);
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
    for (const Vec3f* x : {scene.x_t0, scene.x_t1}) {
      const auto [a, b, c] = scene.triangles[t].v;
      const Sphere sphere = bounding_sphere(x[a], x[b], x[c]);
      ASSERT_GE(bounds.shapes[t].radius, sphere.radius);
      for (const std::uint32_t v : {a, b, c}) {
        ASSERT_LE(std::sqrt(squared_norm(vec3_cast<double>(x[v]) - vec3_cast<double>(sphere.centre))),
                  static_cast<double>(sphere.radius) * (1.0 + 1e-6));
      }
    }
  }
}

TEST(BoundTriangle, what_is_left_out_or_out_of_reach_has_no_volume) {
  HostScene host = scene_of(false, 0.0F);
  host.ownership()[7] = static_cast<Ownership>(kLeftOut);
  host.body(1).partner_box = {{100.0F, 100.0F, 100.0F}, {101.0F, 101.0F, 101.0F}};
  const SceneView scene = host.view();
  const HostVolumes bounds(scene);
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
    EXPECT_EQ(is_empty(bounds.volumes[t]), t == 7 || scene.triangle_body[t] == 1);
  }
}

TEST(BoundTriangle, end_volumes_are_those_of_the_two_ends) {
  const HostScene host = scene_of(true, 0.01F);
  const SceneView scene = host.view();
  const HostVolumes bounds(scene);
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
    Kdop18 t0 = empty_kdop();
    Kdop18 t1 = empty_kdop();
    for (const std::uint32_t v : scene.triangles[t].v) {
      extend(t0, scene.x_t0[v]);
      extend(t1, scene.x_t1[v]);
    }
    const float margin = scene.bodies[scene.triangle_body[t]].margin;
    inflate(t0, margin);
    inflate(t1, margin);
    for (int i = 0; i < kKdopAxes; ++i) {
      const EndVolumes::Axis axis = bounds.end_volumes[t].axes[i];
      ASSERT_EQ(axis.t0_lo, t0.lo[i]);
      ASSERT_EQ(axis.t0_hi, t0.hi[i]);
      ASSERT_EQ(axis.t1_lo, t1.lo[i]);
      ASSERT_EQ(axis.t1_hi, t1.hi[i]);
      ASSERT_EQ(bounds.volumes[t].lo[i], std::min(axis.t0_lo, axis.t1_lo));
      ASSERT_EQ(bounds.volumes[t].hi[i], std::max(axis.t0_hi, axis.t1_hi));
    }
  }
}

// Corners are given anywhere that rounds to the scene's positions. The volumes contain the given triangles.
TEST(BoundTriangle, covers_where_rounded_positions_were_given) {
  HostScene host({{uneven_soup(3), {}, 0.0F}}, false);
  host.body(0).is_rounded = true;
  const SceneView scene = host.view();
  const HostVolumes bounds(scene);
  Random random(5);
  const auto given = [&random](float x) {
    const double half_step = 0.5 * static_cast<double>(std::nextafter(std::abs(x), INFINITY) - std::abs(x));
    return static_cast<double>(x) + (random.chance(0.5) ? half_step : -half_step);
  };
  for (std::uint32_t t = 0; t < scene.triangle_count; ++t) {
    for (const std::uint32_t v : scene.triangles[t].v) {
      const Vec3f x = scene.x_t1[v];
      const double x_given = given(x.x);
      const double y_given = given(x.y);
      ASSERT_TRUE(holds(bounds.volumes[t], {x_given, y_given, given(x.z)})) << "triangle " << t;
    }
  }
}

// At the lower end of its power of two a float has the largest rounding error, relative to itself.
TEST(RoundingBound, covers_positions_half_way_between_floats) {
  for (const double size : {1.0, 0x1p-40, 0x1p+60}) {
    const double step = size * 0x1p-24;
    const Vec3d given = {size + step, size + step, -size - step};
    const Vec3f rounded = vec3_cast<float>(given);
    EXPECT_GE(static_cast<double>(rounding_bound(rounded)), norm(given - vec3_cast<double>(rounded))) << size;
  }
}

}  // namespace
}  // namespace softcd::test
