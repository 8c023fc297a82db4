#pragma once

#include "bodies/world_mirror.hpp"

namespace softcd::bullet {

/// Returns whether another contact of the step is nearer, or as near and of a node, where the surfaces of two bodies
/// lead away from this contact of their edges. False within a body, where neighbours are in no contact. Contacts go
/// by distance.
///
/// A face at one edge leads to the other edge where the angle between them is less than a right one: from there the
/// distance falls until it is least, at a contact that was found earlier or is nearer. Where an end of an edge is
/// nearest, its node has a contact with the face at the other edge.
bool has_nearer_contact(const MemberContact& edges, const NodeEnds& ends);

}  // namespace softcd::bullet
