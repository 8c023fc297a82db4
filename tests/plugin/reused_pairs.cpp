#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "fans.hpp"
#include "mesh_generators.hpp"
#include "random.hpp"
#include "watched.hpp"

// Pairs of triangles that one detection finds serve later ones, which find the same contacts as detections of their
// own.
namespace softcd::test {
namespace {

TEST(ReusedPairs, serve_a_scene_that_rests) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Watched watched(two_cloths());
    Query& query = watched.query(looking_for(detection));
    for (int look = 0; look < 6; ++look) {
      watched.move_all();
      EXPECT_GT(watched.expect_contacts(query), 100U);
      EXPECT_EQ(query.statistics().reused_pairs, look >= first_served()) << "look " << look;
    }
  }
}

TEST(ReusedPairs, of_looks_with_margins_serve_those_without_in_a_step) {
  Watched watched(two_cloths());
  Query& contacts = watched.query(looking_for(Detection::ccd));
  Query& crossings = watched.query(looking_for(Detection::ccd, /*margins=*/false));
  std::size_t crossing_count = 0;
  for (std::uint64_t step = 0; step < 8; ++step) {
    for (std::size_t i = 0; i < 2; ++i) {
      SceneBody& body = watched.body(i);
      body.x_t0 = body.x_t1;
      body.x_t1 = translated(jittered(body.x_t0, 0.05, 10 * step + i), {0.0, 0.0, i == 0 ? 0.05 : -0.05});
      watched.move(i);
    }
    EXPECT_GT(watched.expect_contacts(contacts), 100U);
    EXPECT_FALSE(contacts.statistics().reused_pairs);
    // Moves the bodies as a response to contacts would.
    for (std::size_t i = 0; i < 2; ++i) {
      watched.body(i).x_t1 = jittered(watched.body(i).x_t1, 0.02, 100 * step + i);
      watched.move(i);
    }
    crossing_count += watched.expect_contacts(crossings);
    EXPECT_EQ(crossings.statistics().reused_pairs, step >= 2) << "step " << step;
  }
  EXPECT_GT(crossing_count, 100U);
}

TEST(ReusedPairs, are_tested_instead_of_cells) {
  Watched watched(two_cloths());
  Query& query = watched.query(looking_for(Detection::dcd));
  query.detect();
  const Statistics fresh = query.statistics();
  while (!query.statistics().reused_pairs) query.detect();
  const Statistics reused = query.statistics();
  EXPECT_EQ(reused.active_triangles, fresh.active_triangles);
  EXPECT_EQ(reused.mean_radius, fresh.mean_radius);
  EXPECT_EQ(reused.cell_size, fresh.cell_size);
  EXPECT_EQ(reused.triangle_pairs, fresh.triangle_pairs);
  EXPECT_EQ(reused.vt_candidates, fresh.vt_candidates);
  EXPECT_EQ(reused.entries, 0U);
  EXPECT_EQ(reused.cells, 0U);
  EXPECT_GE(reused.tests, reused.triangle_pairs);
  EXPECT_LT(reused.tests, 16 * fresh.triangle_pairs);
  bool is_explained = false;
  for (const StageReport& report : query.explain())
    is_explained |= report.stage == DetectionStage::broad_phase && !report.ran;
  EXPECT_TRUE(is_explained);
}

TEST(ReusedPairs, cost_no_memory_before_they_pay) {
  Watched once(two_cloths());
  Query& keeping = once.query(looking_for(Detection::ccd));
  keeping.detect();
  Watched never(two_cloths());
  QueryOptions options = looking_for(Detection::ccd);
  options.reuse_pairs = false;
  Query& other = never.query(options);
  for (int look = 0; look < 6; ++look) {
    other.detect();
    EXPECT_FALSE(other.statistics().reused_pairs);
  }
  EXPECT_EQ(keeping.statistics().peak_bytes, other.statistics().peak_bytes);
}

/// Returns a place for a corner such that the 18-DOP of the triangle with a and b stays within that of a, b and c.
Vec3d within_volume(Random& random, Vec3d a, Vec3d b, Vec3d c) {
  const auto projections = [](Vec3d p) {
    return std::vector<double>{p.x, p.y, p.z, p.x + p.y, p.x + p.z, p.y + p.z, p.x - p.y, p.x - p.z, p.y - p.z};
  };
  while (true) {
    const Vec3d p = random.in_box(8.0);
    bool is_within = true;
    for (std::size_t axis = 0; axis < 9; ++axis) {
      const auto [low, high] = std::minmax({projections(a)[axis], projections(b)[axis], projections(c)[axis]});
      is_within &= projections(p)[axis] > low && projections(p)[axis] < high;
    }
    if (is_within) return p;
  }
}

