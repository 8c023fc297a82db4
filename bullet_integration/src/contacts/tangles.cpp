#include "contacts/tangles.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "bodies/vectors.hpp"
#include "softcd/core/vec3.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/math/orientation.hpp"
#include "softcd/math/scalar.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

using Corners = std::array<Vec3d, 3>;

/// Bound on rounding errors, relative to the operands. Each term has at most eight roundings, six of them in a
/// determinant.
constexpr double kRounding = 1e-14;

/// Returns whether the first `count_a` points lie beyond the others along x, y or z. Exact, however narrow the gap is.
template <std::size_t kCount>
bool are_clear_along_an_axis(const std::array<Vec3d, kCount>& x, std::size_t count_a) {
  for (int axis = 0; axis < 3; ++axis) {
    double low[2] = {x[0][axis], x[count_a][axis]};
    double high[2] = {low[0], low[1]};
    for (std::size_t i = 1; i < kCount; ++i) {
      const int side = i < count_a ? 0 : 1;
      low[side] = std::min(low[side], x[i][axis]);
      high[side] = std::max(high[side], x[i][axis]);
    }
    if (low[0] > high[1] || low[1] > high[0]) return true;
  }
  return false;
}

Corners corners_of(const WorldMirror::Member& member, std::uint32_t face, NodePosition position) {
  const Triangle triangle = member.mesh.corners(face);
  const std::uint32_t(&v)[3] = triangle.v;
  return {member.place(v[0], position), member.place(v[1], position), member.place(v[2], position)};
}

class Plane {
 public:
  /// Makes the plane through `origin` along the directions `u` and `w`.
  Plane(Vec3d origin, Vec3d u, Vec3d w)
      : origin_(origin), normal_(cross(u, w)), error_(kRounding * max_norm(u) * max_norm(w)) {}

  /// Returns whether the directions are parallel, up to rounding.
  bool is_degenerate() const { return !(max_norm(normal_) > error_); }

  /// Returns 1 or -1, or 0 if rounding may have decided.
  int side_of(Vec3d point) const {
    const Vec3d offset = point - origin_;
    const double volume = dot(normal_, offset);
    const double error = error_ * max_norm(offset) + std::numeric_limits<double>::min();
    return volume > error ? 1 : (volume < -error ? -1 : 0);
  }

 private:
  Vec3d origin_, normal_;
  double error_;
};

/// Returns 1 or -1 for the side of the plane through a, b and c on which the point lies, or exactly 0 in the plane.
int side_of_plane(Vec3d a, Vec3d b, Vec3d c, Vec3d point) {
  return -orientation(a, b, c, point);
}

/// Returns the sides of the other triangle's plane on which the corners lie, or exactly 0 in the plane.
std::array<int, 3> sides_of(const Corners& corners, const Corners& other) {
  const Plane plane(other[0], other[1] - other[0], other[2] - other[0]);
  const auto side_of = [&](Vec3d corner) {
    const int side = plane.side_of(corner);
    return side != 0 ? side : side_of_plane(other[0], other[1], other[2], corner);
  };
  return {side_of(corners[0]), side_of(corners[1]), side_of(corners[2])};
}

/// Rotates the corners so that the one that is alone on its side is first. Returns false if no two are on different
/// sides.
bool put_lone_corner_first(Corners& corners, std::array<int, 3>& sides) {
  const auto count = [&sides](int side) { return std::count(sides.begin(), sides.end(), side); };
  if (count(1) == 0 || count(-1) == 0) return false;
  const auto lone = std::find(sides.begin(), sides.end(), count(1) == 1 ? 1 : -1);
  std::rotate(corners.begin(), corners.begin() + (lone - sides.begin()), corners.end());
  std::rotate(sides.begin(), lone, sides.end());
  return true;
}

/// How two triangles that are not in one plane meet.
enum class Meeting {
  apart,             ///< they have no points in common
  touch_or_apart,    ///< their insides have no points in common
  intersect_inside,  ///< their insides, without borders, have points in common
};

