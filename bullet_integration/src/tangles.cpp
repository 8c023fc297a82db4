#include "tangles.hpp"

#include <array>

#include "softcd/core/vec3.hpp"
#include "softcd/math/scalar.hpp"

namespace softcd::bullet {
namespace {

using Corners = std::array<Vec3d, 3>;

/// At the start of the step.
Corners corners_of(const WorldMirror::Member& member, std::uint32_t face, const WorldKind& kind) {
  const NodePosition start = start_of(kind, *member.body);
  const Triangle triangle = member.mesh.corners(face);
  Corners corners;
  for (std::size_t i = 0; i < 3; ++i) {
    const btVector3& x = member.body->m_nodes[static_cast<int>(triangle.v[i])].*start;
    corners[i] = {double(x.x()), double(x.y()), double(x.z())};
  }
  return corners;
}

class Plane {
 public:
  Plane(Vec3d a, Vec3d b, Vec3d c)
      : origin_(a), normal_(cross(b - a, c - a)), error_(kRounding * max_norm(b - a) * max_norm(c - a)) {}

  /// 1 or -1, or 0 where rounding may have decided.
  int side_of(Vec3d point) const {
    const Vec3d offset = point - origin_;
    const double volume = dot(normal_, offset);
    const double error = error_ * max_norm(offset);
    return volume > error ? 1 : (volume < -error ? -1 : 0);
  }

 private:
  /// The six terms of a determinant, each with at most eight roundings.
  static constexpr double kRounding = 1e-14;

  Vec3d origin_, normal_;
  double error_;
};

/// Of a line: whether it passes through the inside of the triangle.
bool passes_through(Vec3d p, Vec3d q, const Corners& face) {
  const int side = Plane(p, q, face[0]).side_of(face[1]);
  return side != 0 && Plane(p, q, face[1]).side_of(face[2]) == side && Plane(p, q, face[2]).side_of(face[0]) == side;
}

/// Whether an edge of the other triangle, whose corners are on these sides of the face's plane, goes through it.
bool is_pierced(const Corners& face, const Corners& other, const std::array<int, 3>& sides) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    if (sides[i] * sides[next] < 0 && passes_through(other[i], other[next], face)) return true;
  }
  return false;
}

std::array<int, 3> sides_of(const Corners& corners, const Corners& face) {
  const Plane plane(face[0], face[1], face[2]);
  return {plane.side_of(corners[0]), plane.side_of(corners[1]), plane.side_of(corners[2])};
}

bool intersect(const Corners& a, const Corners& b) {
  const std::array<int, 3> sides_of_a = sides_of(a, b);
  const int sum = sides_of_a[0] + sides_of_a[1] + sides_of_a[2];
  if (sum == 3 || sum == -3) return false;
  return is_pierced(b, a, sides_of_a) || is_pierced(a, b, sides_of(b, a));
}

/// Whether `holds` for one of the body's faces that have both nodes.
template <class Predicate>
bool any_face_with(const BodyMesh& mesh, std::uint32_t node, std::uint32_t other, Predicate holds) {
  for (std::uint32_t i = mesh.first_face_of_node[node]; i < mesh.first_face_of_node[node + 1]; ++i) {
    const std::uint32_t face = mesh.faces_of_nodes[i];
    if (has_vertex(mesh.corners(face), other) && holds(face)) return true;
  }
  return false;
}

/// Calls visit(node, other side's body) for the contact's nodes until it returns true.
template <class Visit>
bool any_node(const MemberContact& found, Visit visit) {
  const int count_a = found.contact.kind == ContactKind::vertex_triangle ? 1 : 2;
  for (int i = 0; i < 4; ++i) {
    const btSoftBody* const own = i < count_a ? found.a.body : found.b.body;
    const btSoftBody* const other = i < count_a ? found.b.body : found.a.body;
    if (visit(&own->m_nodes[static_cast<int>(found.contact.vertices[i])], other)) return true;
  }
  return false;
}

}  // namespace

bool is_tangled(const MemberContact& found, const WorldKind& kind) {
  const Contact& contact = found.contact;
  const WorldMirror::Member& a = found.a;
  const WorldMirror::Member& b = found.b;
  const bool is_vertex = contact.kind == ContactKind::vertex_triangle;
  const std::uint32_t end_of_a = contact.vertices[is_vertex ? 0 : 1];

  const auto meets_one_at_a = [&](std::uint32_t face_b) {
    const Corners corners = corners_of(b, face_b, kind);
    return any_face_with(a.mesh, contact.vertices[0], end_of_a, [&](std::uint32_t face_a) {
      const bool are_neighbours = &a == &b && share_vertex(a.mesh.corners(face_a), b.mesh.corners(face_b));
      return !are_neighbours && intersect(corners_of(a, face_a, kind), corners);
    });
  };
  if (is_vertex) return meets_one_at_a(contact.feature_b);
  return any_face_with(b.mesh, contact.vertices[2], contact.vertices[3], meets_one_at_a);
}

void TangledNodes::add(const MemberContact& found, const WorldKind& kind) {
  if (!is_tangled(found, kind)) return;
  any_node(found, [this](const btSoftBody::Node* node, const btSoftBody* other) {
    nodes_.emplace(node, other);
    return false;
  });
}

bool TangledNodes::has_one_of(const MemberContact& found) const {
  return !nodes_.empty() && any_node(found, [this](const btSoftBody::Node* node, const btSoftBody* other) {
    return nodes_.count({node, other}) > 0;
  });
}

}  // namespace softcd::bullet
