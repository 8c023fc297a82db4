#include "app_list.hpp"

#include <memory>
#include <utility>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btCapsuleShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletDynamics/Dynamics/btRigidBody.h"
#include "scenes/cloth.hpp"
#include "scenes/soft_ball.hpp"

namespace softcd::benchmarks {
namespace {

using demo::ClothShape;
using demo::SurfaceMesh;

struct ClothOptions {
  btScalar mass = 1;
  btScalar margin = btScalar(0.03);
  bool collides_with_itself = false;
};

btSoftBody& add_cloth(AppWorld& world, const ClothShape& shape, const ClothOptions& options = {}) {
  auto cloth = demo::make_cloth(world.info(), shape, options.mass);
  cloth->getCollisionShape()->setMargin(options.margin);
  cloth->m_cfg.kDF = btScalar(0.5);
  cloth->m_cfg.kDP = btScalar(0.01);
  cloth->setSelfCollision(options.collides_with_itself);
  return world.add(std::move(cloth));
}

btSoftBody& add_ball(AppWorld& world, const btVector3& center, btScalar radius, btScalar mass = 1) {
  return world.add(demo::make_soft_ball(world.soft_world(), {center, radius, /*subdivisions=*/2, mass,
                                                             /*margin=*/radius / 10}));
}

btRigidBody& add_sphere(AppWorld& world, const btVector3& center, btScalar radius, btScalar mass) {
  return world.add_rigid(std::make_unique<btSphereShape>(radius), center, mass);
}

btRigidBody& add_box(AppWorld& world, const btVector3& half_extents, const btVector3& center, btScalar mass = 0) {
  return world.add_rigid(std::make_unique<btBoxShape>(half_extents), center, mass);
}

void add_floor(AppWorld& world) {
  add_box(world, btVector3(20, 1, 20), btVector3(0, -1, 0)).setFriction(1);
}

/// Moves a kinematic body to a place in the coming step.
void put(btRigidBody& body, const btVector3& place, btScalar turn = 0) {
  body.setWorldTransform(btTransform(btQuaternion(btVector3(0, 1, 0), turn), place));
}

ClothShape upright_cloth(int nodes_per_side, btScalar side, btScalar top) {
  const btScalar spacing = side / btScalar(nodes_per_side - 1);
  ClothShape shape;
  shape.columns = nodes_per_side;
  shape.rows = nodes_per_side;
  shape.position = [=](int column, int row) {
    return btVector3(btScalar(column) * spacing - side / 2, top - btScalar(row) * spacing, 0);
  };
  return shape;
}

ClothShape curtain_shape() {
  ClothShape shape = upright_cloth(21, 2, 2);
  shape.is_fixed = [](int /*column*/, int row) { return row == 0; };
  return shape;
}

ClothShape held_at_border(ClothShape shape) {
  shape.is_fixed = [last_column = shape.columns - 1, last_row = shape.rows - 1](int column, int row) {
    return column == 0 || row == 0 || column == last_column || row == last_row;
  };
  return shape;
}

/// Returns an upright figure of height 1.2.
SurfaceMesh figure_mesh() {
  return demo::lathe_mesh({{0, btScalar(-0.6)},
                           {btScalar(0.25), btScalar(-0.6)},
                           {btScalar(0.15), btScalar(0.1)},
                           {btScalar(0.3), btScalar(0.35)},
                           {btScalar(0.12), btScalar(0.5)},
                           {0, btScalar(0.6)}},
                          16);
}

/// Returns a square of side `side` whose height is given by a function.
template <class Height>
SurfaceMesh ground_mesh(int cells, btScalar side, Height height) {
  SurfaceMesh mesh;
  const btScalar spacing = side / btScalar(cells);
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column) {
      const btScalar x = btScalar(column) * spacing - side / 2;
      const btScalar z = btScalar(row) * spacing - side / 2;
      mesh.positions.emplace_back(x, height(x, z), z);
    }
  }
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const int a = row * (cells + 1) + column;
      const int d = a + cells + 1;
      mesh.triangles.push_back({a, d, a + 1});
      mesh.triangles.push_back({a + 1, d, d + 1});
    }
  }
  return mesh;
}