/// Exact. Method: Guigue and Devillers, Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates
/// (2003). The lone corners are first, and on the other triangle's positive side. On the line that the planes share,
/// each triangle then begins before the other ends.
Meeting meeting_of(Corners a, Corners b) {
  std::array<int, 3> sides_of_a = sides_of(a, b);
  if (!put_lone_corner_first(a, sides_of_a)) return Meeting::touch_or_apart;
  std::array<int, 3> sides_of_b = sides_of(b, a);
  if (!put_lone_corner_first(b, sides_of_b)) return Meeting::touch_or_apart;
  if (sides_of_a[0] < 0) std::swap(b[1], b[2]);
  if (sides_of_b[0] < 0) std::swap(a[1], a[2]);
  const int ends[2] = {side_of_plane(a[0], a[1], b[0], b[1]), side_of_plane(a[0], a[2], b[2], b[0])};
  if (ends[0] < 0 && ends[1] < 0) return Meeting::intersect_inside;
  const auto is_beside = [](const std::array<int, 3>& sides) { return sides[0] * sides[1] * sides[2] != 0; };
  const bool may_touch = !is_beside(sides_of_a) || !is_beside(sides_of_b) || std::max(ends[0], ends[1]) <= 0;
  return may_touch ? Meeting::touch_or_apart : Meeting::apart;
}

/// Links are represented as triangles that repeat their second corner.
bool is_link(const Corners& corners) {
  return corners[1] == corners[2];
}

/// Returns whether a link passes through the inside of a triangle.
bool goes_through(const Corners& link, const Corners& face) {
  const auto side_of_face = [&face](Vec3d end) { return side_of_plane(face[0], face[1], face[2], end); };
  if (side_of_face(link[0]) * side_of_face(link[1]) >= 0) return false;
  const int side = side_of_plane(link[0], link[1], face[0], face[1]);
  return side != 0 && side_of_plane(link[0], link[1], face[1], face[2]) == side &&
         side_of_plane(link[0], link[1], face[2], face[0]) == side;
}

/// Returns Meeting::touch_or_apart for two links, for which this cannot be decided.
Meeting meeting_of_faces(const Corners& a, const Corners& b) {
  if (!is_link(a) && !is_link(b)) return meeting_of(a, b);
  const bool intersect = is_link(a) ? !is_link(b) && goes_through(a, b) : goes_through(b, a);
  return intersect ? Meeting::intersect_inside : Meeting::touch_or_apart;
}

/// Returns whether `holds` for one of the body's faces that have both nodes, which may be the same.
template <class Predicate>
bool any_face_with(const BodyMesh& mesh, std::uint32_t node, std::uint32_t other, Predicate holds) {
  const Span<const FaceAtNode> faces = mesh.faces_at(node);
  return std::any_of(faces.begin(), faces.end(), [&](const FaceAtNode& at_node) {
    return (other == node || at_node.has(other)) && holds(at_node);
  });
}

/// Returns whether `holds` for a node, other than these two, of a face that has both.
template <class Predicate>
bool any_other_corner(const BodyMesh& mesh, std::uint32_t node, std::uint32_t other, Predicate holds) {
  return any_face_with(mesh, node, other, [&](const FaceAtNode& at_node) {
    return std::any_of(std::begin(at_node.others), std::end(at_node.others),
                       [&](std::uint32_t corner) { return corner != node && corner != other && holds(corner); });
  });
}

/// Returns whether `holds` for a face at one feature and a face at the other that share no node. Leaves out faces at
/// the other feature for which `may_hold` is false; it is called once for each, before `holds`.
template <class Filter, class Predicate>
bool any_two_faces(const MemberContact& found, Filter may_hold, Predicate holds) {
  const Contact& contact = found.contact;
  const WorldMirror::Member& a = found.a;
  const WorldMirror::Member& b = found.b;
  const bool is_vertex = contact.kind == ContactKind::vertex_triangle;
  const std::uint32_t end_of_a = contact.vertices[is_vertex ? 0 : 1];

  const auto holds_for_one_at_a = [&](std::uint32_t face_b) {
    return may_hold(face_b) && any_face_with(a.mesh, contact.vertices[0], end_of_a, [&](const FaceAtNode& at_a) {
             const bool are_neighbours = &a == &b && share_vertex(a.mesh.corners(at_a.face), b.mesh.corners(face_b));
             return !are_neighbours && holds(at_a.face, face_b);
           });
  };
  if (is_vertex) return holds_for_one_at_a(contact.feature_b);
  return any_face_with(b.mesh, contact.vertices[2], contact.vertices[3],
                       [&](const FaceAtNode& at_b) { return holds_for_one_at_a(at_b.face); });
}

