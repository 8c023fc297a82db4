#include "scenes/surface_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace softcd::demo {
namespace {

SurfaceMesh icosahedron() {
  const btScalar g = (1 + btSqrt(btScalar(5))) / 2;
  SurfaceMesh mesh;
  mesh.positions = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (btVector3& position : mesh.positions) position.normalize();
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return mesh;
}

SurfaceMesh subdivided(const SurfaceMesh& coarse) {
  SurfaceMesh fine;
  fine.positions = coarse.positions;
  std::map<std::pair<int, int>, int> midpoints;
  const auto midpoint = [&](int a, int b) {
    const auto [entry, is_new] = midpoints.try_emplace(std::minmax(a, b), static_cast<int>(fine.positions.size()));
    if (is_new) {
      const btVector3 sum = fine.positions[static_cast<std::size_t>(a)] + fine.positions[static_cast<std::size_t>(b)];
      fine.positions.push_back(sum.normalized());
    }
    return entry->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const int ab = midpoint(a, b);
    const int bc = midpoint(b, c);
    const int ca = midpoint(c, a);
    fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

}  // namespace

SurfaceMesh sphere_mesh(const btVector3& center, btScalar radius, int subdivisions) {
  SurfaceMesh mesh = icosahedron();
  for (int i = 0; i < subdivisions; ++i) mesh = subdivided(mesh);
  for (btVector3& position : mesh.positions) position = center + radius * position;
  return mesh;
}

SurfaceMesh lathe_mesh(const std::vector<ProfilePoint>& profile, int segments) {
  SurfaceMesh mesh;
  std::vector<int> first_nodes;
  for (const ProfilePoint& point : profile) {
    first_nodes.push_back(static_cast<int>(mesh.positions.size()));
    const int count = point.radius > 0 ? segments : 1;
    for (int i = 0; i < count; ++i) {
      const btScalar angle = SIMD_2_PI * btScalar(i) / btScalar(segments);
      mesh.positions.emplace_back(point.radius * btCos(angle), point.height, point.radius * btSin(angle));
    }
  }
  const auto node = [&](std::size_t ring, int segment) {
    return first_nodes[ring] + (profile[ring].radius > 0 ? segment % segments : 0);
  };
  for (std::size_t ring = 0; ring + 1 < profile.size(); ++ring) {
    for (int i = 0; i < segments; ++i) {
      const int a = node(ring, i);
      const int b = node(ring, i + 1);
      const int c = node(ring + 1, i + 1);
      const int d = node(ring + 1, i);
      if (a != b) mesh.triangles.push_back({a, c, b});
      if (c != d) mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

std::vector<ProfilePoint> refined(const std::vector<ProfilePoint>& profile, btScalar spacing) {
  std::vector<ProfilePoint> points = {profile.front()};
  for (std::size_t i = 1; i < profile.size(); ++i) {
    const ProfilePoint from = profile[i - 1];
    const ProfilePoint to = profile[i];
    const btScalar length = std::hypot(to.radius - from.radius, to.height - from.height);
    const int parts = std::max(1, static_cast<int>(std::ceil(length / spacing)));
    for (int part = 1; part <= parts; ++part) {
      const btScalar t = btScalar(part) / btScalar(parts);
      points.push_back({from.radius + t * (to.radius - from.radius), from.height + t * (to.height - from.height)});
    }
  }
  return points;
}

std::unique_ptr<btSoftBody> make_body(btSoftBodyWorldInfo& world_info, const SurfaceMesh& mesh, btScalar node_mass) {
  const std::vector<btScalar> masses(mesh.positions.size(), node_mass);
  auto body = std::make_unique<btSoftBody>(&world_info, static_cast<int>(mesh.positions.size()), mesh.positions.data(),
                                           masses.data());
  // Bullet's tree builder never ends on nodes that no link joins.
  std::set<std::pair<int, int>> edges;
  for (const auto& [a, b, c] : mesh.triangles) {
    body->appendFace(a, b, c);
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
      if (edges.insert(std::minmax(from, to)).second) body->appendLink(from, to);
    }
  }
  body->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
  return body;
}

}  // namespace softcd::demo
