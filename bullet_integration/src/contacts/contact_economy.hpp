#pragma once

#include <cstdint>
#include <vector>

#include "contacts/contact_writer.hpp"
#include "contacts/contacts_of_kind.hpp"

namespace softcd::bullet {

/// A contact of a node with a face that the solver may get.
struct NodeContact {
  MemberContact found;
  /// The node's distance from the face. By ContactRule::slab that of `found` is the distance from the face's plane.
  double distance;
  bool is_turned;   ///< whether it pushes the node back through the face
  bool is_tangled;  ///< whether the features already intersect when the step begins
  /// The choice: what the solver gets for it, and the contact that carries its push, possibly itself. None carries it
  /// if it is dropped.
  ContactShare share = {/*count=*/0};
  std::uint32_t owner = kNoIndex;

  bool has_closed_face_body() const { return found.b.mesh.outward != 0; }
  float time() const { return found.contact.time_of_impact; }
};

NodeContact node_contact(const MemberContact& found, bool is_turned, bool is_tangled);

/// Chooses the contacts that Bullet's solver gets: see Settings::contacts and contacts_per_node. It judges a node's
/// contacts with one body, and each contact of two edges, separately, so that threads share the work. The choice
/// depends on the contacts alone. ContactDetection makes one for each step, and SolverContacts calls it.
class ContactEconomy {
 public:
  /// `kind` and `settings` must outlive it, and stay as they are.
  ContactEconomy(const ContactsOfKind& kind, const Settings& settings);

  /// Returns whether the settings leave out any contact.
  bool chooses() const { return wants_closest_ || settings_.contacts_per_node > 0; }
  /// Returns whether contacts of these two, one after the other in a query, are chosen among together.
  bool are_of_one_choice(const Contact& a, const Contact& b) const;
  /// Chooses among a node's contacts with one body, in the order in which a query returns them.
  void choose(std::vector<NodeContact>& contacts, std::vector<std::uint32_t>& nearest_first) const;
  /// Returns whether the solver gets the contact of two edges.
  bool keeps(const MemberContact& edges) const;

 private:
  std::uint32_t owner_of(const std::vector<NodeContact>& contacts, const std::vector<std::uint32_t>& nearest_first,
                         std::size_t place) const;
  void drop_all_but_nearest(std::vector<NodeContact>& contacts, const std::vector<std::uint32_t>& nearest_first) const;

  const ContactsOfKind& kind_;
  const Settings& settings_;
  bool wants_closest_, chooses_edges_;
};

/// Numbers of contacts, of nodes with faces and of edges.
struct ContactCounts {
  std::size_t of_nodes = 0, of_edges = 0;
};
/// Returns the line of explain() about the last choice, or about none.
StageReport report_on_economy(bool chooses, const ContactCounts& given, const ContactCounts& all);

}  // namespace softcd::bullet
