#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "body_pairs.hpp"
#include "reference_distance.hpp"
#include "softcd/math/closest_triangles.hpp"

// Compares nearest points of bodies with all pairs of triangles.
namespace softcd::test {
namespace {

using Corners = Vec3f[3];

void set_corners(const PlacedTriangle& triangle, Corners& x) {
  for (int i = 0; i < 3; ++i) x[i] = vec3_cast<float>(triangle.x[i]);
}

struct Nearest {
  double squared_distance = std::numeric_limits<double>::infinity();
  const PlacedTriangle* a = nullptr;
  const PlacedTriangle* b = nullptr;
};

/// Squared distances of all pairs of triangles of different bodies, in both orders.
class DistanceTable {
 public:
  explicit DistanceTable(std::vector<PlacedTriangle> triangles) : triangles_(std::move(triangles)) {
    for (const PlacedTriangle& a : triangles_) {
      Corners x_a;
      set_corners(a, x_a);
      for (const PlacedTriangle& b : triangles_) {
        Corners x_b;
        set_corners(b, x_b);
        squared_.push_back(a.body == b.body ? 0 : closest_points_of_triangles(x_a, x_b).squared_distance);
      }
    }
  }

  /// Returns the nearest two triangles of the question's bodies; of equally near ones, the first.
  Nearest nearest(ProbeBodies pair) const {
    Nearest best;
    for (std::size_t i = 0; i < squared_.size(); ++i) {
      const PlacedTriangle& a = triangles_[i / triangles_.size()];
      const PlacedTriangle& b = triangles_[i % triangles_.size()];
      const bool is_asked = a.body != b.body && (pair.a == BodyId() || pair.a == a.body) &&
                            (pair.b == BodyId() || pair.b == b.body) && (pair.a != pair.b || a.body < b.body);
      if (is_asked && squared_[i] < best.squared_distance) best = {squared_[i], &a, &b};
    }
    return best;
  }

