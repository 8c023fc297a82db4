#include "bodies/body_mesh.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <numeric>
#include <set>
#include <utility>

#include "bodies/vectors.hpp"
#include "softcd/core/parallel.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

constexpr std::size_t kFacesAtOnce = 2048;

Triangle triangle_of(const btSoftBody::Face& face, const btSoftBody::Node* first_node) {
  Triangle triangle{};
  for (int i = 0; i < 3; ++i) triangle.v[i] = static_cast<std::uint32_t>(face.m_n[i] - first_node);
  return triangle;
}

bool is_rope(const btSoftBody& body) {
  return body.m_faces.size() == 0 && body.m_tetras.size() == 0;
}

std::vector<Segment> segments_of(const btSoftBody& body) {
  std::vector<Segment> segments;
  if (!is_rope(body)) return segments;
  for (const btSoftBody::Link& link : span_of(body.m_links)) {
    if (link.m_bbending != 0) continue;
    const btSoftBody::Node* const first = &body.m_nodes[0];
    segments.push_back(
        {{static_cast<std::uint32_t>(link.m_n[0] - first), static_cast<std::uint32_t>(link.m_n[1] - first)}});
  }
  return segments;
}

bool has_same_segments(const BodyMesh& mesh, const btSoftBody& body) {
  const std::vector<Segment> now = segments_of(body);
  if (!now.empty() && mesh.first_node != &body.m_nodes[0]) return false;
  return std::equal(now.begin(), now.end(), mesh.segments.begin(), mesh.segments.end(),
                    [](const Segment& a, const Segment& b) { return a.v[0] == b.v[0] && a.v[1] == b.v[1]; });
}

/// Adds one face for each edge; segments may share an edge.
void add_link_faces(BodyMesh& mesh, const btSoftBody& body) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> known;
  for (const Segment& segment : mesh.segments) {
    const auto [low, high] = std::minmax(segment.v[0], segment.v[1]);
    if (high >= mesh.node_count || low == high || !known.emplace(low, high).second) continue;
    btSoftBody::Face face{};
    // Bullet's deformable solver would count a node that the face has twice as two nodes.
    const std::uint32_t third = high + 1 < mesh.node_count ? high + 1 : (low > 0 ? low - 1 : high);
    auto& nodes = const_cast<btSoftBody&>(body).m_nodes;
    face.m_n[0] = &nodes[static_cast<int>(low)];
    face.m_n[1] = &nodes[static_cast<int>(high)];
    face.m_n[2] = &nodes[static_cast<int>(third)];
    face.m_material = body.m_materials.size() > 0 ? body.m_materials[0] : nullptr;
    mesh.link_faces.push_back(face);
  }
}

bool has_side(const Triangle& triangle, std::uint32_t from, std::uint32_t to) {
  for (std::size_t corner = 0; corner < 3; ++corner) {
    if (triangle.v[corner] == from && triangle.v[(corner + 1) % 3] == to) return true;
  }
  return false;
}

/// Returns whether each edge has two faces, which pass through it in opposite directions. Unlike is_closed_surface(),
/// needs no list of edges, and allows parts that touch at a vertex.
bool is_closed_at_edges(const BodyMesh& mesh) {
  constexpr std::size_t kMostFacesAtNode = 64;  // bounds the time
  for (std::uint32_t f = 0; f < mesh.face_count; ++f) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t from = mesh.triangles[f].v[corner];
      const std::uint32_t to = mesh.triangles[f].v[(corner + 1) % 3];
      if (mesh.faces_at(from).size() > kMostFacesAtNode) return false;
      int along = 0;
      int against = 0;
      for (const FaceAtNode& at_node : mesh.faces_at(from)) {
        along += has_side(mesh.triangles[at_node.face], from, to) ? 1 : 0;
        against += has_side(mesh.triangles[at_node.face], to, from) ? 1 : 0;
      }
      if (along != 1 || against != 1) return false;
    }
  }
  return true;
}

}  // namespace

bool is_up_to_date(const BodyMesh& mesh, const btSoftBody& body) {
  if (mesh.node_count != static_cast<std::uint32_t>(body.m_nodes.size()) ||
      mesh.face_count != static_cast<std::uint32_t>(body.m_faces.size()) || !has_same_segments(mesh, body)) {
    return false;
  }
  const auto are_same = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Triangle now = triangle_of(body.m_faces[static_cast<int>(i)], &body.m_nodes[0]);
      const Triangle& then = mesh.triangles[i];
      if (!std::equal(now.v, now.v + 3, then.v)) return false;
    }
    return true;
  };
  return parallel::reduce(
      mesh.face_count, kFacesAtOnce, true,
      [&](std::size_t begin, std::size_t end, bool were_same) { return were_same && are_same(begin, end); },
      std::logical_and<>());
}

