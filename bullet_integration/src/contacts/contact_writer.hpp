#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_set>
#include <vector>

#include "bodies/world_mirror.hpp"
#include "contacts/contact_notes.hpp"
#include "contacts/tangles.hpp"
#include "softcd/bullet/edge_contact.hpp"

/// Makes contacts for Bullet's own arrays, so that its solvers treat them as their own. Makes none if no node of either
/// side can move. Makes none for sleeping bodies either: Bullet neither applies nor clears their contacts, which would
/// pile up. In contacts of other bodies, disabled bodies (is_disabled) are immovable.
namespace softcd::bullet {

/// Factor of a node's motion by which Bullet's CollideVF_SS enlarges the node's margin.
inline constexpr float kBulletMotionMargin = 2.0F;

/// Contacts of solvers, made of some of a query's contacts in a row.
template <class T>
class SolverContactBatch {
 public:
  /// Contacts in a row that one body gets.
  struct Run {
    btSoftBody* body;
    std::size_t first;  ///< in the batch
    std::size_t count;
    int place;  ///< of the first one in the body's array
  };

  void clear() {
    contacts.clear();
    runs.clear();
    notes.clear();
  }
  void add(btSoftBody& body, const T& contact) {
    if (runs.empty() || runs.back().body != &body) runs.push_back({&body, contacts.size(), 0, 0});
    ++runs.back().count;
    contacts.push_back(contact);
  }

  std::vector<T> contacts;
  std::vector<Run> runs;
  std::vector<ContactNotes::Note> notes;  ///< with places in the batch until write()
};

/// The share of a written contact, which may carry other contacts of its node that are not written.
struct ContactShare {
  std::uint32_t count = 1;  ///< contacts that it carries, itself included; 0: it is not written
  btScalar margin_cut = 0;  ///< subtracted from the margin of Bullet's formulas
  bool is_turned = false;   ///< whether it pushes the node back through the face
  bool is_tangled = false;  ///< whether one of these contacts is tangled, so that none is written
};

/// The nodes of the deformable world that are anchored to rigid bodies which can move. Bullet's response to contacts
/// between soft bodies does not move such nodes, pushes the other side twice as hard, and gives the rigid body nothing.
class AnchoredNodes {
 public:
  void clear() { nodes_.clear(); }
  void add(const btSoftBody& body);
  /// Returns whether the node or one of the face's nodes is one of them.
  bool has_one_of(const btSoftBody::Node& node, const btSoftBody::Face& face) const;

 private:
  std::unordered_set<const btSoftBody::Node*> nodes_;
};

/// Returns whether a face of the body is so small at rest that features on both sides of it are within the margins of
/// contacts within the body. Measured by a right-angled face with two equal sides, whose height is at most the margins.
bool is_finer_than_margins(const WorldMirror::Member& member, std::uint32_t face);

/// Returns the distance of the node from the face, where both are now.
double distance_from_face(const MemberContact& found);

EdgeContact edge_contact_of(const MemberContact& found);

/// Contacts of classic worlds: btSoftBody::SContact. Bullet's solver treats them in turn, so that one can carry others.
struct ClassicContacts {
  using Entry = btSoftBody::SContact;
  static constexpr bool kSolvesInTurns = true;
  static auto& array(btSoftBody& body) { return body.m_scontacts; }

  /// Makes a vertex-triangle contact of the vertex's body by the formulas of Bullet's CollideVF_SS. Returns none where
  /// these make none. With `dcd` the boxes of node and face in Bullet's trees have to overlap, too.
  static std::optional<Entry> contact_of(const MemberContact& found, Detection detection);
  /// Returns whether the contact has to push the node back through the face: with `dcd`, if the node goes through the
  /// face in this step, to the wrong side. That excludes a node that leaves another body, which is closed. It also
  /// excludes a node with a face tangled with this face when the step begins: then no side is known to be the right
  /// one. Contacts between bodies are turned only if contacts are chosen among (`is_chosen`). Contacts of one pass
  /// share `fan`.
  static bool is_turned(const MemberContact& found, Detection detection, bool is_chosen, FirstFan& fan);
  /// Returns whether, with `dcd`, a face at the node is tangled with another body's face when the step begins. See
  /// tangles.hpp. Contacts of one pass share `fan`.
  static bool is_tangled(const MemberContact& found, Detection detection, FirstFan& fan);
  /// Returns the margin_cut with which `one`, at `place` among the contacts that it carries, pushes as all of them
  /// would. It is at most what the node's motion adds to both bodies' margins.
  static btScalar margin_cut(const MemberContact& one, Span<const Entry> carried, std::size_t place);
  /// Makes the contact carry others, and turns it. Friction is the part of the sideways motion that Bullet's solver
  /// removes for a contact. A contact that carries several removes as much as all of them.
  static void carry(const ContactShare& share, Entry& entry);
  /// Adds two contacts for an edge-edge contact, one for each node of one edge, with a face at the other edge. Together
  /// they push the contact's points apart as one contact would.
  static void add_edges(const MemberContact& found, const AnchoredNodes& anchored, SolverContactBatch<Entry>& out);
};

/// Contacts of the deformable world: btSoftBody::DeformableFaceNodeContact. All contacts of a query are within their
/// margins. Springs push at the same time, so no contact ends the approach for another, none carries others, and none
/// is turned.
struct DeformableContacts {
  using Entry = btSoftBody::DeformableFaceNodeContact;
  static constexpr bool kSolvesInTurns = false;
  static auto& array(btSoftBody& body) { return body.m_faceNodeContacts; }

  /// Makes a vertex-triangle contact of the vertex's body by the formulas of Bullet's CollideVF_DD. Within a body, only
  /// where Bullet's rule (CollideFF_DD) has such contacts.
  static std::optional<Entry> contact_of(const MemberContact& found, Detection detection);
  /// Adds two contacts for an edge-edge contact, as above. Leaves out those with an anchored node: their push
  /// would have no opposite.
  static void add_edges(const MemberContact& found, const AnchoredNodes& anchored, SolverContactBatch<Entry>& out);
};

}  // namespace softcd::bullet
