#include "crossings/impact_zones.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bodies/vectors.hpp"
#include "softcd/core/vec3.hpp"

namespace softcd::bullet {
namespace {

/// Most radians that a zone turns in a step. A body that turns on straight paths grows by the factor sqrt(1 + turn^2),
/// here 3 %.
constexpr double kMostTurn = 0.25;
/// Most sine of the turn of a zone that prescribed nodes carry along.
constexpr double kMostSineOfTurn = 0.9;
/// Least inertia about an axis, relative to the trace. Axes with less do not turn.
constexpr double kLeastInertia = 1e-9;
constexpr int kConstraintSweeps = 100;
constexpr int kChordIterations = 8;

struct PointMass {
  double mass;
  Vec3d position, velocity;
};

struct SymmetricMatrix {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  Vec3d operator*(Vec3d v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
};

/// Returns zero if there is no inverse.
SymmetricMatrix inverse_of(const SymmetricMatrix& m) {
  SymmetricMatrix minors;
  minors.xx = m.yy * m.zz - m.yz * m.yz;
  minors.yy = m.xx * m.zz - m.xz * m.xz;
  minors.zz = m.xx * m.yy - m.xy * m.xy;
  minors.xy = m.xz * m.yz - m.xy * m.zz;
  minors.xz = m.xy * m.yz - m.xz * m.yy;
  minors.yz = m.xy * m.xz - m.xx * m.yz;
  const double determinant = m.xx * minors.xx + m.xy * minors.xy + m.xz * minors.xz;
  if (!(determinant > 0)) return {};
  const double scale = 1 / determinant;
  return {scale * minors.xx, scale * minors.yy, scale * minors.zz,
          scale * minors.xy, scale * minors.xz, scale * minors.yz};
}

}  // namespace

/// The motion of one rigid body with the momentum and the angular momentum of points.
class RigidMotion {
 public:
  explicit RigidMotion(const std::vector<PointMass>& points) {
    for (const PointMass& p : points) {
      mass_ += p.mass;
      center_ = center_ + p.mass * p.position;
      velocity_ = velocity_ + p.mass * p.velocity;
    }
    center_ = (1 / mass_) * center_;
    velocity_ = (1 / mass_) * velocity_;
    SymmetricMatrix inertia;
    Vec3d angular_momentum{};
    for (const PointMass& p : points) {
      const Vec3d r = p.position - center_;
      inertia.xx += p.mass * (r.y * r.y + r.z * r.z);
      inertia.yy += p.mass * (r.x * r.x + r.z * r.z);
      inertia.zz += p.mass * (r.x * r.x + r.y * r.y);
      inertia.xy -= p.mass * r.x * r.y;
      inertia.xz -= p.mass * r.x * r.z;
      inertia.yz -= p.mass * r.y * r.z;
      angular_momentum = angular_momentum + cross(r, p.mass * (p.velocity - velocity_));
    }
    const double least = kLeastInertia * (inertia.xx + inertia.yy + inertia.zz);
    inertia.xx += least;
    inertia.yy += least;
    inertia.zz += least;
    inverse_inertia_ = inverse_of(inertia);
    angular_velocity_ = inverse_inertia_ * angular_momentum;
  }

  void limit_turn(double most) {
    const double rate = std::sqrt(squared_norm(angular_velocity_));
    if (rate > most) angular_velocity_ = (most / rate) * angular_velocity_;
  }

  Vec3d velocity_at(Vec3d position) const { return velocity_ + cross(angular_velocity_, position - center_); }

  /// Returns the velocity to add to velocity_at() for points that move on chords of a turn. It points inward. The sine
  /// of the turn's angle is the angular velocity times the step's length.
  Vec3d inward_velocity_at(Vec3d position, double time_step) const {
    const double rate = std::sqrt(squared_norm(angular_velocity_));
    if (!(rate > 0)) return {};
    const double sine = rate * time_step;
    const double inward = (1 - std::sqrt(1 - sine * sine)) / (time_step * rate * rate);
    return inward * cross(angular_velocity_, cross(angular_velocity_, position - center_));
  }

  /// Limits the velocity of a point along a unit vector to at most `wanted` in size, and to its sign. So energy is only
  /// removed. Returns whether that changes the motion.
  bool keep_within(Vec3d position, Vec3d direction, double wanted) {
    const double now = dot(velocity_at(position), direction);
    const double then = std::clamp(now, std::min(0.0, wanted), std::max(0.0, wanted));
    if (then == now) return false;
    const Vec3d arm = cross(position - center_, direction);
    const double impulse = (then - now) / (1 / mass_ + dot(arm, inverse_inertia_ * arm));
    velocity_ = velocity_ + (impulse / mass_) * direction;
    angular_velocity_ = angular_velocity_ + impulse * (inverse_inertia_ * arm);
    return true;
  }