TEST(ReusedPairs, do_not_serve_split_triangles_that_turn_within_their_volumes) {
  SoupOptions dust;
  dust.triangle_count = 6000;
  dust.half_extent = 6.0;
  dust.largest = 0.7;
  Scene scene = {still({{{{0, 1, 2}}}, {{-8, -3, 1}, {8, 2, -5}, {1, 8, 6}}}, everything(0.01F)),
                 still(triangle_soup(dust), everything(0.01F))};
  scene[1].settings.self_collision = false;
  Watched watched(scene);
  Query& query = watched.query(looking_for(Detection::dcd));
  Random random(5);
  std::size_t count = 0;
  for (int look = 0; look < 8; ++look) {
    count += watched.expect_contacts(query);
    if (look < 4) {
      EXPECT_EQ(query.statistics().split_triangles, 1U);
      continue;
    }
    Positions3& x = watched.body(0).x_t1;
    x[2] = within_volume(random, x[0], x[1], scene[0].x_t1[2]);
    watched.body(0).x_t0 = x;
    watched.move(0);
  }
  EXPECT_GT(count, 100U);
}

TEST(ReusedPairs, do_not_serve_neighbours_that_are_not_listed) {
  std::vector<NamedFan> all = fans(120);
  Watched watched({still(all.back().mesh, everything(0.02F))});
  Query& query = watched.query(looking_for(Detection::ccd));
  for (std::uint64_t look = 0; look < 6; ++look) {
    watched.expect_contacts(query);
    EXPECT_FALSE(query.statistics().reused_pairs);
  }
}

TEST(ReusedPairs, do_not_serve_bodies_and_kinds_that_were_not_looked_for) {
  Scene scene = two_cloths();
  for (SceneBody& body : scene) {
    body.settings.self_collision = false;
    body.settings.features.edge_edge = false;
  }
  Watched watched(scene);
  Query& query = watched.query(looking_for(Detection::ccd));
  const PairFilter nobody = [](BodyId a, BodyId b) { return a == b; };
  rest(watched, query);
  watched.body(0).settings.self_collision = true;
  watched.set_settings(0);
  EXPECT_GT(watched.expect_contacts(query, nobody), 0U);
  EXPECT_FALSE(query.statistics().reused_pairs);
  for (int look = 0; look < 4; ++look) watched.expect_contacts(query, nobody);
  EXPECT_TRUE(query.statistics().reused_pairs);
  watched.expect_contacts(query);
  EXPECT_FALSE(query.statistics().reused_pairs);
  rest(watched, query);
  for (std::size_t i = 0; i < 2; ++i) {
    watched.body(i).settings.features = {false, true};
    watched.set_settings(i);
  }
  EXPECT_GT(watched.expect_contacts(query), 0U);
  EXPECT_FALSE(query.statistics().reused_pairs);
}

TEST(ReusedPairs, serve_fewer_bodies_and_kinds) {
  Watched watched(two_cloths());
  Query& query = watched.query(looking_for(Detection::ccd));
  rest(watched, query);
  EXPECT_GT(watched.expect_contacts(query, [](BodyId a, BodyId b) { return a == b; }), 0U);
  EXPECT_TRUE(query.statistics().reused_pairs);
  EXPECT_GT(watched.expect_contacts(query, [](BodyId a, BodyId b) { return a != b; }), 0U);
  EXPECT_TRUE(query.statistics().reused_pairs);
  Query& edges = watched.query([] {
    QueryOptions options = looking_for(Detection::dcd);
    options.features = {false, true};
    return options;
  }());
  EXPECT_GT(watched.expect_contacts(edges), 0U);
  EXPECT_TRUE(edges.statistics().reused_pairs);
}

TEST(ReusedPairs, are_kept_for_each_of_several_queries_in_turn) {
  Watched watched(two_cloths());
  Query& between = watched.query(looking_for(Detection::ccd));
  Query& within = watched.query(looking_for(Detection::ccd));
  for (int look = 0; look < 8; ++look) {
    EXPECT_GT(watched.expect_contacts(between, [](BodyId a, BodyId b) { return a != b; }), 0U);
    EXPECT_GT(watched.expect_contacts(within, [](BodyId a, BodyId b) { return a == b; }), 0U);
    if (look <= first_served()) continue;
    EXPECT_TRUE(between.statistics().reused_pairs) << "look " << look;
    EXPECT_TRUE(within.statistics().reused_pairs) << "look " << look;
  }
}