/// The faces around a point of a mesh: all faces that have the smallest feature with the point.
struct Fan {
  std::vector<Triangle> triangles;
  std::vector<Corners> faces;
  std::vector<Vec3d> edges;  ///< of these faces, at the feature; each direction once
};

void add_direction(std::vector<Vec3d>& directions, Vec3d direction) {
  const auto is_parallel = [direction](Vec3d other) { return Plane({0, 0, 0}, direction, other).is_degenerate(); };
  if (std::none_of(directions.begin(), directions.end(), is_parallel)) directions.push_back(direction);
}

Fan fan_of(const WorldMirror::Member& member, const std::vector<std::uint32_t>& feature, NodePosition position) {
  const auto is_of_feature = [&](std::uint32_t node) {
    return std::find(feature.begin(), feature.end(), node) != feature.end();
  };
  Fan fan;
  any_face_with(member.mesh, feature[0], feature.back(), [&](const FaceAtNode& at_node) {
    const Triangle triangle = member.mesh.corners(at_node.face);
    const std::uint32_t(&v)[3] = triangle.v;
    if (std::count_if(std::begin(v), std::end(v), is_of_feature) < std::ptrdiff_t(feature.size())) return false;
    const Corners corners = corners_of(member, at_node.face, position);
    fan.triangles.push_back(triangle);
    fan.faces.push_back(corners);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t next = (i + 1) % 3;
      if (is_of_feature(v[i]) || is_of_feature(v[next])) add_direction(fan.edges, corners[next] - corners[i]);
    }
    return false;
  });
  return fan;
}

/// Returns the least and the greatest side of a plane that the fan's corners are on.
std::pair<int, int> sides_of(const Fan& fan, const Plane& plane) {
  std::pair<int, int> sides{0, 0};
  for (const Corners& corners : fan.faces) {
    for (const Vec3d corner : corners) {
      const int side = plane.side_of(corner);
      sides = {std::min(sides.first, side), std::max(sides.second, side)};
      if (sides.first < 0 && sides.second > 0) return sides;
    }
  }
  return sides;
}

/// Returns whether a plane through the shared point separates the fans; a fan may lie in the plane. If convex cones can
/// be separated, some plane along two of their edges separates them. If the features cross at no node, that plane
/// contains both.
bool are_separable(const Fan& a, const Fan& b, Vec3d point) {
  std::vector<Vec3d> edges = a.edges;
  for (const Vec3d edge : b.edges) add_direction(edges, edge);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = i + 1; j < edges.size(); ++j) {
      const Plane plane(point, edges[i], edges[j]);
      const auto [least_of_a, greatest_of_a] = sides_of(a, plane);
      if (least_of_a < 0 && greatest_of_a > 0) continue;
      const auto [least_of_b, greatest_of_b] = sides_of(b, plane);
      if ((least_of_a >= 0 && greatest_of_b <= 0) || (greatest_of_a <= 0 && least_of_b >= 0)) return true;
    }
  }
  return false;
}

/// A point at which features touch.
struct Touch {
  std::vector<std::uint32_t> nodes_a, nodes_b;  ///< of the smallest features at the point
  Vec3d point;                                  ///< a node at the point; if there is none, a node of the first feature

  bool is_at(const Touch& other) const { return nodes_a == other.nodes_a && nodes_b == other.nodes_b; }
};

/// Two bodies with their nodes' positions at the start of the step.
struct Sides {
  Sides(const MemberContact& found, const NodeEnds& ends) : a(found.a), b(found.b), start(ends.start) {}

  const WorldMirror::Member &a, &b;
  NodePosition start;
};

/// A feature of the first side and one of the second, as four nodes and their positions. The first `count_a` nodes are
/// the first side's.
class FeaturePair {
 public:
  FeaturePair(const Sides& sides, std::size_t count_a, const std::array<std::uint32_t, 4>& nodes)
      : sides_(sides), count_a_(count_a), nodes_(nodes) {
    for (std::size_t i = 0; i < 4; ++i) {
      x_[i] = i < count_a ? sides.a.place(nodes[i], sides.start) : sides.b.place(nodes[i], sides.start);
    }
    extent_ = std::max({max_norm(x_[1] - x_[0]), max_norm(x_[2] - x_[0]), max_norm(x_[3] - x_[0])});
  }

