#pragma once

#include "bodies/world_mirror.hpp"

namespace softcd::bullet {

/// Returns whether the step has a better contact than this one of edges of two bodies: a nearer one, or an equally near
/// one of a node. The surfaces lead from this contact to that one. Returns false within a body, where neighbouring
/// features have no contacts. Contacts are compared by distance.
///
/// A face at one edge leads to the other edge if the angle between them is less than a right angle. From there the
/// distance falls to a minimum, at a contact that was found earlier or is nearer. If an end of an edge is nearest, its
/// node has a contact with the face at the other edge.
bool has_nearer_contact(const MemberContact& edges, const NodeEnds& ends);

/// Returns whether the edges are of one body, and a face finer than the margins leads from the nearest point of one of
/// them to the other one. Such edges are near because the mesh is fine. A contact would push them apart within their
/// surface, all the time, and against its springs.
bool are_joined_by_fine_faces(const MemberContact& edges, const NodeEnds& ends);

}  // namespace softcd::bullet