TEST(ReusedPairs, serve_some_of_many_queries) {
  Watched watched({cloth(0.0, 1), cloth(0.1, 2), cloth(0.2, 3)});
  std::vector<Query*> queries;
  for (int i = 0; i < 6; ++i) queries.push_back(&watched.query(looking_for(Detection::ccd)));
  for (int look = 0; look < 12; ++look) {
    int reused = 0;
    std::size_t place = 0;
    for (std::size_t i = 0; i < watched.size(); ++i) {
      for (std::size_t j = i; j < watched.size(); ++j) {
        Query& query = *queries[place++];
        watched.expect_contacts(query, [pair = std::pair(watched.id(i), watched.id(j))](BodyId a, BodyId b) {
          return std::pair(a, b) == pair;
        });
        reused += query.statistics().reused_pairs ? 1 : 0;
      }
    }
    EXPECT_GE(reused, look > first_served() ? 3 : 0) << "look " << look;
  }
}

TEST(ReusedPairs, do_not_serve_what_a_stray_vertex_leaves_to_its_neighbours) {
  Scene scene = two_cloths();
  for (SceneBody& body : scene) body.settings.features.edge_edge = false;  // half of the triangles own nothing
  Watched watched(scene);
  Query& query = watched.query(looking_for(Detection::ccd));
  for (const std::size_t vertex : {13, 37, 62, 88}) {
    rest(watched, query);
    Vec3d& x = watched.body(0).x_t1[vertex];
    for (const double stray : {std::numeric_limits<double>::quiet_NaN(), 1e38}) {
      const Vec3d before = std::exchange(x, {stray, 0.0, 0.0});
      watched.move(0);
      EXPECT_GT(watched.expect_contacts(query), 100U);
      x = before;
      watched.move(0);
      watched.expect_contacts(query);
    }
  }
}

TEST(ReusedPairs, are_given_up_where_memory_is_limited) {
  Watched watched(two_cloths());
  Query& query = watched.query(looking_for(Detection::ccd));
  rest(watched, query);
  SceneOptions options = watched.scene().options();
  options.memory_limit = query.statistics().peak_bytes;
  watched.scene().set_options(options);
  for (int look = 0; look < 5; ++look) {
    watched.expect_contacts(query);
    EXPECT_FALSE(query.statistics().reused_pairs);
  }
  options.memory_limit = 0;
  watched.scene().set_options(options);
  rest(watched, query);
}

/// Moves the bodies by a step in which vertices go no further than `size`.
void creep(Watched& watched, std::uint64_t step, double size) {
  for (std::size_t i = 0; i < watched.size(); ++i) {
    SceneBody& body = watched.body(i);
    body.x_t0 = body.x_t1;
    body.x_t1 = jittered(body.x_t0, size, 10 * step + i);
  }
  watched.move_all();
}

TEST(ReusedPairs, serve_while_triangles_move_little) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Watched watched(two_cloths());
    Query& query = watched.query(looking_for(detection));
    int reused = 0;
    for (std::uint64_t step = 0; step < 24; ++step) {
      creep(watched, step, 0.002);
      EXPECT_GT(watched.expect_contacts(query), 100U);
      reused += query.statistics().reused_pairs ? 1 : 0;
    }
    EXPECT_GT(reused, 12);
  }
}

QueryOptions by_slabs() {
  QueryOptions options = looking_for(Detection::dcd);
  options.contact_rule = ContactRule::slab;
  return options;
}

// A detection that keeps pairs of grown volumes has no more pairs of its own than one that keeps nothing.
TEST(ReusedPairs, are_as_many_as_a_search_without_them_finds) {
  for (QueryOptions options : {looking_for(Detection::dcd), looking_for(Detection::ccd), by_slabs()}) {
    Watched watched(two_cloths());
    Watched other(two_cloths());
    Query& query = watched.query(options);
    options.reuse_pairs = false;
    Query& alone = other.query(options);
    int keeping = 0;
    for (std::uint64_t step = 0; step < 24; ++step) {
      creep(watched, step, 0.002);
      creep(other, step, 0.002);
      query.detect();
      alone.detect();
      EXPECT_EQ(query.statistics().triangle_pairs, alone.statistics().triangle_pairs) << step;
      keeping += query.statistics().tests > alone.statistics().tests ? 1 : 0;
    }
    EXPECT_GT(keeping, backend_under_test() == Backend::cpu ? 2 : 0);
  }
}