btScalar bumps(btScalar x, btScalar z) {
  return btScalar(0.25) * btSin(3 * x) * btSin(3 * z);
}

/// A figure walks to and fro against a hanging cloth.
template <int kCentimetresPerSecond>
AppDrive build_curtain(AppWorld& world) {
  add_cloth(world, curtain_shape());
  btRigidBody& figure = world.add_mesh(figure_mesh(), btVector3(0, btScalar(0.7), 1));
  make_kinematic(figure);
  return [&figure](btScalar time, btScalar /*seconds*/) {
    constexpr btScalar kSpeed = btScalar(kCentimetresPerSecond) / 100;
    const btScalar phase = btFmod(time * kSpeed, btScalar(4));
    put(figure, btVector3(0, btScalar(0.7), phase < 2 ? 1 - phase : phase - 3));
  };
}

AppDrive build_runner(AppWorld& world) {
  return build_curtain<1000>(world);
}

AppDrive build_trampoline(AppWorld& world) {
  add_cloth(world, held_at_border(demo::horizontal_cloth(21, 3, 0)), {5});
  add_sphere(world, btVector3(btScalar(-0.4), 1, 0), btScalar(0.3), 5);
  add_ball(world, btVector3(btScalar(0.6), btScalar(0.6), 0), btScalar(0.3));
  return {};
}

/// The program of docs/use/bullet-app.md, longer.
AppDrive build_thrown_cloth(AppWorld& world) {
  ClothShape held = demo::horizontal_cloth(31, 3, 0);
  held.is_fixed = [](int, int) { return true; };
  add_cloth(world, held, {1, btScalar(0.05)});
  add_cloth(world, demo::horizontal_cloth(20, 1, 1), {1, btScalar(0.05)}).setVelocity(btVector3(0, -50, 0));
  return {};
}

AppDrive build_bumpy_ground(AppWorld& world) {
  world.add_mesh(ground_mesh(24, 4, bumps), btVector3(0, 0, 0)).setFriction(1);
  add_cloth(world, demo::horizontal_cloth(25, 2, btScalar(0.5)));
  return {};
}

AppDrive build_terrain(AppWorld& world) {
  world.add_mesh(ground_mesh(8, 8, [](btScalar x, btScalar z) { return (x * x + z * z) / 12; }), btVector3(0, 0, 0));
  for (int i = 0; i < 4; ++i) {
    add_ball(world, btVector3(btScalar(i) - btScalar(1.5), 1 + btScalar(i) / 2, 0), btScalar(0.3));
  }
  return {};
}