  double extent() const { return extent_; }

  /// Returns whether features that touch up to rounding are nevertheless apart, as their nodes are in no common plane.
  /// Exact. Ends of two edges also count as apart where they are at different places: the pairs of either node with the
  /// other's faces decide.
  bool are_apart(const Touch& touch) const {
    if (orientation(x_[0], x_[1], x_[2], x_[3]) != 0) return true;
    return count_a_ == 2 && touch.nodes_a.size() == 1 && touch.nodes_b.size() == 1 &&
           sides_.a.place(touch.nodes_a[0], sides_.start) != sides_.b.place(touch.nodes_b[0], sides_.start);
  }

  std::optional<Touch> touch() const {
    if (are_clear_along_an_axis(x_, count_a_)) return {};
    const ClosestPoints<double> closest = closest_points();
    if (!(closest.distance() <= kRounding * extent_)) return {};
    Touch touch;
    for (std::size_t i = 0; i < 4; ++i) {
      if (closest.weights[i] > kRounding) (i < count_a_ ? touch.nodes_a : touch.nodes_b).push_back(nodes_[i]);
    }
    if (touch.nodes_a.empty() || touch.nodes_b.empty()) return {};  // a coordinate is not a number
    const bool is_node_of_b = touch.nodes_b.size() == 1 && touch.nodes_a.size() > 1;
    touch.point =
        is_node_of_b ? sides_.b.place(touch.nodes_b[0], sides_.start) : sides_.a.place(touch.nodes_a[0], sides_.start);
    return touch;
  }

 private:
  ClosestPoints<double> closest_points() const {
    if (count_a_ == 1) return closest_points_vertex_triangle(x_[0], x_[1], x_[2], x_[3]);
    if (count_a_ == 2) return closest_points_edge_edge(x_[0], x_[1], x_[2], x_[3]);
    ClosestPoints<double> closest = closest_points_vertex_triangle(x_[3], x_[0], x_[1], x_[2]);
    std::rotate(std::begin(closest.weights), std::begin(closest.weights) + 1, std::end(closest.weights));
    return closest;
  }

  const Sides& sides_;
  std::size_t count_a_;
  std::array<std::uint32_t, 4> nodes_;
  std::array<Vec3d, 4> x_;
  double extent_;
};

/// Returns where the contact's features touch at the start of the step.
std::optional<Touch> touch_of(const MemberContact& found, const NodeEnds& ends) {
  const Contact& contact = found.contact;
  const std::uint32_t(&v)[4] = contact.vertices;
  const Sides sides(found, ends);
  const FeaturePair features(sides, static_cast<std::size_t>(vertices_of_a(contact)), {v[0], v[1], v[2], v[3]});
  constexpr double kRoundingOfContacts = 1e-5;
  if (double(contact.distance) > kRoundingOfContacts * features.extent()) return {};
  return features.touch();
}

/// Returns whether `holds` for a point at which a corner of one face is on the other, or edges of both meet.
template <class Predicate>
bool any_touch(const Sides& sides, std::uint32_t face_a, std::uint32_t face_b, Predicate holds) {
  const Triangle triangle_a = sides.a.mesh.corners(face_a);
  const Triangle triangle_b = sides.b.mesh.corners(face_b);
  const std::uint32_t(&a)[3] = triangle_a.v;
  const std::uint32_t(&b)[3] = triangle_b.v;
  const auto holds_at = [&](std::size_t count_a, const std::array<std::uint32_t, 4>& nodes) {
    const FeaturePair features(sides, count_a, nodes);
    const std::optional<Touch> touch = features.touch();
    return touch.has_value() && !features.are_apart(*touch) && holds(*touch);
  };
  for (int i = 0; i < 3; ++i) {
    if (holds_at(1, {a[i], b[0], b[1], b[2]}) || holds_at(3, {a[0], a[1], a[2], b[i]})) return true;
    for (int j = 0; j < 3; ++j) {
      if (holds_at(2, {a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]})) return true;
    }
  }
  return false;
}

