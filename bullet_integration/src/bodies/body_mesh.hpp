#pragma once

#include <vector>

#include "BulletSoftBody/btSoftBody.h"
#include "native/arrays.hpp"
#include "softcd/mesh/features.hpp"
#include "softcd/softcd.hpp"

namespace softcd::bullet {

/// A face or segment at a node. Tests of contacts walk around nodes, and find all that they need in one array.
struct FaceAtNode {
  std::uint32_t face;       ///< segments are numbered after all triangles
  std::uint32_t others[2];  ///< the other nodes, in the face's order; a segment's other node twice

  bool has(std::uint32_t other) const { return others[0] == other || others[1] == other; }
};

/// A soft body's triangles and segments as node indices. Segments are the links of a rope: a body without faces and
/// tetrahedra. Bending links, which join nodes beyond their neighbours, are left out. Nodes without a face or a segment
/// collide as points: each gets a triangle {n, n, n} after the faces' triangles.
struct BodyMesh {
  std::vector<Triangle> triangles;
  std::vector<Segment> segments;
  std::uint32_t face_count = 0;  ///< triangles from here on represent single nodes
  std::uint32_t node_count = 0;
  const btSoftBody::Node* first_node = nullptr;  ///< address of the first node when the mesh was read
  /// The faces and segments at node n begin at faces_of_nodes[first_face_of_node[n]]. WorldMirror fills both arrays,
  /// and `outward`.
  std::vector<std::uint32_t> first_face_of_node;
  std::vector<FaceAtNode> faces_of_nodes;
  /// 1 if the faces' normals point out of a closed surface, -1 if they point into it, 0 if the surface is open.
  int outward = 0;
  /// Faces that represent links in Bullet's contacts, in the order of their edges as in Contact. A body with link faces
  /// has no other edges. The third node is another node of the body if there is one, and its weight is 0.
  std::vector<btSoftBody::Face> link_faces;

  Span<const FaceAtNode> faces_at(std::uint32_t node) const {
    const std::uint32_t first = first_face_of_node[node];
    return {faces_of_nodes.data() + first, first_face_of_node[node + 1] - first};
  }
  /// Returns the nodes of a face or segment, by its number in FaceAtNode.
  Triangle corners(std::uint32_t face) const {
    if (face < triangles.size()) return triangles[face];
    const auto& v = segments[face - triangles.size()].v;
    return {{v[0], v[1], v[1]}};
  }
};

/// Returns whether the body's faces or links still join the nodes that `mesh` says. Bullet leaves no reliable trace of
/// a change: refine() and randomizeConstraints() reorder them in place. So all of them are compared.
bool is_up_to_date(const BodyMesh& mesh, const btSoftBody& body);

BodyMesh read_mesh(const btSoftBody& body);
/// Fills first_face_of_node and faces_of_nodes. All faces' nodes must be the body's.
void add_faces_of_nodes(BodyMesh& mesh);
/// Returns BodyMesh::outward. Needs faces_of_nodes. A surface with more than 64 faces around a node counts as open.
int outward_side(const BodyMesh& mesh, const btSoftBody& body);
/// Returns the first face that has both nodes, or kNoIndex.
std::uint32_t face_at_edge(const BodyMesh& mesh, std::uint32_t node, std::uint32_t other);

/// Returns the indices of triangles that both meshes have and whose nodes differ, ascending.
std::vector<std::uint32_t> changed_triangles(const BodyMesh& before, const BodyMesh& now);

/// Returns the nodes' m_x or m_q as a view of the body's own memory.
Positions positions_of(const btSoftBody& body, btVector3 btSoftBody::Node::*position);

}  // namespace softcd::bullet