/// Bodies creep, each alone, until their pairs serve. Then they may touch each other, so that the pairs do not serve,
/// jump, and have a triangle so large that it is split. So the detection that would keep pairs anew cannot.
TEST(ReusedPairs, are_searched_anew_when_triangles_begin_to_be_split) {
  Scene cloths;
  for (const std::uint64_t seed : {1U, 2U}) {
    Mesh mesh = crumpled_cloth(50, 50, 0.2, 0.15, seed);
    mesh.positions = translated(mesh.positions, {0.0, 0.0, 0.1 * static_cast<double>(seed)});
    snap_to_grid(mesh.positions, 17);
    cloths.push_back(still(mesh, everything(0.02F)));
  }
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Watched watched(cloths);
    Query& query = watched.query(looking_for(detection));
    const PairFilter alone = [](BodyId a, BodyId b) { return a == b; };
    std::uint64_t step = 0;
    for (int jump = 0; jump < 6; ++jump) {
      const std::uint64_t last = step + 10;
      do {
        creep(watched, step, 0.002);
        watched.expect_contacts(query, alone);
      } while (!query.statistics().reused_pairs && ++step < last);
      EXPECT_TRUE(query.statistics().reused_pairs);
      const double aside = jump % 2 == 0 ? 1.5 : -1.5;
      for (std::size_t i = 0; i < watched.size(); ++i) {
        SceneBody& body = watched.body(i);
        body.x_t0 = translated(body.x_t1, {aside, aside, 0.0});
        body.x_t1 = translated(body.x_t0, {0.0, aside, 0.0});
      }
      Positions3& x = watched.body(0).x_t1;
      const Vec3d corner = x[0];
      x[0] = {corner.x + 4.0, corner.y + 4.0, corner.z + 4.0};
      watched.move_all();
      EXPECT_GT(watched.expect_contacts(query), 100U);
      EXPECT_GT(query.statistics().split_triangles, 0U);
      x[0] = corner;
      watched.move_all();
      watched.expect_contacts(query, alone);
    }
  }
}

TEST(ReusedPairs, serve_segments) {
  Scene scene = two_cloths();
  SceneBody rope = scene[1];
  rope.triangles.clear();
  for (std::uint32_t v = 1; v < rope.x_t1.size(); ++v) rope.segments.push_back({{v - 1, v}});
  scene.push_back(rope);
  Watched watched(scene);
  Query& query = watched.query(looking_for(Detection::ccd));
  int reused = 0;
  for (std::uint64_t step = 0; step < 24; ++step) {
    creep(watched, step, 0.002);
    EXPECT_GT(watched.expect_contacts(query), 100U);
    reused += query.statistics().reused_pairs ? 1 : 0;
  }
  EXPECT_GT(reused, 12);
}

TEST(ReusedPairs, are_not_kept_of_what_moves_far) {
  Watched watched(two_cloths());
  Query& query = watched.query(looking_for(Detection::dcd));
  QueryOptions options = looking_for(Detection::dcd);
  options.reuse_pairs = false;
  Watched other(two_cloths());
  Query& alone = other.query(options);
  for (std::uint64_t step = 0; step < 6; ++step) {
    creep(watched, step, 0.2);
    creep(other, step, 0.2);
    watched.expect_contacts(query);
    alone.detect();
    EXPECT_EQ(query.statistics().tests, alone.statistics().tests);
    EXPECT_FALSE(query.statistics().reused_pairs);
  }
}

TEST(ReusedPairs, serve_what_rests_after_it_has_moved_far_for_long) {
  Watched watched(two_cloths());
  Query& query = watched.query(looking_for(Detection::dcd));
  for (std::uint64_t step = 0; step < 20; ++step) {
    creep(watched, step, 0.2);
    query.detect();
    EXPECT_FALSE(query.statistics().reused_pairs);
  }
  int looks = 0;
  do {
    watched.expect_contacts(query);
  } while (!query.statistics().reused_pairs && ++looks < 64);
  EXPECT_LT(looks, 40);
}

/// Bodies come within each other's reach gradually, so that more and more of their triangles take part.
TEST(ReusedPairs, serve_triangles_that_come_within_reach) {
  Mesh lower = grid_cloth(12, 12, 0.5);
  Mesh upper = icosphere(3, 2.0);
  upper.positions = translated(upper.positions, {2.7, 2.7, 2.2});
  for (const QueryOptions& options : {looking_for(Detection::ccd), by_slabs()}) {
    Watched watched({still(lower, everything(0.1F)), still(upper, everything(0.1F))});
    Query& query = watched.query(options);
    int reused = 0;
    std::size_t count = 0;
    for (int step = 0; step < 40; ++step) {
      SceneBody& ball = watched.body(1);
      ball.x_t0 = ball.x_t1;
      ball.x_t1 = translated(ball.x_t0, {0.0, 0.0, -0.005});
      watched.move(1);
      count += watched.expect_contacts(query);
      reused += query.statistics().reused_pairs ? 1 : 0;
    }
    EXPECT_GT(count, 100U);
    EXPECT_GT(reused, 15);
  }
}

