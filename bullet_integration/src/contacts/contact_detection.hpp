#pragma once

#include <memory>
#include <optional>
#include <unordered_set>
#include <vector>

#include "contacts/contact_notes.hpp"
#include "contacts/pressure_motion.hpp"
#include "contacts/solver_contacts.hpp"
#include "contacts/tangles.hpp"

namespace softcd::bullet {

/// Finds all vertex-face contacts of a world's soft bodies in one detection. start() follows Bullet's prediction, and
/// finish() precedes its solver. Owned by WorldQueries, which calls both.
class ContactDetection {
 public:
  using Kind = ContactsOfKind;

  /// `kind`, `mirror` and `settings` must outlive it.
  ContactDetection(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& settings);
  ContactDetection(const ContactDetection&) = delete;
  ContactDetection& operator=(const ContactDetection&) = delete;

  void follow_settings();
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const;
  const std::vector<EdgeContact>& edge_contacts() const { return edge_contacts_; }
  /// Returns notes on the contacts that the last finish() wrote, if Settings::read_out is on.
  const ContactNotes& notes() const { return notes_; }
  /// Returns the pairs of bodies with tangled contacts in the last finish(), some more than once.
  std::vector<ProbeBodies> tangled_bodies() const { return solver_contacts_->tangled_bodies(); }

  /// Brings the bodies that have the world's flag up to date in the mirror.
  void read(Span<btSoftBody* const> bodies);
  /// Starts the detection for these bodies. Calls the rule only until it returns.
  void start(const PairRule& rule);
  /// Waits for the detection and writes its contacts into the bodies, which must not have changed since start(). If
  /// `prevents_crossings`, crossing prevention follows at the step's end, and touching features get no contacts with
  /// `ccd`. Nor do features that pressure alone brings together. `released` are nodes that get no contacts with the
  /// bodies with which they are tangled.
  void finish(bool prevents_crossings, const TangledNodes* released);

 private:
  bool needs_both_ends() const;
  void choose_rule();
  bool looks_for_tangles() const;
  bool has_begun_before(const Contact& contact) const;
  void find_spoilt(Span<const Contact> contacts);
  bool may_be_released(const MemberContact& found) const;
  void find_tangles(Span<const Contact> contacts);
  bool is_released_from_tangles(const MemberContact& found) const;
  bool is_released(const MemberContact& found) const;
  bool may_get(const MemberContact& found) const;
  void find_anchored_nodes();
  void make_solver_contacts(Span<const Contact> contacts);

  const ContactsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  Query query_;
  std::optional<Ticket> ticket_;            ///< none if no body needs a detection
  std::vector<const btSoftBody*> bodies_;   ///< those that need a detection
  bool prevents_crossings_ = false;         ///< with `ccd`, after Bullet's solver
  const TangledNodes* released_ = nullptr;  ///< in finish()
  std::vector<EdgeContact> edge_contacts_;
  std::unordered_set<const btSoftBody*>
      spoilt_;                      ///< some of their nodes are not finite, and the solver would spread this
  PressureMotion pressure_motion_;  ///< read only in classic worlds, and if crossing prevention follows
  TangledNodes tangled_;
  AnchoredNodes anchored_;
  std::vector<std::uint8_t> is_tangled_;  ///< of the step's contacts, if it looks for tangles
  std::unique_ptr<SolverContacts> solver_contacts_;
  bool has_chosen_ = false;  ///< whether the settings of the last step leave out any contact
  ContactCounts found_;      ///< of the last detection
  ContactNotes notes_;
};

}  // namespace softcd::bullet
