// Questions about worlds with soft bodies, of softcd's class or not, compared with brute force and analytic distances.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h"
#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "BulletCollision/CollisionShapes/btSphereShape.h"
#include "BulletCollision/CollisionShapes/btTriangleMesh.h"
#include "random.hpp"
#include "reference_distance.hpp"
#include "scene.hpp"
#include "world_probes.hpp"

namespace softcd::test {
namespace {

/// A node, face or edge of each side.
using Features = std::array<int, 4>;

/// A contact as a contact test's callback received it.
struct Reported {
  const btCollisionObject *object, *other;
  Features features;  ///< part and index of the object, then of the other
  btVector3 on_object, on_other, normal;
  btScalar distance;
};

struct Listener : btCollisionWorld::ContactResultCallback {
  std::vector<Reported> told;
  const btCollisionObject* unwanted = nullptr;

  explicit Listener(btScalar threshold = 0) { m_closestDistanceThreshold = threshold; }
  bool needsCollision(btBroadphaseProxy* proxy) const override {
    return proxy->m_clientObject != unwanted && ContactResultCallback::needsCollision(proxy);
  }
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int part_a, int index_a,
                           const btCollisionObjectWrapper* b, int part_b, int index_b) override {
    told.push_back({a->getCollisionObject(),
                    b->getCollisionObject(),
                    {part_a, index_a, part_b, index_b},
                    point.getPositionWorldOnA(),
                    point.getPositionWorldOnB(),
                    point.m_normalWorldOnB,
                    point.getDistance()});
    return 0;
  }
  std::vector<Features> features() const {
    std::vector<Features> all;
    for (const Reported& one : told) all.push_back(one.features);
    std::sort(all.begin(), all.end());
    return all;
  }
};

/// Which nodes have no face: they are points.
std::vector<bool> single_nodes_of(const btSoftBody& body) {
  std::vector<bool> are_single(std::size_t(body.m_nodes.size()), true);
  for (const Triangle& face : faces_of(body)) {
    for (const std::uint32_t v : face.v) are_single[v] = false;
  }
  return are_single;
}

/// All pairs of features of two soft bodies, of which none is decided by rounding.
std::vector<Features> brute_force(const btSoftBody& a, const btSoftBody& b, double threshold) {
  const double limit =
      double(a.getCollisionShape()->getMargin()) + double(b.getCollisionShape()->getMargin()) + threshold;
  std::vector<Features> found;
  const auto decide = [&](long double distance, const Features& features) {
    EXPECT_GT(std::abs(double(distance) - limit), 1e-7) << "decides nothing";
    if (double(distance) <= limit) found.push_back(features);
  };
  const auto add_nodes = [&](const btSoftBody& of_nodes, const btSoftBody& of_faces, bool is_a) {
    const std::vector<Triangle> faces = faces_of(of_faces);
    for (std::uint32_t n = 0; n < std::uint32_t(of_nodes.m_nodes.size()); ++n) {
      for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto& v = faces[f].v;
        const int i = int(n);
        const int j = int(f);
        decide(distance_vertex_triangle(node(of_nodes, n), node(of_faces, v[0]), node(of_faces, v[1]),
                                        node(of_faces, v[2])),
               is_a ? Features{bullet::kNodePart, i, bullet::kFacePart, j}
                    : Features{bullet::kFacePart, j, bullet::kNodePart, i});
      }
    }
  };
  add_nodes(a, b, true);
  add_nodes(b, a, false);
  const std::vector<bool> single_a = single_nodes_of(a);
  const std::vector<bool> single_b = single_nodes_of(b);
  for (std::uint32_t i = 0; i < single_a.size(); ++i) {
    for (std::uint32_t j = 0; j < single_b.size(); ++j) {
      if (!single_a[i] && !single_b[j]) continue;
      decide(std::sqrt(squared_norm(node(a, i) - node(b, j))), {bullet::kNodePart, int(i), bullet::kNodePart, int(j)});
    }
  }
  const std::vector<Edge> edges_a = edges_of(faces_of(a));
  const std::vector<Edge> edges_b = edges_of(faces_of(b));
  for (std::size_t i = 0; i < edges_a.size(); ++i) {
    for (std::size_t j = 0; j < edges_b.size(); ++j) {
      decide(distance_edge_edge(node(a, edges_a[i].v[0]), node(a, edges_a[i].v[1]), node(b, edges_b[j].v[0]),
                                node(b, edges_b[j].v[1])),
             {bullet::kEdgePart, int(i), bullet::kEdgePart, int(j)});
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

INSTANTIATE_TEST_SUITE_P(Worlds, WorldProbes, kProbedWorlds, name_of_probed);

TEST_P(WorldProbes, tell_every_pair_of_features_of_soft_bodies) {
  btSoftBody& a = add_ball({0, 0, 0});
  btSoftBody& b = add_ball({btScalar(0.8), btScalar(0.1), 0});
  add_ball({5, 0, 0});
  for (const btScalar threshold : {btScalar(0), btScalar(0.11)}) {
    Listener pair(threshold), all(threshold), other_way(threshold);
    probe.contact_pair_test(a, b, pair);
    EXPECT_EQ(pair.features(), brute_force(a, b, double(threshold)));
    EXPECT_GT(pair.told.size(), 10U);
    probe.contact_test(a, all);
    EXPECT_EQ(all.features(), pair.features());
    probe.contact_pair_test(b, a, other_way);
    EXPECT_EQ(other_way.features(), brute_force(b, a, double(threshold)));
    for (const Listener* listener : {&pair, &other_way}) {
      for (const Reported& one : listener->told) {
        EXPECT_EQ(one.object, listener == &pair ? &a : &b);
        const btScalar gap = (one.on_object - one.on_other).dot(one.normal);
        EXPECT_NEAR(gap, one.distance + btScalar(0.06), 1e-5);
        EXPECT_LE(one.distance, threshold);
      }
    }
  }
  EXPECT_EQ(a.m_scontacts.size() + a.m_faceNodeContacts.size(), 0);
}

TEST_P(WorldProbes, follow_what_apps_do_to_bodies) {
  btSoftBody& a = add_ball({0, 0, 0});
  btSoftBody& b = add_ball({btScalar(0.8), btScalar(0.1), 0});
  const auto count = [&] {
    Listener listener;
    probe.contact_test(a, listener);
    return listener.told.size();
  };
  EXPECT_GT(count(), 0U);
  for (int i = 0; i < b.m_nodes.size(); ++i) b.m_nodes[i].m_x += btVector3(1, 0, 0);
  EXPECT_EQ(count(), 0U);
  for (int i = 0; i < b.m_nodes.size(); ++i) b.m_nodes[i].m_x -= btVector3(1, 0, 0);
  EXPECT_EQ(count(), brute_force(a, b, 0).size());
  for (int f = b.m_faces.size() - 1; f >= 0; --f) {
    const auto& corners = b.m_faces[f].m_n;
    if (std::find(std::begin(corners), std::end(corners), &b.m_nodes[0]) == std::end(corners)) continue;
    b.m_faces.swap(f, b.m_faces.size() - 1);
    b.m_faces.pop_back();
  }
  Listener without_node;
  probe.contact_test(a, without_node);
  EXPECT_EQ(without_node.features(), brute_force(a, b, 0)) << "edges have new numbers";
  b.m_faces.resize(3);
  EXPECT_EQ(count(), brute_force(a, b, 0).size());
  Listener unwanted;
  unwanted.unwanted = &b;
  probe.contact_test(a, unwanted);
  EXPECT_TRUE(unwanted.told.empty());
  const std::unique_ptr<btSoftBody> removed = simulation.remove(b);
  EXPECT_EQ(count(), 0U);
}

TEST_P(WorldProbes, tell_what_a_body_touches_of_itself) {
  btSoftBody& a = add_ball({0, 0, 0});
  Listener none;
  probe.contact_pair_test(a, a, none);
  Listener all(btScalar(0.5));
  probe.contact_pair_test(a, a, all);
  EXPECT_LT(none.told.size(), all.told.size());
  EXPECT_GT(all.told.size(), 100U);
  // Both of a pair's sides are the body: each pair once.
  std::vector<Features> features = all.features();
  EXPECT_EQ(std::adjacent_find(features.begin(), features.end()), features.end());
}

/// Returns each node's least distance among the reported contacts.
std::map<int, double> least_distances(const Listener& listener, const btCollisionObject* soft) {
  std::map<int, double> least;
  for (const Reported& one : listener.told) {
    const bool is_object = one.object == soft;
    const int part = one.features[is_object ? 0 : 2];
    const int index = one.features[is_object ? 1 : 3];
    if (part != bullet::kNodePart) continue;
    const auto [entry, is_new] = least.try_emplace(index, double(one.distance));
    entry->second = std::min(entry->second, double(one.distance));
  }
  return least;
}

/// Expects that the nodes within `threshold` of the surface that `signed_distance` measures, and no others, are
/// reported at that distance.
template <class SignedDistance>
void expect_distances(const Listener& listener, const btSoftBody& soft, double threshold,
                      const SignedDistance& signed_distance) {
  const std::map<int, double> least = least_distances(listener, &soft);
  std::size_t expected = 0;
  for (int i = 0; i < soft.m_nodes.size(); ++i) {
    const double distance =
        signed_distance(node(soft, std::uint32_t(i))) - double(soft.getCollisionShape()->getMargin());
    if (std::abs(distance - threshold) < 1e-5) continue;
    const auto found = least.find(i);
    EXPECT_EQ(found != least.end(), distance < threshold) << "node " << i << " at " << distance;
    if (found == least.end()) continue;
    ++expected;
    EXPECT_NEAR(found->second, distance, 1e-5) << "node " << i;
  }
  EXPECT_GT(expected, 3U);
}

/// From a box with rounded edges, as Bullet has it, less than 0 within its core too.
double distance_to_box(Vec3d x, Vec3d half, double margin) {
  const Vec3d outside = {std::abs(x.x) - (half.x - margin), std::abs(x.y) - (half.y - margin),
                         std::abs(x.z) - (half.z - margin)};
  const double inside = std::max({outside.x, outside.y, outside.z});
  if (inside < 0) return inside - margin;
  const Vec3d positive = {std::max(0.0, outside.x), std::max(0.0, outside.y), std::max(0.0, outside.z)};
  return std::sqrt(squared_norm(positive)) - margin;
}

TEST_P(WorldProbes, tell_nodes_outside_and_inside_of_convex_shapes) {
  btSoftBody& ball = add_ball({0, btScalar(0.9), 0});
  auto shape = std::make_unique<btBoxShape>(btVector3(1, btScalar(0.6), 1));
  const double margin = double(shape->getMargin());
  btRigidBody& box = simulation.add_rigid(std::move(shape), btVector3(0, 0, 0));
  btRigidBody& sphere =
      simulation.add_rigid(std::make_unique<btSphereShape>(btScalar(0.4)), btVector3(btScalar(0.3), btScalar(1.3), 0));
  simulation.add_rigid(std::make_unique<btSphereShape>(btScalar(0.3)), btVector3(0, 0, 9));
  for (const btScalar threshold : {btScalar(0), btScalar(0.2)}) {
    Listener of_box(threshold), of_sphere(threshold), of_ball(threshold), other_way(threshold);
    probe.contact_pair_test(ball, box, of_box);
    expect_distances(of_box, ball, double(threshold), [&](Vec3d x) { return distance_to_box(x, {1, 0.6, 1}, margin); });
    probe.contact_pair_test(ball, sphere, of_sphere);
    const auto distance_to_sphere = [](Vec3d x) {
      return std::sqrt(squared_norm(x - Vec3d{double(btScalar(0.3)), double(btScalar(1.3)), 0})) -
             double(btScalar(0.4));
    };
    expect_distances(of_sphere, ball, double(threshold), distance_to_sphere);
    probe.contact_test(ball, of_ball);
    EXPECT_EQ(of_ball.told.size(), of_box.told.size() + of_sphere.told.size());
    probe.contact_pair_test(box, ball, other_way);
    EXPECT_EQ(other_way.told.size(), of_box.told.size());
    expect_distances(other_way, ball, double(threshold), [&](Vec3d x) {
      return distance_to_box(x, {1, 0.6, 1}, margin);
    });
    for (const Reported& one : other_way.told) EXPECT_EQ(one.object, &box);
  }
  EXPECT_EQ(AnySimulation::count_contacts(ball), 0) << "Bullet's contact test leaves contacts behind";
}

TEST_P(WorldProbes, tell_what_rigid_objects_touch) {
  btSoftBody& ball = add_ball({0, btScalar(0.9), 0});
  btRigidBody& box =
      simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, btScalar(0.6), 1)), btVector3(0, 0, 0), 1);
  btRigidBody& other =
      simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1)), btVector3(btScalar(1.9), 0, 0));
  Listener soft_alone, all;
  probe.contact_pair_test(box, ball, soft_alone);
  probe.contact_test(box, all);
  EXPECT_GT(soft_alone.told.size(), 5U);
  std::size_t rigid = 0;
  for (const Reported& one : all.told) rigid += one.object == &other || one.other == &other ? 1 : 0;
  EXPECT_GT(rigid, 0U);
  EXPECT_EQ(all.told.size(), soft_alone.told.size() + rigid);
}

