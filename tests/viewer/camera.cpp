#include "viewer/camera.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace softcd::demo {
namespace {

constexpr double kAspect = 1.5;

View some_view() {
  View view{btVector3(3, 4, 5), btVector3(1, 0, -1)};
  view.field_of_view = btScalar(0.7);
  return view;
}

void expect_near(Vec3d a, Vec3d b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

// Returns where OpenGL draws a point: x, y and depth in [-1, 1], and the distance in front of the camera.
std::array<double, 4> project(const Matrix4& matrix, Vec3d p) {
  std::array<double, 4> clip{};
  for (std::size_t row = 0; row < 4; ++row) {
    clip[row] = static_cast<double>(matrix[row]) * p.x + static_cast<double>(matrix[4 + row]) * p.y +
                static_cast<double>(matrix[8 + row]) * p.z + static_cast<double>(matrix[12 + row]);
  }
  return {clip[0] / clip[3], clip[1] / clip[3], clip[2] / clip[3], clip[3]};
}

TEST(OrbitCamera, begins_with_the_scenes_view) {
  const OrbitCamera camera(some_view());
  expect_near(camera.eye(), {3, 4, 5}, 1e-6);
  expect_near(camera.target(), {1, 0, -1}, 1e-6);
  const std::array<double, 4> target = project(camera.view_projection(kAspect), camera.target());
  EXPECT_NEAR(target[0], 0, 1e-5);
  EXPECT_NEAR(target[1], 0, 1e-5);
  EXPECT_NEAR(target[3], std::sqrt(4.0 + 16 + 36), 1e-5);
}

TEST(OrbitCamera, rays_go_through_the_points_that_are_drawn_there) {
  OrbitCamera camera(some_view());
  camera.orbit(0.4, -0.2);
  const Matrix4 matrix = camera.view_projection(kAspect);
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {-1.0, 1.0}, {0.7, -0.3}, {1.0, 0.9}}) {
    const Ray ray = camera.ray_through(x, y, kAspect);
    EXPECT_NEAR(squared_norm(ray.direction), 1, 1e-12);
    for (const double distance : {0.5, 7.0, 40.0}) {
      const std::array<double, 4> drawn = project(matrix, ray.origin + distance * ray.direction);
      EXPECT_NEAR(drawn[0], x, 1e-4);
      EXPECT_NEAR(drawn[1], y, 1e-4);
      EXPECT_GT(drawn[3], 0);
    }
  }
}

TEST(OrbitCamera, the_screen_is_as_high_as_the_field_of_view) {
  const OrbitCamera camera(some_view());
  const Vec3d top = camera.ray_through(0, 1, kAspect).direction;
  const Vec3d bottom = camera.ray_through(0, -1, kAspect).direction;
  EXPECT_NEAR(std::acos(dot(top, bottom)), 0.7, 1e-6);
}

TEST(OrbitCamera, depth_grows_away_from_the_viewer) {
  const OrbitCamera camera(some_view());
  const Ray ray = camera.ray_through(0.2, 0.1, kAspect);
  const Matrix4 matrix = camera.view_projection(kAspect);
  double nearer = -1;
  for (const double distance : {0.1, 1.0, 10.0, 100.0, 250.0}) {
    const double depth = project(matrix, ray.origin + distance * ray.direction)[2];
    EXPECT_GT(depth, nearer);
    EXPECT_LT(depth, 1);
    nearer = depth;
  }
}

TEST(OrbitCamera, orbits_around_its_target) {
  OrbitCamera camera(some_view());
  const double distance = squared_norm(camera.eye() - camera.target());
  const Vec3d right = camera.frame().right;
  const Vec3d before = camera.eye();
  camera.orbit(0.1, 0);
  EXPECT_LT(dot(camera.eye() - before, right), 0) << "the scene turns to the right with the mouse";
  EXPECT_NEAR(camera.eye().y, before.y, 1e-9);
  EXPECT_NEAR(squared_norm(camera.eye() - camera.target()), distance, 1e-9);
  camera.orbit(0, 100);
  EXPECT_GT(camera.eye().y, 7) << "from above";
  EXPECT_GT(squared_norm(camera.frame().right), 0.99) << "but never straight";
}

TEST(OrbitCamera, panning_moves_what_is_in_the_middle_with_the_cursor) {
  OrbitCamera camera(some_view());
  const Vec3d middle = camera.target();
  camera.pan(0.5, -0.25, kAspect);
  const std::array<double, 4> drawn = project(camera.view_projection(kAspect), middle);
  EXPECT_NEAR(drawn[0], 0.5, 1e-5);
  EXPECT_NEAR(drawn[1], -0.25, 1e-5);
}

TEST(OrbitCamera, zooms_within_limits) {
  OrbitCamera camera(some_view());
  const double distance = std::sqrt(squared_norm(camera.eye() - camera.target()));
  camera.zoom(0.5);
  EXPECT_NEAR(std::sqrt(squared_norm(camera.eye() - camera.target())), 0.5 * distance, 1e-9);
  camera.zoom(0);
  EXPECT_GT(squared_norm(camera.eye() - camera.target()), 0);
}

TEST(Orthographic, maps_the_box_onto_the_screen) {
  const ViewFrame frame = looking_along({1, -2, 0.5});
  const Vec3d low = {-1, 2, -3};
  const Vec3d high = {5, 4, 7};
  const Matrix4 matrix = orthographic(frame, low, high);
  const auto at = [&](Vec3d p) { return project(matrix, p.x * frame.right + p.y * frame.up + p.z * frame.back); };
  const std::array<double, 4> near_corner = at({-1, 4, 7});
  EXPECT_NEAR(near_corner[0], -1, 1e-5);
  EXPECT_NEAR(near_corner[1], 1, 1e-5);
  EXPECT_NEAR(near_corner[2], -1, 1e-5);
  const std::array<double, 4> far_corner = at({5, 2, -3});
  EXPECT_NEAR(far_corner[0], 1, 1e-5);
  EXPECT_NEAR(far_corner[1], -1, 1e-5);
  EXPECT_NEAR(far_corner[2], 1, 1e-5);
}

}  // namespace
}  // namespace softcd::demo
