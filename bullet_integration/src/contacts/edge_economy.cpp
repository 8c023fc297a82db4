#include "contacts/edge_economy.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "bodies/vectors.hpp"
#include "contacts/contact_writer.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

/// Bound on the rounding error of differences of positions, relative to the positions.
constexpr double kPositionRounding = 1e-14;

/// One side of a contact of edges at the time of impact.
class EdgeSide {
 public:
  EdgeSide(const WorldMirror::Member& member, const std::uint32_t* nodes, double time, const NodeEnds& ends)
      : member_(member), nodes_(nodes), time_(time), start_(ends.start), end_(ends.end) {}

  const btSoftBody& body() const { return *member_.body; }
  Vec3d place(int end) const { return place_of(nodes_[end]); }
  bool has_faces() const { return bullet::face_at_edge(member_.mesh, nodes_[0], nodes_[1]) != kNoIndex; }

  /// Returns whether a face at the edge certainly leads from the point on it in the direction.
  bool has_face_towards(Vec3d point, Vec3d direction) const {
    return any_corner(nodes_, 2,
                      [&](std::uint32_t /*face*/, Vec3d corner) { return leads_towards(point, corner, direction); });
  }

  /// Returns whether a face at one of the edge's nodes is finer than the margins.
  bool has_fine_face() const {
    return std::any_of(nodes_, nodes_ + 2, [this](std::uint32_t node) {
      const Span<const FaceAtNode> faces = member_.mesh.faces_at(node);
      return std::any_of(faces.begin(), faces.end(),
                         [this](const FaceAtNode& at_node) { return is_finer_than_margins(member_, at_node.face); });
    });
  }

  /// Returns the same for faces finer than the margins, at the edge or, if the point is an end, at that end. The
  /// direction has to be nearer to the face's plane than to its normal: sharp folds keep their contacts.
  bool has_fine_face_towards(const double* weights, Vec3d point, Vec3d direction) const {
    const bool is_end = weights[0] <= 0 || weights[1] <= 0;
    return any_corner(nodes_ + (weights[0] <= 0 ? 1 : 0), is_end ? 1 : 2, [&](std::uint32_t face, Vec3d corner) {
      return is_finer_than_margins(member_, face) && is_along(face, direction) &&
             leads_towards(point, corner, direction);
    });
  }

 private:
  static bool leads_towards(Vec3d from, Vec3d to, Vec3d direction) {
    const double error = kPositionRounding * (max_norm(from) + max_norm(to));
    const Vec3d way = to - from;
    return dot(way, direction) > error * (max_norm(way) + max_norm(direction));
  }

  bool is_along(std::uint32_t face, Vec3d direction) const {
    const Triangle corners = member_.mesh.corners(face);
    const Vec3d first = place_of(corners.v[0]);
    const Vec3d normal = cross(place_of(corners.v[1]) - first, place_of(corners.v[2]) - first);
    const double along_normal = dot(normal, direction);
    return 2 * along_normal * along_normal < dot(normal, normal) * dot(direction, direction);
  }

  /// Returns whether condition(face, place) holds for another corner of a face with all of these nodes.
  template <class Condition>
  bool any_corner(const std::uint32_t* nodes, std::size_t count, Condition condition) const {
    const auto is_given = [&](std::uint32_t node) { return std::find(nodes, nodes + count, node) != nodes + count; };
    for (const FaceAtNode& at_node : member_.mesh.faces_at(*nodes)) {
      if (!std::all_of(nodes + 1, nodes + count, [&](std::uint32_t node) { return at_node.has(node); })) continue;
      for (const std::uint32_t corner : at_node.others) {
        if (!is_given(corner) && condition(at_node.face, place_of(corner))) return true;
      }
    }
    return false;
  }

  Vec3d place_of(std::uint32_t node) const {
    return (1 - time_) * member_.place(node, start_) + time_ * member_.place(node, end_);
  }

  const WorldMirror::Member& member_;
  const std::uint32_t* nodes_;
  double time_;
  NodePosition start_, end_;
};

/// Returns whether a node at the end of the edge is nearest. That node has a contact of its own with a face of the
/// other body.
bool is_contact_of_node(const EdgeSide& side, const double* weights, const EdgeSide& other) {
  return (weights[0] <= 0 || weights[1] <= 0) && side.body().isActive() && other.has_faces();
}

/// The two sides of a contact of edges.
struct EdgeSides {
  EdgeSide a, b;

  EdgeSides(const MemberContact& edges, const NodeEnds& ends)
      : a(edges.a, edges.contact.vertices, double(edges.contact.time_of_impact), ends),
        b(edges.b, edges.contact.vertices + 2, double(edges.contact.time_of_impact), ends) {}
};

/// The nearest points of two edges at the time of their contact.
struct NearestPoints {
  double weights[4];
  Vec3d point_a, point_b;

  explicit NearestPoints(const EdgeSides& edges) {
    const auto& [a, b] = edges;
    const ClosestPoints<double> closest = closest_points_edge_edge(a.place(0), a.place(1), b.place(0), b.place(1));
    std::copy(std::begin(closest.weights), std::end(closest.weights), std::begin(weights));
    point_a = weights[0] * a.place(0) + weights[1] * a.place(1);
    point_b = weights[2] * b.place(0) + weights[3] * b.place(1);
  }
};

}  // namespace

bool has_nearer_contact(const MemberContact& edges, const NodeEnds& ends) {
  if (&edges.a == &edges.b) return false;
  const EdgeSides sides(edges, ends);
  const auto& [a, b] = sides;
  const auto [w, point_a, point_b] = NearestPoints(sides);
  if (is_contact_of_node(a, w, b) || is_contact_of_node(b, w + 2, a)) return true;
  return a.has_face_towards(point_a, point_b - point_a) || b.has_face_towards(point_b, point_a - point_b);
}

bool are_joined_by_fine_faces(const MemberContact& edges, const NodeEnds& ends) {
  if (&edges.a != &edges.b) return false;
  const EdgeSides sides(edges, ends);
  const auto& [a, b] = sides;
  if (!a.has_fine_face() && !b.has_fine_face()) return false;
  const auto [w, point_a, point_b] = NearestPoints(sides);
  return a.has_fine_face_towards(w, point_a, point_b - point_a) ||
         b.has_fine_face_towards(w + 2, point_b, point_a - point_b);
}

}  // namespace softcd::bullet