/// A bag, hung at its rim, that is swung when its load has come to rest.
AppDrive build_bag(AppWorld& world) {
  constexpr int kColumns = 24;
  constexpr int kWallRows = 10;
  constexpr btScalar kRadius = btScalar(0.6);
  ClothShape shape;
  shape.columns = kColumns;
  shape.rows = 16;
  shape.is_closed = true;
  shape.position = [](int column, int row) {
    const btScalar angle = SIMD_2_PI * btScalar(column) / btScalar(kColumns);
    const bool is_wall = row < kWallRows;
    const btScalar radius = is_wall ? kRadius : kRadius * btScalar(16 - row) / 7;
    const btScalar height = is_wall ? btScalar(1.2) - btScalar(row) * btScalar(0.12) : 0;
    return btVector3(radius * btCos(angle), height, radius * btSin(angle));
  };
  shape.is_fixed = [](int /*column*/, int row) { return row == 0; };
  btSoftBody& bag = add_cloth(world, shape);
  for (int i = 1; i < kColumns; ++i) bag.appendLink(kColumns * 15, kColumns * 15 + i);
  for (int i = 1; i + 1 < kColumns; ++i) bag.appendFace(kColumns * 15, kColumns * 15 + i, kColumns * 15 + i + 1);
  for (int i = 0; i < 8; ++i) {
    const btScalar x = btScalar(0.22) * btScalar(i % 2 == 0 ? 1 : -1);
    const btScalar z = btScalar(0.22) * btScalar(i / 2 % 2 == 0 ? 1 : -1);
    const int layer = i / 4;
    add_ball(world, btVector3(x, btScalar(0.3) + btScalar(layer) * btScalar(0.4), z), btScalar(0.15), btScalar(0.2));
  }
  for (int i = 0; i < 4; ++i) {
    const btScalar height = btScalar(1.1) + btScalar(i) * btScalar(0.25);
    add_box(world, btVector3(btScalar(0.08), btScalar(0.08), btScalar(0.08)), btVector3(0, height, 0), btScalar(0.3));
  }
  return [&bag](btScalar time, btScalar /*seconds*/) {
    const btScalar speed = time > 3 ? btScalar(1.5) * btCos(4 * (time - 3)) : 0;
    for (int i = 0; i < kColumns; ++i) bag.m_nodes[i].m_v = btVector3(speed, 0, 0);
  };
}

AppDrive build_gripper(AppWorld& world) {
  add_floor(world);
  add_cloth(world, upright_cloth(13, btScalar(1.2), btScalar(1.4)), {btScalar(0.2), btScalar(0.02)});
  const auto place_of_finger = [](btScalar side, btScalar time) {
    const btScalar gap = btScalar(0.3) - btScalar(0.24) * btMin(4 * time, btScalar(1));
    const btScalar height = btScalar(1.2) + btScalar(0.5) * btMax(time - btScalar(0.5), btScalar(0));
    return btVector3(0, height, side * gap);
  };
  btRigidBody* fingers[2];
  for (int i = 0; i < 2; ++i) {
    const btVector3 place = place_of_finger(btScalar(2 * i - 1), /*time=*/0);
    fingers[i] = &add_box(world, btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.05)), place);
    fingers[i]->setFriction(1);
    make_kinematic(*fingers[i]);
  }
  return [left = fingers[0], right = fingers[1], place_of_finger](btScalar time, btScalar /*seconds*/) {
    put(*left, place_of_finger(-1, time));
    put(*right, place_of_finger(1, time));
  };
}

AppDrive build_locked_balls(AppWorld& world) {
  world.set_gravity(btVector3(0, 0, 0));
  add_ball(world, btVector3(btScalar(-0.4875), 0, 0), btScalar(0.5));
  add_ball(world, btVector3(btScalar(0.4875), 0, 0), btScalar(0.5));
  return {};
}

AppDrive build_crossed_cloths(AppWorld& world) {
  world.set_gravity(btVector3(0, 0, 0));
  add_cloth(world, demo::horizontal_cloth(13, 1, 0));
  add_cloth(world, upright_cloth(13, 1, btScalar(0.53)));
  return {};
}

/// A cloth that stands on its edge and sinks into a heap.
AppDrive build_crumpling(AppWorld& world) {
  add_floor(world);
  ClothShape shape = upright_cloth(21, btScalar(1.5), btScalar(1.7));
  shape.position = [upright = shape.position](int column, int row) {
    return upright(column, row) + btVector3(0, 0, btScalar(0.05) * btSin(btScalar(row)));
  };
  add_cloth(world, shape, {1, btScalar(0.015), /*collides_with_itself=*/true});
  return {};
}

AppDrive build_pile_of_balls(AppWorld& world) {
  add_floor(world);
  for (int i = 0; i < 10; ++i) {
    const btScalar shift = btScalar(0.05) * btScalar(i % 3);
    add_ball(world, btVector3(shift, btScalar(0.4) + btScalar(0.65) * btScalar(i), btScalar(0.1) - shift),
             btScalar(0.3));
  }
  return {};
}

