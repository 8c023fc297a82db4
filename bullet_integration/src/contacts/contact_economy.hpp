#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "contacts/contacts_of_kind.hpp"

namespace softcd::bullet {

/// What a contact is to Bullet's solver.
enum class ContactUse : std::uint8_t {
  none,          ///< it is not written
  cannot_close,  ///< node and face stay away from each other
  may_close,
};

/// Chooses which of a step's contacts Bullet's solver is given: see Settings::contacts and contacts_per_node. A node's
/// contacts with one body are judged by themselves, and so is each of two edges, so that threads share the work; what
/// is chosen depends on the contacts alone.
class ContactEconomy {
 public:
  /// `kind`, `mirror` and `settings` outlive it.
  ContactEconomy(const ContactsOfKind& kind, const WorldMirror& mirror, const Settings& settings)
      : kind_(kind), mirror_(mirror), settings_(settings) {}

  /// Whether it leaves any contact out with the settings.
  bool chooses() const;
  /// Chooses among contacts, in the order in which a query returns them, with the use of each.
  void choose(Span<const Contact> contacts, const std::vector<ContactUse>& uses);
  /// Of the contact at this place.
  ContactShare share_of(std::size_t i) const { return i < shares_.size() ? shares_[i] : ContactShare(); }
  /// A line of explain() about what was chosen last.
  StageReport report() const;

  /// Where on its face a contact's point lies, and how early and how near it is.
  struct Nearest {
    double distance;
    float time;
    std::array<bool, 3> has_corner;  ///< of the smallest feature with the point: the face, an edge or a corner
    ContactUse use;
  };

 private:
  void choose_nodes(Span<const Contact> contacts, const std::vector<ContactUse>& uses);
  void choose_edges(Span<const Contact> contacts);

  const ContactsOfKind& kind_;
  const WorldMirror& mirror_;
  const Settings& settings_;
  bool is_choosing_ = false;
  std::vector<Nearest> nearest_;      ///< of vertex-face contacts, which come first
  std::vector<ContactShare> shares_;  ///< of all contacts; empty: each is given
};

}  // namespace softcd::bullet
