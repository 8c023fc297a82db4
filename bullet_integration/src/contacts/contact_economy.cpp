#include "contacts/contact_economy.hpp"

#include <algorithm>
#include <string>

#include "contacts/edge_economy.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

/// Returns whether a node gets one contact for each place where the surface is nearest. Bullet's solver of classic
/// worlds treats contacts in turn: with `dcd`, several contacts with one normal would each push by Bullet's growing
/// margin. In the deformable world one contact cannot replace others: each one slows the approach by itself.
bool wants_closest(const ContactsOfKind& kind, const Settings& settings) {
  if (!kind.solves_in_turns) return false;
  if (settings.contacts == Contacts::automatic) return settings.detection == Detection::dcd;
  return settings.contacts == Contacts::closest_feature;
}

/// Returns whether a push along the one contact's normal also moves out of the other contact.
bool are_on_one_side(const Contact& a, const Contact& b) {
  return dot(a.normal, b.normal) > 0;
}

/// Returns whether the contact lies at no edge or corner of its face.
bool lies_inside(const Contact& contact) {
  return std::all_of(contact.weights + 1, contact.weights + 4, [](float weight) { return weight > 0; });
}

/// Returns whether the face of contact `other` has the feature at which the contact lies: face, edge or corner.
bool has_feature(const Contact& other, const Contact& contact) {
  const Triangle face{{other.vertices[1], other.vertices[2], other.vertices[3]}};
  for (int corner = 1; corner < 4; ++corner) {
    if (contact.weights[corner] > 0 && !has_vertex(face, contact.vertices[corner])) return false;
  }
  return true;
}

}  // namespace

NodeContact node_contact(const MemberContact& found, bool is_turned, bool is_tangled) {
  const float(&w)[4] = found.contact.weights;
  const bool is_beside_face = w[1] < 0 || w[2] < 0 || w[3] < 0;
  const double distance = is_beside_face ? distance_from_face(found) : double(found.contact.distance);
  return {found, distance, is_turned, is_tangled};
}

ContactEconomy::ContactEconomy(const ContactsOfKind& kind, const Settings& settings)
    : kind_(kind),
      settings_(settings),
      wants_closest_(wants_closest(kind, settings)),
      chooses_edges_(wants_closest_ && settings.edge_contacts == EdgeContacts::respond) {}

bool ContactEconomy::are_of_one_choice(const Contact& a, const Contact& b) const {
  return chooses() && a.feature_a == b.feature_a && a.body_a == b.body_a && a.body_b == b.body_b &&
         a.kind == ContactKind::vertex_triangle && b.kind == ContactKind::vertex_triangle;
}

bool ContactEconomy::keeps(const MemberContact& edges) const {
  return !are_joined_by_fine_faces(edges, kind_.ends) && (!chooses_edges_ || !has_nearer_contact(edges, kind_.ends));
}

/// Drops contacts of features that intersect when the step begins. They would push some nodes to one side of a surface
/// and some to the other. An open surface has no right side there, so contacts that would be carried by them or carry
/// them are dropped, too. A closed surface keeps those, as they push bodies out of each other.
void ContactEconomy::choose(std::vector<NodeContact>& contacts, std::vector<std::uint32_t>& nearest_first) const {
  nearest_first.clear();
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    if (!(contacts[i].is_tangled && contacts[i].has_closed_face_body())) nearest_first.push_back(i);
  }
  std::sort(nearest_first.begin(), nearest_first.end(), [&](std::uint32_t i, std::uint32_t j) {
    const NodeContact& a = contacts[i];
    const NodeContact& b = contacts[j];
    if (a.time() != b.time()) return a.time() < b.time();
    return a.distance != b.distance ? a.distance < b.distance : i < j;
  });
  for (std::size_t place = 0; place < nearest_first.size(); ++place) {
    NodeContact& contact = contacts[nearest_first[place]];
    contact.owner = owner_of(contacts, nearest_first, place);
    ContactShare& share = contacts[contact.owner].share;
    ++share.count;
    share.is_turned |= contact.is_turned;
    share.is_tangled |= contact.is_tangled;
  }
  for (NodeContact& contact : contacts) {
    if (contact.share.is_tangled) contact.share.count = 0;
  }
  if (settings_.contacts_per_node > 0) drop_all_but_nearest(contacts, nearest_first);
}

/// Returns the owner of the nearest contact whose face has the edge or corner at which contact `nearest_first[place]`
/// lies, if that owner is on the same side. A point of a feature is a point of all its faces, so their nearest points
/// are no farther away. From face to face this leads to a minimum of the distance.
std::uint32_t ContactEconomy::owner_of(const std::vector<NodeContact>& contacts,
                                       const std::vector<std::uint32_t>& nearest_first, std::size_t place) const {
  const std::uint32_t i = nearest_first[place];
  const Contact& contact = contacts[i].found.contact;
  if (!wants_closest_ || lies_inside(contact)) return i;
  for (std::size_t nearer = 0; nearer < place; ++nearer) {
    const NodeContact& other = contacts[nearest_first[nearer]];
    if (!has_feature(other.found.contact, contact)) continue;
    if (are_on_one_side(contacts[other.owner].found.contact, contact)) return other.owner;
  }
  return i;
}

void ContactEconomy::drop_all_but_nearest(std::vector<NodeContact>& contacts,
                                          const std::vector<std::uint32_t>& nearest_first) const {
  for (std::size_t place = 0; place < nearest_first.size(); ++place) {
    NodeContact& contact = contacts[nearest_first[place]];
    std::uint32_t kept = 0;
    for (std::size_t nearer = 0; nearer < place; ++nearer) {
      const NodeContact& other = contacts[nearest_first[nearer]];
      if (other.share.count > 0 && are_on_one_side(other.found.contact, contact.found.contact)) ++kept;
    }
    if (kept >= settings_.contacts_per_node) contact.share.count = 0;
  }
}

StageReport report_on_economy(bool chooses, const ContactCounts& given, const ContactCounts& all) {
  constexpr DetectionStage kStage = DetectionStage::contact_economy;
  if (!chooses) return {kStage, false, "Bullet's solver gets all contacts"};
  const auto share = [](std::size_t part, std::size_t whole) {
    return std::to_string(part) + " of " + std::to_string(whole);
  };
  return {kStage, true,
          "Bullet's solver gets " + share(given.of_nodes, all.of_nodes) + " contacts of nodes with faces, and " +
              share(given.of_edges, all.of_edges) + " of edges"};
}

}  // namespace softcd::bullet
