#pragma once

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "bodies/world_mirror.hpp"

/// Tangles: features that already intersect when a step begins. Their sides cannot be known. If contacts held them
/// where they are, they could never come apart. Contacts that push some of their nodes to one side and some to the
/// other would drive them for ever.
namespace softcd::bullet {

/// Returns whether any two faces that share no node are tangled at the start of the step. One is at the first feature
/// (around the vertex, or at the edge), the other at the second (the triangle, or at the edge). They are tangled if
/// - their insides have points in common, exactly, or
/// - they touch, and the faces around the shared point are on both sides of each other.
///   This is the case where a sheet passes through another along its edges.
/// Faces that touch from one side or lie in one plane do not count, nor do two links.
bool is_tangled(const MemberContact& found, const NodeEnds& ends);

/// The nodes of all faces at a contact's first feature, at the start of the step. A query lists contacts that have the
/// same first feature in a row, and these share the nodes.
class FirstFan {
 public:
  /// Reads the nodes, unless the contact read last has the same first feature.
  void read(const MemberContact& found, NodePosition start);
  Vec3d origin() const { return origin_; }
  const std::vector<Vec3d>& places() const { return places_; }  ///< of the nodes, each once
  /// Returns the places relative to the origin.
  const std::vector<Vec3d>& offsets() const { return offsets_; }
  double extent() const { return extent_; }  ///< the greatest coordinate of an offset
  /// The ends of the box around the places.
  Vec3d low() const { return low_; }
  Vec3d high() const { return high_; }

 private:
  void add(std::uint32_t node, NodePosition start);

  const WorldMirror::Member* member_ = nullptr;
  std::uint32_t ends_[2] = {};  ///< of the feature, twice the same for a vertex
  std::vector<std::uint32_t> nodes_;
  std::vector<Vec3d> places_, offsets_;
  Vec3d origin_{0, 0, 0};
  double extent_ = 0;
  Vec3d low_{0, 0, 0}, high_{0, 0, 0};
};

/// Does the same for contacts in a row, at the start of one step.
bool is_tangled(const MemberContact& found, const NodeEnds& ends, FirstFan& first);

/// Returns whether the features touch at the start of the step, up to the rounding of double, and are not both links.
bool is_touching(const MemberContact& found, const NodeEnds& ends);

/// Returns whether the insides of such faces have points in common at the end of the step, or both features are links.
/// If features touch at the start and this is false, they intersect nothing at the end, unless other features have met
/// in between. For an edge enters a face at one of its ends, or at an edge of the face, and the features there are
/// found.
bool may_be_tangled_at_the_end(const MemberContact& found, const NodeEnds& ends);

/// Returns whether the vertex starts on one side of the triangle's plane, or the one edge on one side of the other, and
/// does not end there. Exact: features may be nearer to each other than any rounding and still have sides.
bool change_sides(const MemberContact& found, const NodeEnds& ends);

/// The nodes of tangled features, each with the object that it is tangled with.
class TangledNodes {
 public:
  void clear() { nodes_.clear(); }
  /// Adds the nodes of a contact whose features are tangled.
  void add(const MemberContact& found);
  /// Adds a node that is tangled with the object.
  void add(const btSoftBody::Node& node, const btCollisionObject& other) { nodes_.emplace(&node, &other); }
  bool empty() const { return nodes_.empty(); }
  bool has(const btSoftBody::Node& node, const btCollisionObject& other) const {
    return nodes_.count({&node, &other}) > 0;
  }
  /// Returns whether one of the contact's nodes is tangled with the other side's body. `object_of` returns the object
  /// that a side's body represents.
  template <class ObjectOf>
  bool has_one_of(const MemberContact& found, ObjectOf object_of) const {
    if (nodes_.empty()) return false;
    const btCollisionObject& a = object_of(*found.a.body);
    const btCollisionObject& b = object_of(*found.b.body);
    for (int i = 0; i < 4; ++i) {
      if (has(found.node(i), found.is_of_a(i) ? b : a)) return true;
    }
    return false;
  }
  bool has_one_of(const MemberContact& found) const {
    return has_one_of(found, [](const btSoftBody& body) -> const btCollisionObject& { return body; });
  }

 private:
  std::set<std::pair<const btSoftBody::Node*, const btCollisionObject*>> nodes_;
};

}  // namespace softcd::bullet