/// Returns whether a face lies beyond the other along an axis, or on one side of its plane, without touching it.
/// Returns false if rounding may have decided.
bool are_apart(const Corners& a, const Corners& b) {
  const auto is_beside = [](const Corners& face, const Corners& other) {
    const std::array<int, 3> sides = sides_of(face, other);
    return sides[0] != 0 && sides[1] == sides[0] && sides[2] == sides[0];
  };
  const std::array<Vec3d, 6> both = {a[0], a[1], a[2], b[0], b[1], b[2]};
  return are_clear_along_an_axis(both, 3) || is_beside(a, b) || is_beside(b, a);
}

bool are_neighbours(const Fan& a, const Fan& b) {
  return std::any_of(a.triangles.begin(), a.triangles.end(), [&b](const Triangle& one) {
    return std::any_of(b.triangles.begin(), b.triangles.end(),
                       [&one](const Triangle& other) { return share_vertex(one, other); });
  });
}

/// Returns whether the faces around a point of touch are on both sides of each other. Returns false if some of them
/// share nodes, for which this cannot be decided.
bool are_through_at(const Touch& touch, const Sides& sides) {
  const Fan a = fan_of(sides.a, touch.nodes_a, sides.start);
  const Fan b = fan_of(sides.b, touch.nodes_b, sides.start);
  return !(&sides.a == &sides.b && are_neighbours(a, b)) && !are_separable(a, b, touch.point);
}

/// Returns whether the faces intersect, or touch at a point where the faces around them intersect. The second case
/// finds a body that passes through a face along its border or at a corner: it meets the inside of no face. `b` has the
/// corners of face_b. `separable` has the touches where that is not so, which other faces at the same features have as
/// well.
bool are_through_each_other(const Sides& sides, std::uint32_t face_a, std::uint32_t face_b, const Corners& b,
                            std::vector<Touch>& separable) {
  const Corners a = corners_of(sides.a, face_a, sides.start);
  if (are_apart(a, b)) return false;
  const Meeting meeting = meeting_of_faces(a, b);
  if (meeting != Meeting::touch_or_apart) return meeting == Meeting::intersect_inside;
  return any_touch(sides, face_a, face_b, [&](const Touch& touch) {
    const auto is_known = [&touch](const Touch& known) { return known.is_at(touch); };
    if (std::any_of(separable.begin(), separable.end(), is_known)) return false;
    if (are_through_at(touch, sides)) return true;
    separable.push_back(touch);
    return false;
  });
}

/// Gap along a contact's normal beyond which rounding certainly does not decide, relative to the distances.
constexpr double kClearGap = 1e-12;

/// Returns whether a gap along the contact's normal certainly separates all faces at one feature from all faces at the
/// other. Then none of them have points in common.
bool are_clear_along_the_normal(const MemberContact& found, const Sides& sides, FirstFan& first) {
  first.read(found, sides.start);
  const Contact& contact = found.contact;
  const std::uint32_t(&v)[4] = contact.vertices;
  const Vec3d normal = vec3_cast<double>(contact.normal);
  double extent = first.extent();
  double highest_of_b = -std::numeric_limits<double>::infinity();
  const auto raise = [&](std::uint32_t node) {
    const Vec3d offset = sides.b.place(node, sides.start) - first.origin();
    extent = std::max(extent, max_norm(offset));
    highest_of_b = std::max(highest_of_b, dot(offset, normal));
    return false;
  };
  for (int i = vertices_of_a(contact); i < 4; ++i) raise(v[i]);
  if (contact.kind == ContactKind::edge_edge) any_other_corner(found.b.mesh, v[2], v[3], raise);
  const std::vector<Vec3d>& offsets = first.offsets();
  return std::all_of(offsets.begin(), offsets.end(),
                     [&](Vec3d offset) { return dot(offset, normal) - highest_of_b > kClearGap * extent; });
}

