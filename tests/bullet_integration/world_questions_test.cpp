// A Probe's questions about the soft bodies of a world, of softcd's class or not, compared with tests of every face.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btCapsuleShape.h"
#include "BulletCollision/CollisionShapes/btConeShape.h"
#include "BulletCollision/CollisionShapes/btConvexHullShape.h"
#include "BulletCollision/CollisionShapes/btCylinderShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "mesh_tools/exact_intersection.hpp"
#include "reference_distance.hpp"
#include "scenes/vectors.hpp"
#include "softcd/mesh/features.hpp"
#include "world_probes.hpp"

namespace softcd::test {
namespace {

using Corners = std::array<Vec3d, 3>;

class WorldQuestions : public WorldProbes {
 protected:
  /// Adds a ball whose nodes are float32 numbers, in either precision of Bullet.
  btSoftBody& add_exact_ball(const btVector3& centre) {
    btSoftBody& ball = add_ball(centre);
    for (int i = 0; i < ball.m_nodes.size(); ++i) {
      btVector3& x = ball.m_nodes[i].m_x;
      for (int axis = 0; axis < 3; ++axis) x[axis] = btScalar(std::round(double(x[axis]) * 4096) / 4096);
    }
    return ball;
  }
  btSoftBody& add_rope(const btVector3& from, const btVector3& to) {
    return simulation.add(
        std::unique_ptr<btSoftBody>(btSoftBodyHelpers::CreateRope(simulation.world_info(), from, to, 6, 0)));
  }
};
INSTANTIATE_TEST_SUITE_P(Worlds, WorldQuestions, kProbedWorlds, name_of_probed);

std::vector<Corners> corners_of(const btSoftBody& body) {
  std::vector<Corners> all;
  for (const Triangle& face : faces_of(body)) {
    all.push_back({node(body, face.v[0]), node(body, face.v[1]), node(body, face.v[2])});
  }
  return all;
}

bool has_side_through(const Corners& a, const Corners& b) {
  return mesh_tools::intersects(a[0], a[1], b) || mesh_tools::intersects(a[1], a[2], b) ||
         mesh_tools::intersects(a[2], a[0], b);
}

using FacePairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

FacePairs intersecting_faces(const btSoftBody& a, const btSoftBody& b) {
  FacePairs pairs;
  const std::vector<Corners> of_a = corners_of(a);
  const std::vector<Corners> of_b = corners_of(b);
  for (std::uint32_t i = 0; i < of_a.size(); ++i) {
    for (std::uint32_t j = 0; j < of_b.size(); ++j) {
      if (has_side_through(of_a[i], of_b[j]) || has_side_through(of_b[j], of_a[i])) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

/// Returns the distance of triangles that do not intersect.
double distance_of(const Corners& a, const Corners& b) {
  long double least = std::numeric_limits<long double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    least = std::min(
        {least, distance_vertex_triangle(a[i], b[0], b[1], b[2]), distance_vertex_triangle(b[i], a[0], a[1], a[2])});
    for (std::size_t j = 0; j < 3; ++j) {
      least = std::min(least, distance_edge_edge(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
    }
  }
  return static_cast<double>(least);
}

TEST_P(WorldQuestions, distances_of_bodies_are_those_of_their_faces) {
  btSoftBody& a = add_exact_ball({0, 0, 0});
  btSoftBody& b = add_exact_ball({btScalar(1.25), btScalar(0.25), 0});
  double least = std::numeric_limits<double>::infinity();
  for (const Corners& of_a : corners_of(a)) {
    for (const Corners& of_b : corners_of(b)) least = std::min(least, distance_of(of_a, of_b));
  }
  Probe& soft = probe.soft_bodies();
  const BodyDistance found = soft.distance({probe.body_id(a), probe.body_id(b)});
  EXPECT_NEAR(found.distance, least, 1e-9);
  EXPECT_GT(found.distance, 0.1);
  EXPECT_EQ(probe.soft_body(found.body_a), &a);
  EXPECT_EQ(probe.soft_body(found.body_b), &b);
  Vec3d at{0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    at = at + double(found.weights_a[i]) * node(a, faces_of(a)[found.triangle_a].v[i]);
  }
  EXPECT_LT(std::sqrt(squared_norm(at - found.position_a)), 1e-6);
}

TEST_P(WorldQuestions, intersections_of_bodies_are_those_of_their_faces) {
  btSoftBody& a = add_exact_ball({0, 0, 0});
  btSoftBody& b = add_exact_ball({btScalar(0.75), btScalar(0.125), 0});
  btSoftBody& apart = add_exact_ball({9, 0, 0});
  const FacePairs expected = intersecting_faces(a, b);
  EXPECT_GT(expected.size(), 20U);
  Probe& soft = probe.soft_bodies();
  const ProbeBodies pair = {probe.body_id(a), probe.body_id(b)};
  FacePairs found;
  for (const TriangleIntersection& one : soft.intersections(pair)) {
    EXPECT_EQ(probe.soft_body(one.body_a), &a);
    EXPECT_EQ(probe.soft_body(one.body_b), &b);
    found.emplace_back(one.triangle_a, one.triangle_b);
  }
  EXPECT_EQ(found, expected);
  EXPECT_EQ(soft.intersections().size(), expected.size());
  EXPECT_TRUE(soft.has_intersections(pair));
  EXPECT_FALSE(soft.has_intersections({probe.body_id(a), probe.body_id(a)}));
  EXPECT_FALSE(soft.has_intersections({probe.body_id(apart), BodyId()}));
  for (int i = 0; i < b.m_nodes.size(); ++i) b.m_nodes[i].m_x += btVector3(4, 0, 0);
  EXPECT_FALSE(probe.soft_bodies().has_intersections()) << "bodies are read where they are";
}

/// The first face's first edge is split, and the new node put there.
struct Split {
  std::vector<std::uint32_t> removed;
  std::vector<Triangle> added;
  std::vector<Vec3d> new_vertices;

  Split(const btSoftBody& body, Vec3d place) : new_vertices{place} {
    const std::vector<Triangle> faces = faces_of(body);
    const std::uint32_t ends[2] = {faces[0].v[0], faces[0].v[1]};
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
      if (!has_vertex(faces[i], ends[0]) || !has_vertex(faces[i], ends[1])) continue;
      removed.push_back(i);
      for (const std::uint32_t end : ends) {
        Triangle half = faces[i];
        std::replace(half.v, half.v + 3, end, std::uint32_t(body.m_nodes.size()));
        added.push_back(half);
      }
    }
  }
  ProbeChange question(BodyId body) const { return {body, removed, added, new_vertices}; }

  /// Halves replace removed triangles; further ones follow the last triangle.
  void make(btSoftBody& body) const {
    const Vec3d x = new_vertices[0];
    body.appendNode(btVector3(btScalar(x.x), btScalar(x.y), btScalar(x.z)), 1);
    for (std::size_t i = 0; i < added.size(); ++i) {
      const auto& v = added[i].v;
      if (i >= removed.size()) {
        body.appendFace(int(v[0]), int(v[1]), int(v[2]));
        continue;
      }
      for (int corner = 0; corner < 3; ++corner)
        body.m_faces[int(removed[i])].m_n[corner] = &body.m_nodes[int(v[corner])];
    }
  }
};

TEST_P(WorldQuestions, a_change_is_tested_before_it_is_made) {
  btSoftBody& a = add_exact_ball({0, 0, 0});
  btSoftBody& b = add_exact_ball({btScalar(1.5), 0, 0});
  const std::vector<Triangle> faces = faces_of(a);
  const Vec3d middle = 0.5 * (node(a, faces[0].v[0]) + node(a, faces[0].v[1]));
  const Split harmless(a, middle);
  const Split harmful(a, {1.5, 0, 0});
  Probe& soft = probe.soft_bodies();
  ASSERT_FALSE(soft.has_intersections());
  EXPECT_TRUE(soft.intersections_after(harmless.question(probe.body_id(a))).empty());
  const auto told = soft.intersections_after(harmful.question(probe.body_id(a)));
  const std::vector<ChangeIntersection> expected(told.begin(), told.end());
  EXPECT_GT(expected.size(), 3U);
  for (const ChangeIntersection& one : expected) {
    EXPECT_TRUE(one.body == BodyId() || probe.soft_body(one.body) == &b || probe.soft_body(one.body) == &a);
  }
  EXPECT_FALSE(soft.has_intersections()) << "nothing was changed";
  harmful.make(a);
  EXPECT_EQ(probe.soft_bodies().intersections().size(), expected.size());
}

TEST_P(WorldQuestions, shapes_overlap_the_faces_that_they_reach) {
  btSoftBody& a = add_exact_ball({0, 0, 0});
  btSoftBody& b = add_exact_ball({btScalar(0.875), 0, 0});
  std::vector<ProbeCapsule> capsules;
  std::vector<ProbeSphere> spheres;
  Random random(8);
  for (int i = 0; i < 40; ++i) {
    capsules.push_back({random.in_box(1.5), random.in_box(1.5), random.uniform(0, 0.3)});
    spheres.push_back({random.in_box(1.2), random.uniform(0, 0.5)});
  }
  const auto found_of = [&](Span<const TriangleOverlap> overlaps) {
    std::set<std::pair<const btSoftBody*, std::uint32_t>> found;
    for (const TriangleOverlap& one : overlaps) found.emplace(probe.soft_body(one.body), one.triangle);
    return found;
  };
  const auto expect_found = [&](const auto& found, const auto& distance, double radius) {
    for (const btSoftBody* body : {&a, &b}) {
      const std::vector<Corners> corners = corners_of(*body);
      for (std::uint32_t i = 0; i < corners.size(); ++i) {
        const double gap = distance(corners[i]) - radius;
        if (std::abs(gap) < 1e-9) continue;
        EXPECT_EQ(found.count({body, i}) > 0, gap < 0) << "face " << i << ", gap " << gap;
      }
    }
  };
  Probe& soft = probe.soft_bodies();
  std::size_t count = 0;
  const AnswerLists<TriangleOverlap> in_capsules = soft.overlaps(capsules);
  for (std::size_t i = 0; i < capsules.size(); ++i) {
    const ProbeCapsule& capsule = capsules[i];
    count += in_capsules[i].size();
    expect_found(
        found_of(in_capsules[i]),
        [&](const Corners& x) {
          return mesh_tools::intersects(capsule.from, capsule.to, x)
                     ? 0.0
                     : distance_of({capsule.from, capsule.to, capsule.to}, x);
        },
        capsule.radius);
  }
  const AnswerLists<TriangleOverlap> in_spheres = soft.overlaps(spheres);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    count += in_spheres[i].size();
    expect_found(
        found_of(in_spheres[i]),
        [&](const Corners& x) { return double(distance_vertex_triangle(spheres[i].centre, x[0], x[1], x[2])); },
        spheres[i].radius);
  }
  EXPECT_GT(count, 300U);
}

/// A shape, and by how much a point of its own space is outside, along some direction; less than 0 inside.
struct KnownShape {
  std::unique_ptr<btConvexShape> shape;
  std::function<double(Vec3d)> excess;
  double error = 0;  ///< that inscribed circles make
};

std::vector<KnownShape> known_shapes() {
  std::vector<KnownShape> shapes;
  const auto add = [&](std::unique_ptr<btConvexShape> shape, double error, std::function<double(Vec3d)> excess) {
    shapes.push_back({std::move(shape), std::move(excess), error});
  };
  const auto without_margin = [](std::unique_ptr<btConvexShape> shape) {
    shape->setMargin(0);
    return shape;
  };
  const auto from_axis = [](Vec3d x) { return std::sqrt(x.x * x.x + x.z * x.z); };
  add(std::make_unique<btSphereShape>(btScalar(0.5)), 0, [](Vec3d x) { return std::sqrt(squared_norm(x)) - 0.5; });
  add(std::make_unique<btCapsuleShape>(btScalar(0.25), btScalar(1)), 0, [](Vec3d x) {
    return double(distance_point_segment(x, {0, -0.5, 0}, {0, 0.5, 0})) - 0.25;
  });
  add(without_margin(std::make_unique<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.25), btScalar(0.75)))), 0,
      [](Vec3d x) {
        return std::max({std::abs(x.x) - 0.5, std::abs(x.y) - 0.25, std::abs(x.z) - 0.75});
      });
  auto hull = std::make_unique<btConvexHullShape>();
  for (int i = 0; i < 6; ++i) {
    btVector3 corner(0, 0, 0);
    corner[i / 2] = btScalar(i % 2 == 0 ? 0.75 : -0.75);
    hull->addPoint(corner);
  }
  add(without_margin(std::move(hull)), 0, [](Vec3d x) { return std::abs(x.x) + std::abs(x.y) + std::abs(x.z) - 0.75; });
  add(without_margin(std::make_unique<btCylinderShape>(btVector3(btScalar(0.5), btScalar(0.25), btScalar(0.5)))), 0.003,
      [=](Vec3d x) { return std::max(from_axis(x) - 0.5, std::abs(x.y) - 0.25); });
  add(without_margin(std::make_unique<btConeShape>(btScalar(0.5), btScalar(1))), 0.003,
      [=](Vec3d x) { return std::max(-0.5 - x.y, from_axis(x) - (0.25 - 0.5 * x.y)); });
  return shapes;
}

TEST_P(WorldQuestions, shapes_of_bullets_overlap_what_is_in_them) {
  // Nodes alone: points that a shape has, or has not.
  std::vector<btVector3> nodes;
  Random random(77);
  for (int i = 0; i < 200; ++i) {
    const Vec3d x = random.in_box(1);
    nodes.emplace_back(btScalar(x.x), btScalar(x.y), btScalar(x.z));
  }
  const std::vector<btScalar> masses(nodes.size(), 1);
  btSoftBody& cloud = simulation.add(
      std::make_unique<btSoftBody>(&simulation.world_info(), int(nodes.size()), nodes.data(), masses.data()));
  const btTransform place(btQuaternion(btVector3(1, 2, 3).normalized(), 1),
                          btVector3(btScalar(0.25), btScalar(0.125), 0));
  Probe& soft = probe.soft_bodies();
  for (const KnownShape& known : known_shapes()) {
    SCOPED_TRACE(known.shape->getName());
    const bullet::ShapeHull hull(*known.shape, place);
    const ProbeHull question = hull.query();
    const Span<const TriangleOverlap> found = soft.overlaps({&question, 1})[0];
    std::set<std::uint32_t> inside;
    for (const TriangleOverlap& one : found) inside.insert(one.triangle);
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      const btVector3 x = place.invXform(cloud.m_nodes[int(i)].m_x);
      const double excess = known.excess(demo::to_vec3d(x));
      if (excess > -known.error - 1e-5 && excess < 1e-5) continue;
      EXPECT_EQ(inside.count(i) > 0, excess < 0) << "node " << i << ", " << excess;
    }
    EXPECT_GT(inside.size(), 5U);
  }
}

