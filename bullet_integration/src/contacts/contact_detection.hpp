#pragma once

#include <optional>
#include <unordered_set>
#include <vector>

#include "contacts/contact_economy.hpp"
#include "contacts/contact_notes.hpp"
#include "contacts/tangles.hpp"

namespace softcd::bullet {

/// Finds the vertex-face contacts of a world's soft bodies, all in one batch: start() when Bullet has predicted,
/// finish() before its solver.
class ContactDetection {
 public:
  using Kind = ContactsOfKind;

  /// `kind`, `mirror` and `settings` outlive it.
  ContactDetection(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& settings);
  ContactDetection(const ContactDetection&) = delete;
  ContactDetection& operator=(const ContactDetection&) = delete;

  void follow_settings();
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const;
  const std::vector<EdgeContact>& edge_contacts() const { return edge_contacts_; }
  /// With Settings::read_out: about the contacts that the last finish() wrote.
  const ContactNotes& notes() const { return notes_; }

  /// Asks for the bodies that have the world's flag and starts the detection. The rule is asked during the call.
  void start(Span<btSoftBody* const> bodies, const PairRule& rule);
  /// Waits for the detection and writes its contacts into the bodies, which have not changed meanwhile. What touches
  /// gets none where crossings are looked for when the step ends.
  void finish(bool looks_at_crossings);

  /// Removes the face trees that Bullet's prediction built; see FaceTreeWatch. Between start() and finish().
  void drop_unread_face_trees(Span<btSoftBody* const> bodies);
  /// Keeps Bullet's next prediction from building trees without end; see FaceTreeWatch. After finish().
  void hide_flags_of_endless_trees(Span<btSoftBody* const> bodies);

 private:
  bool looks_at_way() const;
  bool looks_for_tangles() const;
  bool has_begun_before(const Contact& contact) const;
  void find_spoilt(Span<const Contact> contacts);
  void find_tangles(Span<const Contact> contacts);
  bool is_released_from_tangles(const MemberContact& found) const;
  bool is_released(const MemberContact& found) const;
  void find_uses(Span<const Contact> contacts);
  ContactUse use_of(const MemberContact& found, bool chooses) const;
  void list_edge_contacts(Span<const Contact> contacts);
  void write_and_note(const MemberContact& found, const ContactShare& share);
  void write(const MemberContact& found, const ContactShare& share) const;

  const ContactsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  Query query_;
  std::optional<Ticket> ticket_;  ///< none where there is nothing to look for
  bool releases_touches_ = false;
  std::vector<EdgeContact> edge_contacts_;
  std::unordered_set<const btSoftBody*> spoilt_;  ///< of their nodes some are not finite, and more will be
  TangledNodes tangled_;
  /// The use of each of the step's contacts. Without economy, none of them counts as one that cannot close.
  std::vector<ContactUse> uses_;
  ContactEconomy economy_;
  ContactNotes notes_;
};

}  // namespace softcd::bullet
