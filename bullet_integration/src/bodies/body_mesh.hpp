#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

inline Span<btSoftBody* const> span_of(const btAlignedObjectArray<btSoftBody*>& bodies) {
  if (bodies.size() == 0) return {};
  return {&bodies[0], static_cast<std::size_t>(bodies.size())};
}

/// A soft body's triangles and segments as node indices. Segments are the links of a body that has nothing else, a
/// rope: no faces, no tetrahedra; but for bending links, which join nodes beyond their neighbours. Nodes without a face
/// and a segment collide as points: each gets a triangle {n, n, n} behind the faces'.
struct BodyMesh {
  std::vector<Triangle> triangles;
  std::vector<Segment> segments;
  std::uint32_t face_count = 0;  ///< triangles from here on stand for single nodes
  std::uint32_t node_count = 0;
  const btSoftBody::Node* first_node = nullptr;  ///< where the nodes were
  /// What is around node n are faces_of_nodes[first_face_of_node[n]] and on: faces, and behind all triangles segments.
  /// WorldMirror fills them.
  std::vector<std::uint32_t> first_face_of_node, faces_of_nodes;
  /// Of links: faces that Bullet's contacts can be with, in the order of their edges as in Contact; a body that has
  /// some has no other edges. The third node is another one of the body, where there is one, and has no weight in them.
  std::vector<btSoftBody::Face> link_faces;

  /// Returns the nodes of a face or segment, by its number in faces_of_nodes.
  Triangle corners(std::uint32_t face) const {
    if (face < triangles.size()) return triangles[face];
    const auto& v = segments[face - triangles.size()].v;
    return {{v[0], v[1], v[1]}};
  }
};

/// Whether the body's faces, or links, still join the nodes that `mesh` says. Bullet leaves no reliable trace of a
/// change: refine() and randomizeConstraints() reorder them in place, so all of them are compared.
bool is_up_to_date(const BodyMesh& mesh, const btSoftBody& body);

BodyMesh read_mesh(const btSoftBody& body);
/// Fills first_face_of_node and faces_of_nodes. No face has a node that is not the body's.
void add_faces_of_nodes(BodyMesh& mesh);
/// Returns the first of the faces that have both nodes, kNoIndex where there is none.
std::uint32_t face_at_edge(const BodyMesh& mesh, std::uint32_t node, std::uint32_t other);

/// Those that join other nodes now, of the triangles that there were and are, ascending.
std::vector<std::uint32_t> changed_triangles(const BodyMesh& before, const BodyMesh& now);

/// The nodes' m_x or m_q, a view of the body's own memory.
Positions positions_of(const btSoftBody& body, btVector3 btSoftBody::Node::*position);

}  // namespace softcd::bullet