/// Returns whether all nodes of the first feature's faces lie beyond the face along an axis, or certainly on one side
/// of its plane. Then none of their faces has a point in common with it.
bool are_apart(const FirstFan& first, const Corners& face) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax({face[0][axis], face[1][axis], face[2][axis]});
    if (low > first.high()[axis] || high < first.low()[axis]) return true;
  }
  const Plane plane(face[0], face[1] - face[0], face[2] - face[0]);
  const std::vector<Vec3d>& places = first.places();
  const int side = plane.side_of(places.front());
  return side != 0 &&
         std::all_of(places.begin() + 1, places.end(), [&](Vec3d place) { return plane.side_of(place) == side; });
}

/// Returns whether both features are links, for which intersections cannot be decided. A body has either links or
/// faces.
bool are_links(const MemberContact& found) {
  return found.a.mesh.triangles.empty() && found.b.mesh.triangles.empty();
}

}  // namespace

void FirstFan::read(const MemberContact& found, NodePosition start) {
  const std::uint32_t(&v)[4] = found.contact.vertices;
  const std::uint32_t end = found.contact.kind == ContactKind::vertex_triangle ? v[0] : v[1];
  if (member_ == &found.a && ends_[0] == v[0] && ends_[1] == end) return;
  member_ = &found.a;
  ends_[0] = v[0];
  ends_[1] = end;
  nodes_.clear();
  places_.clear();
  offsets_.clear();
  extent_ = 0;
  origin_ = low_ = high_ = found.a.place(v[0], start);
  add(v[0], start);
  if (end != v[0]) add(end, start);
  any_other_corner(found.a.mesh, v[0], end, [&](std::uint32_t corner) {
    if (std::find(nodes_.begin(), nodes_.end(), corner) == nodes_.end()) add(corner, start);
    return false;
  });
}

void FirstFan::add(std::uint32_t node, NodePosition start) {
  nodes_.push_back(node);
  places_.push_back(member_->place(node, start));
  offsets_.push_back(places_.back() - origin_);
  const Vec3d place = places_.back();
  low_ = {std::min(low_.x, place.x), std::min(low_.y, place.y), std::min(low_.z, place.z)};
  high_ = {std::max(high_.x, place.x), std::max(high_.y, place.y), std::max(high_.z, place.z)};
  extent_ = std::max(extent_, max_norm(offsets_.back()));
}

bool is_tangled(const MemberContact& found, const NodeEnds& ends) {
  FirstFan first;
  return is_tangled(found, ends, first);
}

bool is_tangled(const MemberContact& found, const NodeEnds& ends, FirstFan& first) {
  const Sides sides(found, ends);
  if (are_clear_along_the_normal(found, sides, first)) return false;
  Corners b;
  const auto may_meet = [&](std::uint32_t face_b) {
    b = corners_of(sides.b, face_b, sides.start);
    return !are_apart(first, b);
  };
  std::vector<Touch> separable;
  return any_two_faces(found, may_meet, [&](std::uint32_t face_a, std::uint32_t face_b) {
    return are_through_each_other(sides, face_a, face_b, b, separable);
  });
}

bool is_touching(const MemberContact& found, const NodeEnds& ends) {
  return !are_links(found) && touch_of(found, ends).has_value();
}

bool may_be_tangled_at_the_end(const MemberContact& found, const NodeEnds& ends) {
  const auto all = [](std::uint32_t /*face_b*/) { return true; };
  return are_links(found) || any_two_faces(found, all, [&](std::uint32_t face_a, std::uint32_t face_b) {
           const Meeting meeting =
               meeting_of_faces(corners_of(found.a, face_a, ends.end), corners_of(found.b, face_b, ends.end));
           return meeting == Meeting::intersect_inside;
         });
}

bool change_sides(const MemberContact& found, const NodeEnds& ends) {
  const auto side_at = [&found](NodePosition position_a, NodePosition position_b) {
    const auto place = [&](int i) { return to_doubles(found.node(i).*(found.is_of_a(i) ? position_a : position_b)); };
    return orientation(place(0), place(1), place(2), place(3));
  };
  const Sides sides(found, ends);
  const int start = side_at(sides.start, sides.start);
  return start != 0 && side_at(ends.end, ends.end) != start;
}

void TangledNodes::add(const MemberContact& found) {
  for (int i = 0; i < 4; ++i) add(found.node(i), *(found.is_of_a(i) ? found.b : found.a).body);
}

}  // namespace softcd::bullet
