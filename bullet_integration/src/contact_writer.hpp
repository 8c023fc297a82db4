#pragma once

#include "softcd/bullet/edge_contact.hpp"
#include "world_mirror.hpp"

/// Puts contacts into Bullet's own arrays, so that its solvers treat them as theirs. Nothing is appended when no node
/// of either side can move, nor to a body that sleeps: Bullet neither applies nor clears its contacts, they would pile
/// up.
namespace softcd::bullet {

/// CollideVF_SS lets a node's margin grow by this many times the distance that it moves.
inline constexpr float kBulletMotionMargin = 2.0F;

EdgeContact edge_contact_of(const MemberContact& found);

/// Classic worlds: a vertex-triangle contact becomes an SContact of the vertex's body with the formulas of Bullet's
/// CollideVF_SS, where these have one. Where it stands for several, itself included, its friction, the part of the
/// sideways motion that Bullet's solver takes away for each, is that of all of them.
bool is_soft_contact(const MemberContact& found, Detection detection);
void write_soft_contact(const MemberContact& found, Detection detection, std::uint32_t stands_for);

/// Classic worlds: whether node and face may come within both bodies' margins by moving twice as far towards each other
/// as in this step, whatever stops either. That is what Bullet lets a node's margin grow for by its motion, also where
/// this is sideways or away.
bool may_close(const MemberContact& found);

/// Classic worlds: an edge-edge contact becomes two SContacts, one for each node of one edge, against a face at the
/// other (the meshes have the faces of nodes). Together they push the contact's points apart as one contact would.
void write_soft_edge_contact(const MemberContact& found);

/// Deformable world: a vertex-triangle contact becomes a DeformableFaceNodeContact of the vertex's body with the
/// formulas of Bullet's CollideVF_DD, where Bullet's rule within a body (CollideFF_DD) has such contacts. A body that
/// touches itself has faces_of_nodes. Where it stands for several, itself included, its margin is as much larger as
/// makes Bullet's spring push as hard as theirs.
bool is_deformable_contact(const MemberContact& found);
void write_deformable_contact(const MemberContact& found, std::uint32_t stands_for);

/// Deformable world: an edge-edge contact becomes two DeformableFaceNodeContacts, as above.
void write_deformable_edge_contact(const MemberContact& found);

}  // namespace softcd::bullet
