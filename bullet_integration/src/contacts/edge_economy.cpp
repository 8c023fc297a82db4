#include "contacts/edge_economy.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "bodies/vectors.hpp"
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
      : member_(member), nodes_(nodes), time_(time), start_(start_of(ends, *member.body)), end_(ends.end) {}

  const btSoftBody& body() const { return *member_.body; }
  Vec3d place(int end) const { return place_of(nodes_[end]); }
  bool has_faces() const { return bullet::face_at_edge(member_.mesh, nodes_[0], nodes_[1]) != kNoIndex; }

  /// Returns whether a face at the edge certainly leads from the point on it in the direction.
  bool has_face_towards(Vec3d point, Vec3d direction) const {
    for (const std::uint32_t number : member_.mesh.faces_at(nodes_[0])) {
      const Triangle face = member_.mesh.corners(number);
      if (!has_vertex(face, nodes_[1])) continue;
      const auto* const corner = std::find_if(std::begin(face.v), std::end(face.v), [this](std::uint32_t node) {
        return node != nodes_[0] && node != nodes_[1];
      });
      if (corner != std::end(face.v) && leads_towards(point, place_of(*corner), direction)) return true;
    }
    return false;
  }

 private:
  static bool leads_towards(Vec3d from, Vec3d to, Vec3d direction) {
    const double error = kPositionRounding * (max_norm(from) + max_norm(to));
    const Vec3d way = to - from;
    return dot(way, direction) > error * (max_norm(way) + max_norm(direction));
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

}  // namespace

bool has_nearer_contact(const MemberContact& edges, const NodeEnds& ends) {
  if (&edges.a == &edges.b) return false;
  const double time = double(edges.contact.time_of_impact);
  const EdgeSide a(edges.a, edges.contact.vertices, time, ends);
  const EdgeSide b(edges.b, edges.contact.vertices + 2, time, ends);
  const ClosestPoints<double> closest = closest_points_edge_edge(a.place(0), a.place(1), b.place(0), b.place(1));
  const double(&w)[4] = closest.weights;
  if (is_contact_of_node(a, w, b) || is_contact_of_node(b, w + 2, a)) return true;
  const Vec3d point_a = w[0] * a.place(0) + w[1] * a.place(1);
  const Vec3d point_b = w[2] * b.place(0) + w[3] * b.place(1);
  return a.has_face_towards(point_a, point_b - point_a) || b.has_face_towards(point_b, point_a - point_b);
}

}  // namespace softcd::bullet