TEST(ReusedPairs, serve_looks_that_move_bodies_a_little_or_far) {
  Watched watched(two_cloths());
  Query& contacts = watched.query(looking_for(Detection::ccd));
  Query& crossings = watched.query(looking_for(Detection::ccd, /*margins=*/false));
  Random random(3);
  int reused = 0;
  for (std::uint64_t step = 0; step < 60; ++step) {
    const double sizes[] = {0.0, 0.0005, 0.002, 0.002, 0.02, 0.3};
    creep(watched, step, sizes[random.below(6)]);
    for (Query* query : {&contacts, &crossings}) {
      watched.expect_contacts(*query);
      reused += query->statistics().reused_pairs ? 1 : 0;
    }
    if (step % 20 == 19) {
      for (std::size_t i = 0; i < 2; ++i) {
        watched.body(i).x_t1 = two_cloths()[i].x_t1;
        watched.body(i).x_t0 = watched.body(i).x_t1;
      }
    }
  }
  EXPECT_GT(reused, 30);
}

/// Makes one random change in a scene of soups.
void change(Watched& watched, Random& random, std::uint64_t seed) {
  const std::size_t i = random.below(static_cast<std::uint32_t>(watched.size()));
  SceneBody& body = watched.body(i);
  const std::uint32_t vertex = random.below(static_cast<std::uint32_t>(body.x_t1.size()));
  switch (random.below(12)) {
    case 0:
      body.x_t1 = jittered(body.x_t1, 0.3, seed);
      break;
    case 1:
      body.x_t0 = body.x_t1;
      break;
    case 2:
      body.x_t1[vertex] = {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0};
      break;
    case 3:
      body.x_t1[vertex] = {50.0, 0.0, 0.0};
      break;
    case 4:
      for (Vec3d& x : body.x_t1) {
        if (!(std::abs(x.x) < 10.0)) x = {0.1, 0.2, 0.3};
      }
      break;
    case 5:
      body.settings.margin = static_cast<float>(random.uniform(0.0, 0.1));
      watched.set_settings(i);
      break;
    case 6:
      body.settings.self_collision = !body.settings.self_collision;
      watched.set_settings(i);
      break;
    case 7:
      std::swap(body.triangles.front(), body.triangles.back());
      watched.update(i);
      break;
    case 8:
      watched.replace_last(SceneBody(watched.body(watched.size() - 1)));
      break;
    case 9:
      body.x_t1[vertex] = body.x_t1[0];
      break;
    default:
      break;  // it rests
  }
  watched.move_all();
}

SceneBody soup(std::uint64_t seed) {
  SoupOptions options;
  options.triangle_count = 60;
  options.half_extent = 1.0;
  options.largest = 0.5;
  options.size_ratio = 1.5;
  options.joined_share = 0.5;
  options.seed = seed;
  const Mesh mesh = triangle_soup(options);
  return moving(mesh, scattered(mesh, 0.2, seed + 100), everything(0.03F));
}

TEST(ReusedPairs, find_the_same_whatever_has_changed_in_between) {
  int reused = 0;
  for (const std::uint64_t seed : {0U, 1U, 2U, 3U, 10U}) {
    SCOPED_TRACE(seed);
    Random random(seed);
    Watched watched({soup(3 * seed + 1), soup(3 * seed + 2), soup(3 * seed + 3)});
    std::vector<Query*> queries = {&watched.query(looking_for(Detection::ccd)),
                                   &watched.query(looking_for(Detection::ccd, /*margins=*/false)),
                                   &watched.query(looking_for(Detection::dcd)), &watched.query(by_slabs())};
    for (std::uint64_t look = 0; look < 40; ++look) {
      if (random.below(2) == 0) change(watched, random, look);
      Query& query = *queries[random.below(4)];
      if (random.below(10) == 0) {
        QueryOptions options = query.options();
        options.accuracy = options.accuracy == Accuracy::precise ? Accuracy::conservative : Accuracy::precise;
        options.motion_margin = options.motion_margin > 0.0F ? 0.0F : 1.0F;
        query.set_options(options);
      }
      const std::uint32_t left_out = random.below(6);
      const PairFilter filter = [&](BodyId a, BodyId b) { return a.value + b.value != left_out; };
      watched.expect_contacts(query, random.below(4) == 0 ? filter : PairFilter());
      reused += query.statistics().reused_pairs ? 1 : 0;
    }
  }
  EXPECT_GT(reused, 15);
}

}  // namespace
}  // namespace softcd::test