TEST_P(WorldQuestions, ropes_answer_by_their_links) {
  btSoftBody& ball = add_exact_ball({0, 0, 0});
  btSoftBody& rope = add_rope({-1, btScalar(0.75), 0}, {1, btScalar(0.75), 0});
  Probe& soft = probe.soft_bodies();
  const BodyDistance gap = soft.distance({probe.body_id(rope), probe.body_id(ball)});
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < rope.m_links.size(); ++i) {
    const auto at = [&](int end) { return node(rope, std::uint32_t(rope.m_links[i].m_n[end] - &rope.m_nodes[0])); };
    for (const Corners& face : corners_of(ball)) least = std::min(least, distance_of({at(0), at(1), at(1)}, face));
  }
  EXPECT_NEAR(gap.distance, least, 1e-6);
  // The middle of the link in the rope's middle, far from its nodes.
  const ClosestPoint nearest = soft.closest_point({{0, 1, 0}});
  EXPECT_EQ(probe.soft_body(nearest.body), &rope);
  EXPECT_NEAR(nearest.distance, 0.25, 1e-6);
  for (int i = 0; i < rope.m_nodes.size(); ++i) rope.m_nodes[i].m_x -= btVector3(0, btScalar(0.75), 0);
  EXPECT_TRUE(probe.soft_bodies().has_intersections({probe.body_id(rope), probe.body_id(ball)}));
}