BodyMesh read_mesh(const btSoftBody& body) {
  BodyMesh mesh;
  mesh.node_count = static_cast<std::uint32_t>(body.m_nodes.size());
  mesh.face_count = static_cast<std::uint32_t>(body.m_faces.size());
  mesh.triangles.reserve(mesh.face_count);
  std::vector<bool> has_face(mesh.node_count, false);
  for (const btSoftBody::Face& face : span_of(body.m_faces)) {
    const Triangle triangle = triangle_of(face, &body.m_nodes[0]);
    for (const std::uint32_t node : triangle.v) {
      if (node < mesh.node_count) has_face[node] = true;
    }
    mesh.triangles.push_back(triangle);
  }
  mesh.segments = segments_of(body);
  for (const Segment& segment : mesh.segments) {
    for (const std::uint32_t node : segment.v) {
      if (node < mesh.node_count) has_face[node] = true;
    }
  }
  if (!mesh.segments.empty()) mesh.first_node = &body.m_nodes[0];
  add_link_faces(mesh, body);
  for (std::uint32_t node = 0; node < mesh.node_count; ++node) {
    if (!has_face[node]) mesh.triangles.push_back({{node, node, node}});
  }
  return mesh;
}

void add_faces_of_nodes(BodyMesh& mesh) {
  mesh.first_face_of_node.assign(mesh.node_count + 1, 0);
  const auto first_segment = static_cast<std::uint32_t>(mesh.triangles.size());
  const auto for_each_corner = [&](auto visit) {
    for (std::uint32_t f = 0; f < mesh.face_count; ++f) {
      const std::uint32_t(&v)[3] = mesh.triangles[f].v;
      visit(v[0], FaceAtNode{f, {v[1], v[2]}});
      visit(v[1], FaceAtNode{f, {v[0], v[2]}});
      visit(v[2], FaceAtNode{f, {v[0], v[1]}});
    }
    for (std::uint32_t s = 0; s < mesh.segments.size(); ++s) {
      const std::uint32_t(&v)[2] = mesh.segments[s].v;
      visit(v[0], FaceAtNode{first_segment + s, {v[1], v[1]}});
      visit(v[1], FaceAtNode{first_segment + s, {v[0], v[0]}});
    }
  };
  for_each_corner([&](std::uint32_t node, const FaceAtNode& /*face*/) { ++mesh.first_face_of_node[node + 1]; });
  std::partial_sum(mesh.first_face_of_node.begin(), mesh.first_face_of_node.end(), mesh.first_face_of_node.begin());
  std::vector<std::uint32_t> next(mesh.first_face_of_node.begin(), mesh.first_face_of_node.end() - 1);
  mesh.faces_of_nodes.resize(mesh.first_face_of_node.back());
  for_each_corner([&](std::uint32_t node, const FaceAtNode& face) { mesh.faces_of_nodes[next[node]++] = face; });
}

int outward_side(const BodyMesh& mesh, const btSoftBody& body) {
  if (mesh.face_count == 0 || !is_closed_at_edges(mesh)) return 0;
  const auto position = [&](std::uint32_t node) { return to_doubles(body.m_nodes[static_cast<int>(node)].m_x); };
  const Vec3d origin = position(mesh.triangles[0].v[0]);
  double volume = 0;
  for (std::uint32_t f = 0; f < mesh.face_count; ++f) {
    const auto& v = mesh.triangles[f].v;
    volume += dot(position(v[0]) - origin, cross(position(v[1]) - origin, position(v[2]) - origin));
  }
  return (volume > 0) - (volume < 0);
}

std::uint32_t face_at_edge(const BodyMesh& mesh, std::uint32_t node, std::uint32_t other) {
  for (const FaceAtNode& at_node : mesh.faces_at(node)) {
    if (at_node.has(other)) return at_node.face < mesh.face_count ? at_node.face : kNoIndex;
  }
  return kNoIndex;
}

std::vector<std::uint32_t> changed_triangles(const BodyMesh& before, const BodyMesh& now) {
  std::vector<std::uint32_t> changed;
  const std::size_t in_both = std::min(before.triangles.size(), now.triangles.size());
  for (std::size_t t = 0; t < in_both; ++t) {
    const auto& v = now.triangles[t].v;
    if (!std::equal(v, v + 3, before.triangles[t].v)) changed.push_back(static_cast<std::uint32_t>(t));
  }
  return changed;
}

Positions positions_of(const btSoftBody& body, btVector3 btSoftBody::Node::*position) {
  return {&(body.m_nodes[0].*position).m_floats[0], static_cast<std::size_t>(body.m_nodes.size()),
          sizeof(btSoftBody::Node)};
}

}  // namespace softcd::bullet
