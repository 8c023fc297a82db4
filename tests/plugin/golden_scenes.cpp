#include "golden_scenes.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "random.hpp"

namespace softcd::test {
namespace {

SoupOptions soup_options(std::uint32_t triangle_count, double half_extent, double largest, std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = triangle_count;
  options.half_extent = half_extent;
  options.largest = largest;
  options.joined_share = 0.4;
  options.degenerate_share = 0.05;
  options.needle_share = 0.05;
  options.seed = seed;
  return options;
}

SceneBody soup_body(const SoupOptions& options, float margin = 0.01F) {
  const Mesh mesh = triangle_soup(options);
  return moving(mesh, scattered(mesh, 0.5, options.seed + 100), everything(margin));
}

/// Every position through `move`.
template <class Move>
Scene with_positions(Scene scene, const Move& move) {
  for (SceneBody& body : scene) {
    body.x_t0 = move(body.x_t0);
    body.x_t1 = move(body.x_t1);
  }
  return scene;
}

/// Exact, where the factor is a power of two.
Scene scaled_scene(Scene scene, double factor) {
  for (SceneBody& body : scene) body.settings.margin *= static_cast<float>(factor);
  return with_positions(std::move(scene), [&](const Positions3& x) { return contracted(x, factor); });
}

/// Rounds positions to floats, so that a scene can be given in either type.
Scene of_floats(const Scene& scene) {
  return with_positions(scene, [](Positions3 x) {
    for (Vec3d& p : x) p = {double(float(p.x)), double(float(p.y)), double(float(p.z))};
    return x;
  });
}

BodySettings between_bodies(float margin) {
  BodySettings settings = everything(margin);
  settings.self_collision = false;
  return settings;
}

/// Triangles around vertex 0, with a rim in random places at `radius`.
Mesh star(std::uint32_t count, double radius, Random& random) {
  Mesh mesh{{}, {{0.0, 0.0, 0.0}, radius * random.direction()}};
  for (std::uint32_t i = 1; i <= count; ++i) {
    mesh.positions.push_back(radius * random.direction());
    mesh.triangles.push_back({{0, i, i + 1}});
  }
  return mesh;
}

}  // namespace

Scene soups() {
  return {soup_body(soup_options(150, 1.5, 0.4, 1)), soup_body(soup_options(150, 1.5, 0.4, 2)),
          soup_body(soup_options(100, 1.5, 2.0, 3))};
}

Scene roughened_soups() {
  Scene scene = soups();
  for (SceneBody& body : scene) {
    body.x_t0 = jittered(body.x_t0, 1e-3, 7);
    body.x_t1 = jittered(body.x_t1, 1e-3, 8);
  }
  return scene;
}

Scene distant_soups() {
  return with_positions(roughened_soups(), [](const Positions3& x) { return translated(x, {1000.0, -3000.0, 0.5}); });
}

Scene strays() {
  Scene scene = of_floats(soups());
  scene[0].x_t1[17].y = std::numeric_limits<double>::quiet_NaN();
  scene[0].x_t1[40].x = std::numeric_limits<double>::infinity();
  scene[1].x_t0[3].z = static_cast<double>(1e38F);
  return scene;
}

Scene tiny_soups() {
  return scaled_scene(of_floats(soups()), 0x1p-30);
}
Scene huge_soups() {
  return scaled_scene(of_floats(soups()), 0x1p+30);
}

Scene needles() {
  SoupOptions options = soup_options(150, 1.0, 0.6, 11);
  options.needle_share = 0.9;
  const SceneBody first = soup_body(options);
  options.seed = 12;
  return of_floats({first, soup_body(options)});
}

Scene degenerate_triangles() {
  SoupOptions options = soup_options(150, 1.0, 0.3, 13);
  options.degenerate_share = 0.9;
  const SceneBody first = soup_body(options, 0.05F);
  options.seed = 14;
  return of_floats({first, soup_body(options, 0.05F)});
}

Scene uneven_soups() {
  return of_floats({soup_body(soup_options(400, 3.0, 0.05, 15)), soup_body(soup_options(400, 3.0, 0.05, 16)),
                    soup_body(soup_options(12, 3.0, 6.0, 17))});
}

Scene ball_through_sheets() {
  const Mesh sheet = grid_cloth(24, 24, 0.1);
  const Mesh ball = moved(icosphere(2, 0.4), {0.1, 0.2, 0.45});
  BodySettings ground = between_bodies(0.03F);
  ground.kinematic = true;
  const Mesh plate = moved(scaled(grid_cloth(3, 3, 1.0), 2.0), {-0.5, -0.5, -0.31});
  return {moving(sheet, jittered(translated(sheet.positions, {0.01, 0.02, -0.3}), 0.02, 5), between_bodies(0.02F)),
          moving(ball, translated(ball.positions, {-0.1, 0.05, -0.9}), everything(0.02F)), still(plate, ground)};
}

Scene everted_ball() {
  const Mesh ball = icosphere(1, 1.0);
  return {moving(ball, jittered(contracted(ball.positions, -0.5), 0.4, 21), everything(0.01F))};
}

Scene coincident_balls() {
  const Mesh ball = icosphere(1, 1.0);
  return of_floats({still(ball, everything()), still(ball, everything()), still(ball, everything(0.01F))});
}

Scene coplanar_sheets() {
  const Mesh first = grid_cloth(10, 10, 0.125);
  const Mesh second = moved(grid_cloth(8, 8, 0.1875), {0.0625, 0.03125, 0.0});
  return of_floats({moving(first, translated(first.positions, {0.25, 0.0, 0.0}), everything()),
                    moving(second, contracted(second.positions, 0.75), everything())});
}

Scene accordion() {
  Mesh sheet = grid_cloth(40, 8, 0.1);
  for (Vec3d& p : sheet.positions) {
    const double along = p.x / 0.5;
    const double layer = std::floor(along);
    const double within = along - layer;
    const bool backwards = 0.5 * layer != std::floor(0.5 * layer);
    p = {0.5 * (backwards ? 1.0 - within : within), p.y, 0.02 * along};
  }
  sheet.positions = jittered(sheet.positions, 0.005, 22);
  Positions3 pressed = sheet.positions;
  for (Vec3d& p : pressed) p.z *= 0.25;
  return {moving(sheet, pressed, everything(0.004F))};
}

Scene turning_stars() {
  Random random(23);
  Scene scene;
  for (int i = 0; i < 3; ++i) {
    const Mesh mesh = moved(star(40, 1.0, random), {0.5 * i, 0.0, 0.0});
    Positions3 turned = mesh.positions;
    for (Vec3d& p : turned) p = {0.6 * p.x - 0.8 * p.y, 0.8 * p.x + 0.6 * p.y, p.z};
    scene.push_back(moving(mesh, turned, between_bodies(0.01F)));
  }
  return scene;
}

Scene hubs() {
  Random random(24);
  const Mesh first = star(80, 1.0, random);
  const Mesh second = star(80, 1.0, random);
  return of_floats({moving(first, jittered(first.positions, 0.1, 25), everything()),
                    moving(second, translated(second.positions, {0.3, 0.2, 0.1}), everything(0.01F))});
}

Scene filtered_soups() {
  Scene scene;
  for (std::uint32_t i = 0; i < 5; ++i) {
    SceneBody body = soup_body(soup_options(120, 1.0, 0.4, 30 + i));
    body.settings.self_collision = i == 2;
    body.settings.kinematic = i == 3 || i == 4;
    body.settings.filter_group = 1U << i;
    body.settings.filter_mask = ~(2U << i);
    body.settings.features = {i != 0, i != 1};
    scene.push_back(std::move(body));
  }
  return of_floats(scene);
}

Scene kinematic_ground() {
  Random random(40);
  Mesh ground = scaled(grid_cloth(6, 6, 1.0), 1.5);
  for (Vec3d& p : ground.positions) p.z = 0.3 * random.unit();
  const Mesh cloth = moved(grid_cloth(20, 20, 0.2), {0.1, 0.1, 0.6});
  Positions3 fallen = cloth.positions;
  for (Vec3d& p : fallen) p.z -= 0.8 * random.unit();
  BodySettings settings = between_bodies(0.02F);
  settings.kinematic = true;
  return of_floats({still(ground, settings), moving(cloth, fallen, everything(0.02F))});
}

Scene unequal_margins() {
  const Mesh fine = grid_cloth(12, 12, 0.05);
  const Mesh coarse = moved(scaled(grid_cloth(3, 3, 1.0), 0.75), {0.0, 0.0, 0.3});
  return of_floats({moving(fine, jittered(fine.positions, 0.05, 41), between_bodies(0.0F)),
                    moving(coarse, translated(coarse.positions, {0.0, 0.0, -0.1}), between_bodies(0.25F))});
}

Scene points_and_segments() {
  Random random(42);
  Mesh mesh;
  for (std::uint32_t i = 0; i < 200; ++i) {
    mesh.positions.push_back(random.in_box(1.0));
    mesh.triangles.push_back({{i, i % 3 == 0 ? i : i / 2, i}});
  }
  const Mesh ball = icosphere(1, 0.8);
  return of_floats({moving(mesh, jittered(mesh.positions, 0.2, 43), everything(0.02F)),
                    moving(ball, contracted(ball.positions, 0.8), everything(0.02F))});
}

Scene rope_and_fringes() {
  Random random(44);
  const Mesh cloth = crumpled_cloth(16, 12, 0.1, 0.05, 45);
  SceneBody fringed = moving(cloth, jittered(cloth.positions, 0.1, 46), everything(0.02F));
  for (std::uint32_t i = 0; i < 40; ++i) {
    const auto end = static_cast<std::uint32_t>(fringed.x_t0.size());
    fringed.x_t0.push_back(cloth.positions[4 * i] + 0.2 * random.direction());
    fringed.x_t1.push_back(fringed.x_t0.back() + random.in_box(0.1));
    fringed.segments.push_back({{end, 4 * i}});
  }
  SceneBody rope{{}, {{-0.5, 0.2, 0.0}}, {}, everything(0.03F)};
  for (std::uint32_t i = 0; i < 60; ++i) {
    rope.x_t0.push_back(rope.x_t0.back() + Vec3d{0.04, 0.03 * random.unit(), random.uniform(-0.1, 0.1)});
    rope.segments.push_back({{i, i + 1}});
  }
  rope.x_t1 = jittered(rope.x_t0, 0.1, 47);
  return of_floats({fringed, rope});
}

}  // namespace softcd::test