TEST_P(WorldProbes, tell_what_touches_compounds_and_triangle_meshes) {
  btSoftBody& ball = add_ball({0, btScalar(0.5), 0});
  btBoxShape low(btVector3(2, btScalar(0.1), 2));
  btSphereShape high(btScalar(0.2));
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, 0, 0)), &low);
  compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, 1, 0)), &high);
  btRigidBody& of_two = simulation.add_rigid(std::move(compound), btVector3(0, 0, 0));
  Listener told;
  probe.contact_pair_test(ball, of_two, told);
  expect_distances(told, ball, 0, [&](Vec3d x) {
    return std::min(distance_to_box(x, {2, double(btScalar(0.1)), 2}, double(low.getMargin())),
                    std::sqrt(squared_norm(x - Vec3d{0, 1, 0})) - double(btScalar(0.2)));
  });
  btTriangleMesh triangles;
  triangles.addTriangle({-3, 0, -3}, {3, 0, -3}, {0, 0, 3});
  btRigidBody& ground =
      simulation.add_rigid(std::make_unique<btBvhTriangleMeshShape>(&triangles, true), btVector3(0, btScalar(0.02), 0));
  const double margin = double(ground.getCollisionShape()->getMargin());
  Listener of_ground(btScalar(0.05));
  probe.contact_pair_test(ball, ground, of_ground);
  expect_distances(of_ground, ball, double(btScalar(0.05)),
                   [&](Vec3d x) { return std::abs(x.y - double(btScalar(0.02))) - margin; });
  simulation.world().removeRigidBody(&ground);
}