AppDrive build_pile_of_cloths(AppWorld& world) {
  add_floor(world);
  for (int i = 0; i < 6; ++i) {
    ClothShape shape = demo::horizontal_cloth(11, btScalar(0.9), btScalar(0.1) + btScalar(0.12) * btScalar(i));
    add_cloth(world, shape, {btScalar(0.2)}).rotate(btQuaternion(btVector3(0, 1, 0), btScalar(i) / 3));
  }
  return {};
}

/// Wind that changes, on a cloth held at one side.
AppDrive build_flag(AppWorld& world) {
  ClothShape shape = upright_cloth(21, 2, 2);
  shape.is_fixed = [](int column, int /*row*/) { return column == 0; };
  btSoftBody& flag = add_cloth(world, shape, {btScalar(0.5), btScalar(0.02), /*collides_with_itself=*/true});
  return [&flag](btScalar time, btScalar /*seconds*/) {
    const btScalar gust = 4 + 3 * btSin(5 * time);
    for (int i = 0; i < flag.m_nodes.size(); ++i) {
      const btVector3 way = flag.m_nodes[i].m_x;
      flag.addForce(btVector3(gust, 0, gust * btSin(3 * way.x() + 7 * time)) / btScalar(flag.m_nodes.size()), i);
    }
  };
}

AppDrive build_hammock(AppWorld& world) {
  ClothShape shape = demo::horizontal_cloth(19, 2, 0);
  shape.is_fixed = [](int column, int /*row*/) { return column == 0 || column == 18; };
  add_cloth(world, shape, {2});
  for (int i = 0; i < 3; ++i) {
    const btVector3 place(btScalar(0.3) * btScalar(i - 1), btScalar(0.4), 0);
    world.add_rigid(std::make_unique<btCapsuleShape>(btScalar(0.1), btScalar(0.3)), place, 1);
  }
  return {};
}

AppDrive build_vehicle(AppWorld& world) {
  add_cloth(world, held_at_border(demo::horizontal_cloth(31, 4, 0)), {4});
  btRigidBody& vehicle = add_box(world, btVector3(btScalar(0.3), btScalar(0.1), btScalar(0.2)),
                                 btVector3(btScalar(-1.4), btScalar(0.15), 0), 1);
  vehicle.setLinearVelocity(btVector3(1, 0, 0));
  return {};
}

AppDrive build_balls_on_cloth(AppWorld& world) {
  add_cloth(world, held_at_border(demo::horizontal_cloth(21, 3, 0)), {3});
  for (int i = 0; i < 5; ++i) {
    add_ball(world, btVector3(btScalar(0.1) * btScalar(i % 2), btScalar(0.5) + btScalar(0.65) * btScalar(i), 0),
             btScalar(0.3));
  }
  return {};
}

/// A kinematic hand pulls a cloth off a table.
AppDrive build_tablecloth(AppWorld& world) {
  add_floor(world);
  add_box(world, btVector3(btScalar(0.6), btScalar(0.05), btScalar(0.6)), btVector3(0, btScalar(0.75), 0));
  ClothShape shape = demo::horizontal_cloth(21, 2, btScalar(0.85));
  shape.is_fixed = [](int column, int /*row*/) { return column == 0; };
  btSoftBody& cloth = add_cloth(world, shape, {1, btScalar(0.03), /*collides_with_itself=*/true});
  add_ball(world, btVector3(0, btScalar(1.2), 0), btScalar(0.15), btScalar(0.2));
  return [&cloth](btScalar time, btScalar /*seconds*/) {
    const btScalar speed = time > 1 ? btScalar(-0.7) : 0;
    for (int row = 0; row < 21; ++row) cloth.m_nodes[21 * row].m_v = btVector3(speed, 0, 0);
  };
}