 private:
  std::vector<PlacedTriangle> triangles_;
  std::vector<double> squared_;
};

/// Returns the distance by all pairs of features, in long double; exactly 0 for intersecting triangles.
long double reference_distance(const PlacedTriangle& a, const PlacedTriangle& b) {
  if (intersect_exactly(corners_of(a), {}, corners_of(b), {}, false)) return 0;
  long double least = std::numeric_limits<long double>::infinity();
  for (int i = 0; i < 3; ++i) {
    least = std::min(least, distance_vertex_triangle(a.x[i], b.x[0], b.x[1], b.x[2]));
    least = std::min(least, distance_vertex_triangle(b.x[i], a.x[0], a.x[1], a.x[2]));
    for (int j = 0; j < 3; ++j) {
      least = std::min(least, distance_edge_edge(a.x[i], a.x[(i + 1) % 3], b.x[j], b.x[(j + 1) % 3]));
    }
  }
  return least;
}

PlacedTriangle random_triangle(Random& random, std::uint32_t kind) {
  PlacedTriangle triangle{};
  for (Vec3d& x : triangle.x) {
    x = random.in_box(1.0);
    if (kind % 4 == 1) x = {std::round(2 * x.x), std::round(2 * x.y), std::round(2 * x.z)};
    if (kind % 4 == 2) x.z = 0;
    x = vec3_cast<double>(vec3_cast<float>(x));
  }
  if (kind % 4 == 3) triangle.x[2] = triangle.x[random.below(2)];
  return triangle;
}

TEST(BodyDistances, of_two_triangles_are_those_of_their_features) {
  Random random(12);
  int intersecting = 0;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const PlacedTriangle a = random_triangle(random, i);
    const PlacedTriangle b = random_triangle(random, i / 4);
    Corners x_a, x_b;
    set_corners(a, x_a);
    set_corners(b, x_b);
    const ClosestOnTriangles found = closest_points_of_triangles(x_a, x_b);
    const long double expected = reference_distance(a, b);
    if (expected == 0) {
      ASSERT_EQ(found.squared_distance, 0) << "triangles " << i;
      ++intersecting;
    }
    ASSERT_NEAR(std::sqrt(found.squared_distance), static_cast<double>(expected), 1e-14) << "triangles " << i;
    Vec3d offset{0, 0, 0};
    for (int corner = 0; corner < 3; ++corner) {
      ASSERT_GE(found.weights_a[corner], 0);
      ASSERT_GE(found.weights_b[corner], 0);
      offset = offset + found.weights_a[corner] * a.x[corner] - found.weights_b[corner] * b.x[corner];
    }
    ASSERT_LT(norm(offset - found.offset), 1e-14) << "triangles " << i;
    ASSERT_NEAR(norm(found.offset), static_cast<double>(expected), 1e-14) << "triangles " << i;
  }
  EXPECT_GT(intersecting, 2000);
}

void expect_at(const ProbedBodies& probed, const BodyDistance& found, double extent) {
  const auto point = [&](BodyId id, std::uint32_t triangle, const float(&weights)[3]) {
    const SceneBody& body = probed.bodies[id.value];
    Vec3d p{0, 0, 0};
    for (int corner = 0; corner < 3; ++corner) {
      p = p + double(weights[corner]) * body.x_t1[body.triangles[triangle].v[corner]];
    }
    return p;
  };
  const double tolerance = 1e-6 * extent;
  EXPECT_LT(norm(point(found.body_a, found.triangle_a, found.weights_a) - found.position_a), tolerance);
  EXPECT_LT(norm(point(found.body_b, found.triangle_b, found.weights_b) - found.position_b), tolerance);
  EXPECT_NEAR(norm(found.position_a - found.position_b), found.distance, 1e-12 * extent);
}

TEST(BodyDistances, are_the_least_of_all_triangles) {
  std::vector<NamedScene> scenes = odd_scenes();
  const Mesh ball = outward_ball(1, 1.0);
  const Mesh little = outward_ball(1, 0.25);
  scenes.push_back({"far apart", {still(ball, {}), still(moved(ball, {64, 1, 0}), {})}});
  scenes.push_back({"near", {still(ball, {}), still(moved(ball, {2.125, 0.5, 0}), {}), still(little, {})}});
  std::vector<SceneBody> many;
  const Mesh tiny = outward_ball(0, 0.25);
  for (int i = 0; i < 20; ++i) {
    const int row = i / 7;
    many.push_back(still(moved(tiny, {double(i % 7), double(row), 0.125 * (i % 3)}), {}));
  }
  scenes.push_back({"more bodies than classes", many});
  for (NamedScene& named : scenes) {
    SCOPED_TRACE(named.name);
    const double extent = extent_of(named.bodies);
    ProbedBodies probed(std::move(named.bodies));
    const DistanceTable table(placed_triangles(probed));
    std::vector<ProbeBodies> questions = {{}, {probed.ids[0], {}}, {{}, probed.ids.back()}};
    for (std::size_t i = 0; i < probed.ids.size(); i += 3) questions.push_back({probed.ids[i], probed.ids[i / 2]});
    questions.push_back({probed.ids.back(), probed.ids[0]});
    const std::vector<BodyDistance> found = copy_of(probed.probe.distances(questions));
    ASSERT_EQ(found.size(), questions.size());
    for (std::size_t i = 0; i < questions.size(); ++i) {
      SCOPED_TRACE(testing::Message() << "question " << i);
      const Nearest expected = table.nearest(questions[i]);
      ASSERT_EQ(found[i].has_points(), expected.a != nullptr);
      if (expected.a == nullptr) continue;
      ASSERT_EQ(found[i].body_a, expected.a->body);
      ASSERT_EQ(found[i].triangle_a, expected.a->index);
      ASSERT_EQ(found[i].body_b, expected.b->body);
      ASSERT_EQ(found[i].triangle_b, expected.b->index);
      ASSERT_NEAR(found[i].distance, std::sqrt(expected.squared_distance), 1e-12 * extent);
      expect_at(probed, found[i], extent);
    }
  }
}

TEST(BodyDistances, name_the_features_by_their_weights) {
  ProbedBodies probed({still(one_triangle(), {}), still(moved(one_triangle(), {-2, 0, 0}), {})});
  const BodyDistance found = probed.probe.distance({probed.ids[0], probed.ids[1]});
  EXPECT_EQ(found.distance, 1);
  EXPECT_EQ(found.weights_a[0], 1);
  EXPECT_EQ(found.weights_b[1], 1);
  EXPECT_EQ(found.weights_a[1], 0);
  EXPECT_EQ(found.weights_b[0], 0);
  EXPECT_EQ(found.position_b, (Vec3d{-1, 0, 0}));
}

TEST(BodyDistances, are_those_of_the_end_that_is_asked_about) {
  SceneBody moving_body = still(one_triangle(), {});
  for (Vec3d& x : moving_body.x_t1) x.z += 3;
  const Scene bodies = {moving_body, still(moved(one_triangle(), {0, 0, -1}), {})};
  ProbedBodies at_t1(bodies);
  ProbedBodies at_t0(bodies, StepEnd::t0);
  EXPECT_GT(at_t1.probe.distance({}).distance, 3);
  EXPECT_LT(at_t0.probe.distance({}).distance, 1);
}

}  // namespace
}  // namespace softcd::test
