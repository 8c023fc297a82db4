#pragma once

#include <set>
#include <utility>

#include "world_kind.hpp"

/// What is through each other already when a step begins. On which side of each other such features belong cannot be
/// told. Held where they are they could never come apart, and contacts that push some of their nodes to one side and
/// some to the other would drive them for ever.
namespace softcd::bullet {

/// Whether a face at the one feature (around the vertex, at the edge) and a face at the other (the triangle, at the
/// edge) that share no node intersect at the start of the step, certainly: what only touches does not count, nor do two
/// links. The meshes have faces_of_nodes.
bool is_tangled(const MemberContact& found, const WorldKind& kind);

/// The nodes of tangled features, each with the body that it is tangled with.
class TangledNodes {
 public:
  void clear() { nodes_.clear(); }
  /// Adds the nodes of a contact where its features are tangled.
  void add(const MemberContact& found, const WorldKind& kind);
  /// Whether one of the contact's nodes is tangled with the other side's body.
  bool has_one_of(const MemberContact& found) const;

 private:
  std::set<std::pair<const btSoftBody::Node*, const btSoftBody*>> nodes_;
};

}  // namespace softcd::bullet