/// Spheres are shot at a hanging cloth.
AppDrive build_shots(AppWorld& world) {
  add_cloth(world, curtain_shape());
  for (int i = 0; i < 3; ++i) {
    btRigidBody& ball = add_sphere(world, btVector3(btScalar(0.5) * btScalar(i - 1), 1, 2 + btScalar(i)),
                                   btScalar(0.15), btScalar(0.2));
    ball.setLinearVelocity(btVector3(0, 2, -10));
  }
  return {};
}

/// Meshes of tubes that fall on each other, as in Bullet's soft body demo Collide.
AppDrive build_rings(AppWorld& world) {
  add_floor(world);
  for (int i = 0; i < 3; ++i) {
    std::vector<demo::ProfilePoint> outline;
    for (int point = 0; point <= 10; ++point) {
      const btScalar angle = SIMD_2_PI * btScalar(point) / 10;
      outline.push_back({btScalar(0.5) + btScalar(0.18) * btCos(angle), btScalar(0.18) * btSin(angle)});
    }
    auto ring = demo::make_body(world.info(), demo::lathe_mesh(outline, 24), 1);
    ring->generateBendingConstraints(2);
    ring->setTotalMass(1);
    ring->getCollisionShape()->setMargin(btScalar(0.03));
    ring->m_cfg.collisions |= btSoftBody::fCollision::SDF_RS;
    ring->m_cfg.kDF = 1;
    ring->rotate(btQuaternion(btVector3(1, 0, 0), btScalar(i)));
    ring->translate(btVector3(btScalar(0.1) * btScalar(i), 1 + btScalar(1.5) * btScalar(i), 0));
    world.add(std::move(ring));
  }
  return {};
}

/// One cloth falls on another that is held at its corners, as in Bullet's soft body demo Collide3, at a tenth its size.
AppDrive build_corner_held(AppWorld& world) {
  ClothShape held = demo::horizontal_cloth(15, btScalar(1.6), 0);
  held.is_fixed = [](int column, int row) { return column % 14 == 0 && row % 14 == 0; };
  add_cloth(world, held, {btScalar(1.5), btScalar(0.025)});
  btSoftBody& upper = add_cloth(world, demo::horizontal_cloth(15, btScalar(0.8), 0), {btScalar(1.5), btScalar(0.025)});
  upper.translate(btVector3(btScalar(0.3), 1, 0));
  return {};
}

/// A cape on a figure that turns and walks.
AppDrive build_cape(AppWorld& world) {
  btRigidBody& figure = world.add_mesh(figure_mesh(), btVector3(0, btScalar(0.7), 0));
  make_kinematic(figure);
  ClothShape shape;
  shape.columns = 17;
  shape.rows = 13;
  shape.position = [](int column, int row) {
    const btScalar angle = SIMD_PI * btScalar(column) / 16;
    const btScalar radius = btScalar(0.36) + btScalar(0.01) * btScalar(row);
    return btVector3(radius * btCos(angle), btScalar(1.05) - btScalar(0.07) * btScalar(row), radius * btSin(angle));
  };
  shape.is_fixed = [](int /*column*/, int row) { return row == 0; };
  btSoftBody& cape = add_cloth(world, shape, {btScalar(0.3), btScalar(0.015), /*collides_with_itself=*/true});
  std::vector<btVector3> held;
  held.reserve(17);
  for (int i = 0; i < 17; ++i) held.push_back(cape.m_nodes[i].m_x - btVector3(0, btScalar(0.7), 0));
  return [&figure, &cape, held](btScalar time, btScalar seconds) {
    put(figure, btVector3(0, btScalar(0.7), btSin(2 * time)), 2 * btSin(3 * time));
    for (int i = 0; i < 17; ++i) {
      const btVector3 goal = figure.getWorldTransform() * held[static_cast<std::size_t>(i)];
      cape.m_nodes[i].m_v = (goal - cape.m_nodes[i].m_x) / seconds;
    }
  };
}

