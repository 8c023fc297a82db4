#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "brute_force.hpp"

namespace softcd::test {

inline std::vector<Triangle> triangles_of(const btSoftBody& body) {
  std::vector<Triangle> triangles(static_cast<std::size_t>(body.m_faces.size()));
  int f = 0;
  for (Triangle& triangle : triangles) {
    const btSoftBody::Face& face = body.m_faces[f++];
    for (int i = 0; i < 3; ++i) triangle.v[i] = static_cast<std::uint32_t>(face.m_n[i] - &body.m_nodes[0]);
  }
  return triangles;
}

inline Positions3 positions_of(const btSoftBody& body) {
  Positions3 positions;
  positions.reserve(static_cast<std::size_t>(body.m_nodes.size()));
  for (int n = 0; n < body.m_nodes.size(); ++n) {
    const btVector3& x = body.m_nodes[n].m_x;
    positions.push_back({double(x.x()), double(x.y()), double(x.z())});
  }
  return positions;
}

/// Finds the nodes that meet a face on their straight way through a step, in exact arithmetic: faces of other bodies,
/// and of their own where it collides with itself.
class CrossingFinder {
 public:
  explicit CrossingFinder(std::vector<btSoftBody*> bodies) : bodies_(std::move(bodies)) {
    for (btSoftBody* body : bodies_) {
      SceneBody scene_body;
      scene_body.triangles = triangles_of(*body);
      scene_body.x_t1 = positions_of(*body);
      scene_body.settings.features = {/*vertex_triangle=*/true, /*edge_edge=*/false};
      scene_body.settings.self_collision = body->useSelfCollision();
      scene_.push_back(std::move(scene_body));
    }
  }

  /// Returns crossings on the straight paths since the last call, or the constructor. Call it after each of the world's
  /// steps.
  std::vector<FeaturePair> find() {
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      scene_[b].x_t0 = std::move(scene_[b].x_t1);
      scene_[b].x_t1 = positions_of(*bodies_[b]);
    }
    return continuous_verdicts(scene_).certain;
  }

 private:
  std::vector<btSoftBody*> bodies_;
  Scene scene_;
};

}  // namespace softcd::test