 private:
  double mass_ = 0;
  Vec3d center_{}, velocity_{}, angular_velocity_{};
  SymmetricMatrix inverse_inertia_;
};

namespace {

/// Returns the rigid motion of points that move on chords.
RigidMotion motion_on_chords(const std::vector<PointMass>& points, double time_step) {
  const auto fit = [time_step](const std::vector<PointMass>& turning) {
    RigidMotion motion(turning);
    motion.limit_turn(kMostSineOfTurn / time_step);
    return motion;
  };
  RigidMotion motion = fit(points);
  for (int i = 0; i < kChordIterations; ++i) {
    std::vector<PointMass> turning = points;
    for (PointMass& p : turning) p.velocity = p.velocity - motion.inward_velocity_at(p.position, time_step);
    motion = fit(turning);
  }
  return motion;
}

}  // namespace

ImpactZones::Node* ImpactZones::root_of(Node* node) {
  const auto [entry, is_new] = parents_.try_emplace(node, node);
  if (is_new) nodes_.push_back(node);
  Node* root = entry->second;
  while (parents_.at(root) != root) root = parents_.at(root);
  while (node != root) node = std::exchange(parents_.at(node), root);
  return root;
}

bool ImpactZones::join(const std::vector<Impact>& impacts) {
  bool has_joined = false;
  for (const Impact& impact : impacts) {
    Node* const root = root_of(impact.nodes[0]);
    for (int i = 0; i < 4; ++i) {
      constraints_[impact.nodes[i]] = impact.constraints[i];
      Node* const other = root_of(impact.nodes[i]);
      if (other == root) continue;
      parents_.at(other) = root;
      has_joined = true;
    }
  }
  return has_joined;
}

void ImpactZones::move_as_one() {
  std::unordered_map<const Node*, std::size_t> zone_of_root;
  std::vector<std::vector<Node*>> zones;
  for (Node* node : nodes_) {
    const auto [zone, is_new] = zone_of_root.try_emplace(root_of(node), zones.size());
    if (is_new) zones.emplace_back();
    zones[zone->second].push_back(node);
  }
  for (const std::vector<Node*>& zone : zones) {
    move_as_one(zone, &Node::m_v);
    move_as_one(zone, &Node::m_splitv);
  }
}

Vec3d ImpactZones::place_of(const Node& node) const {
  return to_doubles(node.*start_);
}

void ImpactZones::keep_within_constraints(const std::vector<Node*>& zone, btVector3 Node::*velocity,
                                          RigidMotion& motion) const {
  bool has_changed = true;
  for (int sweep = 0; has_changed && sweep < kConstraintSweeps; ++sweep) {
    has_changed = false;
    for (const Node* node : zone) {
      const NodeConstraint* constraint = constraint_of(*node);
      const int count = constraint == nullptr ? 0 : constraint->count();
      for (int i = 0; i < count; ++i) {
        const btVector3& direction = constraint->direction(i);
        const double wanted = double((node->*velocity).dot(direction));
        has_changed |= motion.keep_within(place_of(*node), to_doubles(direction), wanted);
      }
    }
  }
}

void ImpactZones::move_as_one(const std::vector<Node*>& zone, btVector3 Node::*velocity) const {
  std::vector<PointMass> prescribed, movable;
  for (const Node* node : zone) {
    const PointMass point = {1, place_of(*node), to_doubles(node->*velocity)};
    if (is_prescribed(*node)) {
      prescribed.push_back(point);
    } else {
      movable.push_back({1 / double(node->m_im), point.position, point.velocity});
    }
  }
  const bool is_carried = !prescribed.empty();
  RigidMotion motion = is_carried ? motion_on_chords(prescribed, time_step_) : RigidMotion(movable);
  if (!is_carried) {
    motion.limit_turn(kMostTurn / time_step_);
    keep_within_constraints(zone, velocity, motion);
  }
  for (Node* node : zone) {
    if (is_prescribed(*node)) continue;
    Vec3d moved = motion.velocity_at(place_of(*node));
    if (is_carried) moved = moved + motion.inward_velocity_at(place_of(*node), time_step_);
    node->*velocity = to_bullet(moved);
  }
}

}  // namespace softcd::bullet