TEST_P(WorldQuestions, a_body_that_was_replaced_answers_no_more) {
  btSoftBody& a = add_exact_ball({0, 0, 0});
  const BodyId id = (probe.soft_bodies(), probe.body_id(a));
  const std::unique_ptr<btSoftBody> removed = simulation.remove(a);
  btSoftBody& b = add_exact_ball({5, 0, 0});
  Probe& soft = probe.soft_bodies();
  EXPECT_EQ(probe.soft_body(id), nullptr);
  EXPECT_EQ(probe.soft_body(soft.closest_point({{0, 0, 0}}).body), &b);
  EXPECT_THROW(probe.body_id(*removed), InvalidInput);
  EXPECT_EQ(probe.soft_body(probe.body_id(b)), &b);
}

TEST_P(WorldQuestions, of_an_empty_world_have_no_answers) {
  Probe& soft = probe.soft_bodies();
  EXPECT_FALSE(soft.has_intersections());
  EXPECT_TRUE(soft.intersections().empty());
  EXPECT_FALSE(soft.distance({}).has_points());
  const ProbeCapsule capsule = {{0, 0, 0}, {1, 0, 0}, 1};
  EXPECT_TRUE(soft.overlaps({&capsule, 1})[0].empty());
}

}  // namespace
}  // namespace softcd::test
