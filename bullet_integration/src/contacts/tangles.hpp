#pragma once

#include <set>
#include <utility>

#include "bodies/world_mirror.hpp"

/// What is through each other already when a step begins. On which side of each other such features belong cannot be
/// told. Held where they are they could never come apart, and contacts that push some of their nodes to one side and
/// some to the other would drive them for ever.
namespace softcd::bullet {

/// Whether a face at the one feature (around the vertex, at the edge) and a face at the other (the triangle, at the
/// edge) that share no node intersect at the start of the step, certainly; or they touch then, up to the rounding of
/// double, and all faces around a point that they share are on both sides of each other, as where a sheet goes through
/// another along its edges. What touches from one side, or in one plane, does not count, nor do two links.
bool is_tangled(const MemberContact& found, const NodeEnds& ends);

/// Whether the features touch when the step begins, up to the rounding of double, and are not both links.
bool is_touching(const MemberContact& found, const NodeEnds& ends);

/// Whether such faces intersect at the step's end, certainly, or both features are links. What touches when the step
/// begins is through nothing afterwards unless this is so, or something else has met on the way: an edge gets into a
/// face at one of its ends, or at an edge of the face, and the features there are found.
bool may_be_tangled_at_the_end(const MemberContact& found, const NodeEnds& ends);

/// The nodes of tangled features, each with the body that it is tangled with.
class TangledNodes {
 public:
  void clear() { nodes_.clear(); }
  /// Adds the nodes of a contact where its features are tangled.
  void add(const MemberContact& found, const NodeEnds& ends);
  /// Whether one of the contact's nodes is tangled with the other side's body.
  bool has_one_of(const MemberContact& found) const;

 private:
  bool has_all_of(const MemberContact& found) const;

  std::set<std::pair<const btSoftBody::Node*, const btSoftBody*>> nodes_;
};

}  // namespace softcd::bullet
