#pragma once

#include <cstdint>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "softcd/bullet/edge_contact.hpp"

/// Puts contacts into Bullet's own arrays, so that its solvers treat them as theirs. Nothing is appended when no node
/// of either side can move, nor to a body that sleeps: Bullet neither applies nor clears its contacts, they would pile
/// up.
namespace softcd::bullet {

/// CollideVF_SS lets a node's margin grow by this many times the distance that it moves.
inline constexpr float kBulletMotionMargin = 2.0F;

/// How a contact that is written answers for others of its node, which are not.
struct ContactShare {
  std::uint32_t count = 1;  ///< of contacts that it answers for, itself included; 0: it is not written
  btScalar margin_cut = 0;  ///< by how much its margin is smaller than by Bullet's formulas
};

EdgeContact edge_contact_of(const MemberContact& found);

/// Classic worlds: a vertex-triangle contact becomes an SContact of the vertex's body with the formulas of Bullet's
/// CollideVF_SS, where these have one. With `dcd` the boxes of node and face in Bullet's trees have to overlap, too.
/// Where it answers for several, its friction, the part of the sideways motion that Bullet's solver takes away for
/// each, is that of all of them.
bool is_soft_contact(const MemberContact& found, Detection detection);
void write_soft_contact(const MemberContact& found, Detection detection, const ContactShare& share);

/// Classic worlds: the margin_cut with which `one` of `several` contacts that are written pushes as all of them would.
/// Only what the node's motion adds to both bodies' margins is cut.
btScalar soft_margin_cut(const MemberContact& one, const std::vector<MemberContact>& several, Detection detection);

/// Classic worlds: whether node and face may come within both bodies' margins by moving twice as far towards each other
/// as in this step, whatever stops either. That is what Bullet lets a node's margin grow for by its motion, also where
/// this is sideways or away.
bool may_close(const MemberContact& found);

/// Classic worlds: an edge-edge contact becomes two SContacts, one for each node of one edge, against a face at the
/// other. Together they push the contact's points apart as one contact would.
void write_soft_edge_contact(const MemberContact& found);

/// Deformable world: a vertex-triangle contact becomes a DeformableFaceNodeContact of the vertex's body with the
/// formulas of Bullet's CollideVF_DD, where Bullet's rule within a body (CollideFF_DD) has such contacts. Where it
/// answers for several, its margin is as much larger as makes Bullet's
/// spring push as hard as theirs.
bool is_deformable_contact(const MemberContact& found);
void write_deformable_contact(const MemberContact& found, const ContactShare& share);

/// Deformable world: an edge-edge contact becomes two DeformableFaceNodeContacts, as above.
void write_deformable_edge_contact(const MemberContact& found);

}  // namespace softcd::bullet
