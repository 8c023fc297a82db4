#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "contacts/contacts_of_kind.hpp"

namespace softcd::bullet {

/// Chooses the contacts that Bullet's solver gets: see Settings::contacts and contacts_per_node. It judges a node's
/// contacts with one body, and each contact of two edges, separately, so that threads share the work. The choice
/// depends on the contacts alone.
class ContactEconomy {
 public:
  /// `kind`, `mirror` and `settings` must outlive it.
  ContactEconomy(const ContactsOfKind& kind, const WorldMirror& mirror, const Settings& settings)
      : kind_(kind), mirror_(mirror), settings_(settings) {}

  /// Returns whether the settings leave out any contact.
  bool chooses() const;
  /// Chooses among contacts in the order in which a query returns them. Leaves out those for which `is_used` is 0.
  void choose(Span<const Contact> contacts, Span<const std::uint8_t> is_used);
  /// Returns the share of the contact at this index.
  ContactShare share_of(std::size_t i) const { return i < shares_.size() ? shares_[i] : ContactShare(); }
  /// Returns the line of explain() about the last choice.
  StageReport report() const;

  /// The place of a contact's point on its face, its time and its distance.
  struct Nearest {
    double distance;
    float time;
    std::array<bool, 3> has_corner;  ///< the corners of the smallest feature with the point: face, edge or corner
    bool is_used, is_turned;
  };

 private:
  void choose_nodes(Span<const Contact> contacts, Span<const std::uint8_t> is_used);
  void choose_edges(Span<const Contact> contacts);

  const ContactsOfKind& kind_;
  const WorldMirror& mirror_;
  const Settings& settings_;
  bool is_choosing_ = false;
  std::vector<Nearest> nearest_;      ///< of the vertex-face contacts, which precede those of edges
  std::vector<ContactShare> shares_;  ///< of all contacts; if empty, the solver gets each
};

}  // namespace softcd::bullet