/// A kinematic mesh presses a soft ball against the floor.
AppDrive build_press(AppWorld& world) {
  world.add_mesh(ground_mesh(4, 4, [](btScalar, btScalar) { return btScalar(0); }), btVector3(0, 0, 0));
  add_ball(world, btVector3(0, btScalar(0.5), 0), btScalar(0.4));
  btRigidBody& press =
      world.add_mesh(ground_mesh(3, 2, [](btScalar, btScalar) { return btScalar(0); }), btVector3(0, 2, 0));
  make_kinematic(press);
  return [&press](btScalar time, btScalar /*seconds*/) {
    put(press, btVector3(0, btScalar(1.2) + btScalar(0.7) * btCos(2 * time), 0));
  };
}

/// A ball thrown into a soft wall of balls.
AppDrive build_bowling(AppWorld& world) {
  add_floor(world);
  for (int i = 0; i < 6; ++i) {
    const int layer = i / 3;
    const btVector3 place(btScalar(0.7) * btScalar(i % 3 - 1), btScalar(0.35) + btScalar(layer) * btScalar(0.7), 0);
    add_ball(world, place, btScalar(0.3));
  }
  add_ball(world, btVector3(btScalar(0.1), btScalar(0.5), 4), btScalar(0.4), 3).setVelocity(btVector3(0, 1, -30));
  return {};
}

}  // namespace

const std::vector<App>& apps() {
  static const std::vector<App> list = {
      {"curtain", "a figure walks through a hanging cloth at 1 m/s", 4, -10, build_curtain<100>},
      {"runner", "the figure runs at 10 m/s", 2, -10, build_runner},
      {"cape", "a cape on a figure that turns", 4, -10, build_cape},
      {"press", "a kinematic mesh presses a soft ball on a mesh", 4, -1, build_press},
      {"trampoline", "a sphere and a soft ball on a held cloth", 5, -3, build_trampoline},
      {"hammock", "capsules in a cloth that is held at two sides", 4, -3, build_hammock},
      {"vehicle", "a box slides over a held cloth", 4, -3, build_vehicle},
      {"balls-on-cloth", "soft balls fall on a held cloth", 4, -3, build_balls_on_cloth},
      {"bag", "a bag with balls and stones is swung", 6, -2, build_bag},
      {"gripper", "two fingers lift a cloth", 3, -1, build_gripper},
      {"tablecloth", "a cloth is pulled off a table under a ball", 4, -1, build_tablecloth},
      {"shots", "spheres are shot at a hanging cloth", 2, -50, build_shots},
      {"thrown-cloth", "a cloth is thrown at a held one at 50 m/s", 3, -3, build_thrown_cloth},
      {"corner-held", "a cloth falls on one held at its corners", 4, -5, build_corner_held},
      {"bumpy-ground", "a cloth lies down on a bumpy mesh", 4, -1, build_bumpy_ground},
      {"terrain", "soft balls roll in a bowl of coarse triangles", 4, -1, build_terrain},
      {"locked-balls", "two balls start slightly inside each other, no gravity", 5, -100, build_locked_balls},
      {"crossed-cloths", "two cloths start through each other, no gravity", 5, -100, build_crossed_cloths},
      {"crumpling", "a cloth stands on its edge and sinks into a heap", 4, -1, build_crumpling},
      {"flag", "a flag in gusts that touches itself", 5, -10, build_flag},
      {"pile-of-balls", "ten soft balls fall on each other", 4, -1, build_pile_of_balls},
      {"pile-of-cloths", "six cloths fall on each other", 4, -1, build_pile_of_cloths},
      {"rings", "three soft rings fall on each other", 4, -1, build_rings},
      {"bowling", "a soft ball hits a wall of soft balls at 30 m/s", 3, -1, build_bowling},
  };
  return list;
}

}  // namespace softcd::benchmarks
