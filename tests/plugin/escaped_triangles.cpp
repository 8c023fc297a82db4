#include <gtest/gtest.h>

#include <vector>

#include "mesh_generators.hpp"
#include "random.hpp"
#include "watched.hpp"

// Triangles that have left their kept volumes are looked up beside the kept pairs, or make the detection new.
namespace softcd::test {
namespace {

/// Returns two sheets beside each other, out of each other's reach until a test changes that.
Scene apart() {
  Mesh left = grid_cloth(6, 6, 1.0);
  Mesh right = left;
  right.positions = translated(right.positions, {0.0, 0.0, 0.5});
  return {still(left, everything(0.1F)), still(right, everything(0.1F))};
}

TEST(EscapedTriangles, are_looked_up_on_whatever_axis_they_left) {
  const std::vector<Vec3d> ways = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::size_t count = 0;
  int reused = 0;
  for (const Vec3d& way : ways) {
    for (const double distance : {1e-5, 0.3, 0.45}) {
      Watched watched(apart());
      Query& query = watched.query(looking_for(Detection::ccd));
      rest(watched, query);
      Vec3d& moved = watched.body(1).x_t1[14];
      moved = moved + distance * way;
      watched.move(1);
      for (int look = 0; look < 2; ++look) {
        count += watched.expect_contacts(query);
        reused += query.statistics().reused_pairs ? 1 : 0;
      }
    }
  }
  EXPECT_GT(count, 0U);
  EXPECT_GT(reused, 24);  // not where the bodies come within each other's reach
}

TEST(EscapedTriangles, that_are_many_make_the_detection_new) {
  Watched watched(two_cloths());
  Query& query = watched.query(looking_for(Detection::ccd));
  rest(watched, query);
  for (std::size_t vertex = 0; vertex < 60; ++vertex) watched.body(0).x_t1[vertex].z += 0.3;
  watched.move(0);
  EXPECT_GT(watched.expect_contacts(query), 100U);
  EXPECT_FALSE(query.statistics().reused_pairs);
}

// More triangles escape than are looked up, but few of all.
TEST(EscapedTriangles, that_are_many_make_the_detection_of_a_large_scene_new) {
  const Mesh lower = grid_cloth(52, 52, 0.2);
  Mesh upper = lower;
  upper.positions = translated(upper.positions, {0.05, 0.03, 0.03});
  Watched watched({still(lower, everything(0.02F)), still(upper, everything(0.02F))});
  Query& query = watched.query(looking_for(Detection::dcd));
  rest(watched, query);
  for (std::size_t vertex = 3; vertex < 2500; vertex += 19) watched.body(1).x_t1[vertex].z -= 0.2;
  watched.move(1);
  EXPECT_GT(watched.expect_contacts(query), 300U);
  EXPECT_FALSE(query.statistics().reused_pairs);
}

// Escaped triangles become as large as the scene. They have more pairs than any detection before.
TEST(EscapedTriangles, may_have_more_pairs_than_lists_hold) {
  Mesh scraps;
  for (std::uint32_t i = 0; i < 36; ++i) {
    const double x = 0.1 * i;
    scraps.positions.insert(scraps.positions.end(), {{x, 0.0, 0.5}, {x + 0.05, 0.0, 0.5}, {x, 0.05, 0.5}});
    scraps.triangles.push_back({{3 * i, 3 * i + 1, 3 * i + 2}});
  }
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    Watched watched({still(grid_cloth(15, 15, 0.3), everything(0.02F)), still(scraps, everything(0.6F))});
    Query& query = watched.query(looking_for(detection));
    rest(watched, query);
    const std::uint64_t before = query.statistics().triangle_pairs;
    Positions3& x = watched.body(1).x_t1;
    for (std::size_t i = 0; i < x.size(); i += 3) {
      x[i] = {-3.0, -3.0, 0.1};
      x[i + 1] = {9.0, -3.0, 0.1};
      x[i + 2] = {-3.0, 9.0, 0.1};
    }
    watched.move(1);
    EXPECT_GT(watched.expect_contacts(query), 1000U);
    EXPECT_TRUE(query.statistics().reused_pairs);
    EXPECT_GT(query.statistics().triangle_pairs, 8000 + before);
  }
}

// In each step a few vertices of both bodies go far away from where their triangles were kept. Some go on from there,
// some return, and some meet a vertex of the other body that also moves.
TEST(EscapedTriangles, that_are_few_are_looked_up_for_long) {
  for (const Detection detection : {Detection::dcd, Detection::ccd}) {
    const Scene start = two_cloths();
    Watched watched(start);
    Query& query = watched.query(looking_for(detection));
    rest(watched, query);
    Random random(7);
    EXPECT_EQ(query.statistics().looked_up_triangles, 0U);
    int reused = 0;
    int looked_up = 0;
    std::vector<std::size_t> away;
    for (int step = 0; step < 250; ++step) {
      for (std::size_t i = 0; i < 2; ++i) watched.body(i).x_t0 = watched.body(i).x_t1;
      if (away.size() >= 5) {  // the first comes back
        for (std::size_t i = 0; i < 2; ++i) watched.body(i).x_t1[away.front()] = start[i].x_t1[away.front()];
        away.erase(away.begin());
      }
      if (step % 2 == 0) away.push_back(random.below(static_cast<std::uint32_t>(start[0].x_t1.size())));
      for (const std::size_t vertex : away) {
        Vec3d& a = watched.body(0).x_t1[vertex];
        Vec3d& b = watched.body(1).x_t1[vertex];
        a = a + random.in_box(0.3);
        if (random.below(2) == 0) b = a;
      }
      watched.move_all();
      EXPECT_GT(watched.expect_contacts(query), 50U);
      reused += query.statistics().reused_pairs ? 1 : 0;
      looked_up += query.statistics().looked_up_triangles > 0 ? 1 : 0;
    }
    EXPECT_GT(reused, 150);
    EXPECT_LE(looked_up, reused);
    EXPECT_GT(looked_up, 150);
  }
}

}  // namespace
}  // namespace softcd::test
