#pragma once

#include <cstdint>
#include <optional>

#include "bodies/world_mirror.hpp"
#include "contacts/solver_contact_batch.hpp"
#include "softcd/bullet/edge_contact.hpp"

/// Makes contacts for Bullet's own arrays, so that its solvers treat them as their own. Makes none if no node of either
/// side can move. Makes none for sleeping bodies either: Bullet neither applies nor clears their contacts, which would
/// pile up.
namespace softcd::bullet {

/// Factor of a node's motion by which Bullet's CollideVF_SS enlarges the node's margin.
inline constexpr float kBulletMotionMargin = 2.0F;

/// The share of a written contact, which may carry other contacts of its node that are not written.
struct ContactShare {
  std::uint32_t count = 1;  ///< contacts that it carries, itself included; 0: it is not written
  btScalar margin_cut = 0;  ///< subtracted from the margin of Bullet's formulas
  bool is_turned = false;   ///< whether it pushes the node back through the face
};

/// Returns whether a face of the body is so small at rest that features on both sides of it are within the margins of
/// contacts within the body. Measured by a right-angled face with two equal sides, whose height is at most the margins.
bool is_finer_than_margins(const WorldMirror::Member& member, std::uint32_t face);

EdgeContact edge_contact_of(const MemberContact& found);

/// Classic worlds: a vertex-triangle contact becomes an SContact of the vertex's body by the formulas of Bullet's
/// CollideVF_SS, if these make a contact. With `dcd` the boxes of node and face in Bullet's trees have to overlap, too.
/// Friction is the part of the sideways motion that Bullet's solver removes for a contact. A contact that carries
/// several removes as much as all of them.
/// Returns none where Bullet would make none. carry_others() makes the contact carry others, and turns it.
std::optional<btSoftBody::SContact> soft_contact(const MemberContact& found, Detection detection);
void carry_others(const ContactShare& share, btSoftBody::SContact& contact);

/// Classic worlds: returns whether the node goes through the face in this step, to the wrong side. That excludes a node
/// that leaves another body, which is closed. It also excludes a node with an edge through the face when the step
/// begins: then no side is known to be the right one.
bool has_crossed_to_wrong_side(const MemberContact& found);

/// Classic worlds: returns the margin_cut with which `one`, at `place` among the contacts that it carries, pushes as
/// all of them would. It is at most what the node's motion adds to both bodies' margins.
btScalar soft_margin_cut(const MemberContact& one, Span<const btSoftBody::SContact> carried, std::size_t place);

/// Classic worlds: an edge-edge contact becomes two SContacts, one for each node of one edge, with a face at the other
/// edge. Together they push the contact's points apart as one contact would.
void write_soft_edge_contact(const MemberContact& found, SoftContactBatch& out);

/// Deformable world: a vertex-triangle contact becomes a DeformableFaceNodeContact of the vertex's body by the formulas
/// of Bullet's CollideVF_DD. Within a body, only where Bullet's rule (CollideFF_DD) has such contacts. A contact that
/// carries several has a larger margin, so that Bullet's spring pushes as hard as all of them.
std::optional<btSoftBody::DeformableFaceNodeContact> deformable_contact(const MemberContact& found);
void carry_others(const MemberContact& found, const ContactShare& share,
                  btSoftBody::DeformableFaceNodeContact& contact);

/// Deformable world: an edge-edge contact becomes two DeformableFaceNodeContacts, as above.
void write_deformable_edge_contact(const MemberContact& found, DeformableContactBatch& out);

}  // namespace softcd::bullet