/// The nearest that a ray meets.
struct NearestHit : btCollisionWorld::RayResultCallback {
  int face = -1;

  btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool /*is_in_world_space*/) override {
    if (result.m_hitFraction > m_closestHitFraction) return m_closestHitFraction;
    m_closestHitFraction = result.m_hitFraction;
    m_collisionObject = result.m_collisionObject;
    face = result.m_localShapeInfo != nullptr ? result.m_localShapeInfo->m_triangleIndex : -1;
    return m_closestHitFraction;
  }
};

TEST_P(WorldProbes, rays_meet_what_they_meet_in_batches) {
  btSoftBody& a = add_ball({0, 0, 0});
  btSoftBody& b = add_ball({btScalar(0.8), btScalar(0.1), 0});
  simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(1, 1, 1)), btVector3(0, 0, 20));
  simulation.world().updateAabbs();
  Random random(5);
  std::vector<Ray> rays;
  for (int i = 0; i < 200; ++i) rays.push_back(segment(random.in_box(3), random.in_box(0.6)));
  const Span<const RayHit> hits = probe.soft_bodies().first_hits(rays);
  int count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto point = [](Vec3d x) { return btVector3(btScalar(x.x), btScalar(x.y), btScalar(x.z)); };
    NearestHit nearest;
    probe.ray_test(point(rays[i].origin), point(rays[i].origin + rays[i].direction), nearest);
    ASSERT_EQ(hits[i].has_hit(), nearest.hasHit()) << "ray " << i;
    if (!nearest.hasHit()) continue;
    ++count;
    EXPECT_EQ(probe.soft_body(hits[i].body), nearest.m_collisionObject);
    EXPECT_EQ(int(hits[i].triangle), nearest.face);
    EXPECT_NEAR(hits[i].t, nearest.m_closestHitFraction, 1e-5);
  }
  EXPECT_GT(count, 100);
  EXPECT_EQ(a.m_fdbvt.m_root, nullptr) << "a face tree was built, in quadratic time";
  NearestHit box;
  probe.ray_test({0, 0, 30}, {0, 0, 10}, box);
  EXPECT_TRUE(box.hasHit());
  const ClosestPoint nearest = probe.soft_bodies().closest_point({{10, 0, 0}});
  EXPECT_EQ(probe.soft_body(nearest.body), &b);
  const std::unique_ptr<btSoftBody> removed = simulation.remove(b);
  EXPECT_EQ(probe.soft_body(probe.soft_bodies().closest_point({{10, 0, 0}}).body), &a);
  EXPECT_EQ(probe.soft_body(nearest.body), nullptr);
}

TEST_P(WorldProbes, answer_nothing_in_empty_worlds_and_of_what_is_no_number) {
  EXPECT_FALSE(probe.soft_bodies().closest_point({{0, 0, 0}}).has_point());
  btSoftBody& a = add_ball({0, 0, 0});
  btSoftBody& b = add_ball({btScalar(0.8), btScalar(0.1), 0});
  Listener before, after, alone;
  probe.contact_test(a, before);
  EXPECT_GT(before.told.size(), 0U);
  for (int i = 0; i < b.m_nodes.size(); ++i) b.m_nodes[i].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
  probe.contact_test(a, after);
  EXPECT_EQ(after.told.size(), 0U);
  const std::unique_ptr<btSoftBody> removed = simulation.remove(b);
  probe.contact_test(a, alone);
  EXPECT_EQ(alone.told.size(), 0U);
}

}  // namespace
}  // namespace softcd::test
