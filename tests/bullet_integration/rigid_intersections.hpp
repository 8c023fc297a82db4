#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "mesh_tools/exact_intersection.hpp"
#include "scenes/vectors.hpp"

namespace softcd::test {

using RigidTriangles = std::vector<std::array<btVector3, 3>>;

/// Returns the triangles at Bullet's pose of them.
inline RigidTriangles placed(const RigidTriangles& triangles, const btTransform& place) {
  RigidTriangles moved = triangles;
  for (auto& corners : moved) {
    for (btVector3& corner : corners) corner = place * corner;
  }
  return moved;
}

/// Edges of the one's triangles that have a point in common with a triangle of the other's, in exact arithmetic, once
/// for each triangle that they belong to.
inline std::size_t count_edges_in(const RigidTriangles& of_edges, const RigidTriangles& faces) {
  const auto are_apart = [](const btVector3& a, const btVector3& b, const std::array<btVector3, 3>& face) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto [low, high] = std::minmax({face[0][axis], face[1][axis], face[2][axis]});
      if (btMax(a[axis], b[axis]) < low || btMin(a[axis], b[axis]) > high) return true;
    }
    return false;
  };
  std::size_t count = 0;
  for (const auto& corners : of_edges) {
    for (std::size_t i = 0; i < 3; ++i) {
      const btVector3& a = corners[i];
      const btVector3& b = corners[(i + 1) % 3];
      count += std::any_of(faces.begin(), faces.end(), [&](const std::array<btVector3, 3>& face) {
        return !are_apart(a, b, face) &&
               mesh_tools::intersects(demo::to_vec3d(a), demo::to_vec3d(b),
                                      {demo::to_vec3d(face[0]), demo::to_vec3d(face[1]), demo::to_vec3d(face[2])});
      });
    }
  }
  return count;
}

/// Counts edges of the soft body in the triangles, and edges of these in its faces.
inline std::size_t count_intersections(const btSoftBody& body, const RigidTriangles& triangles) {
  RigidTriangles faces;
  for (int f = 0; f < body.m_faces.size(); ++f) {
    const btSoftBody::Face& face = body.m_faces[f];
    faces.push_back({face.m_n[0]->m_x, face.m_n[1]->m_x, face.m_n[2]->m_x});
  }
  return count_edges_in(faces, triangles) + count_edges_in(triangles, faces);
}

}  // namespace softcd::test
