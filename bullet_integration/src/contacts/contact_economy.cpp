#include "contacts/contact_economy.hpp"

#include <algorithm>
#include <string>

#include "bodies/vectors.hpp"
#include "contacts/edge_economy.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

/// Returns whether a node gets one contact for each place where the surface is nearest. Bullet's solver of classic
/// worlds treats contacts in turn: with `dcd`, several contacts with one normal would each push by Bullet's growing
/// margin.
bool wants_closest(const ContactsOfKind& kind, const Settings& settings) {
  if (settings.contacts != Contacts::automatic) return settings.contacts == Contacts::closest_feature;
  return kind.solves_in_turns && settings.detection == Detection::dcd;
}

/// Returns whether a push along the one contact's normal also moves out of the other contact.
bool are_on_one_side(const Contact& a, const Contact& b) {
  return dot(a.normal, b.normal) > 0;
}

/// Returns whether the face of contact `other` has the feature at which the contact lies.
bool has_feature(const NodeContact& other, const NodeContact& contact) {
  const std::uint32_t(&v)[4] = other.found.contact.vertices;
  const Triangle face{{v[1], v[2], v[3]}};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    if (contact.has_corner[corner] && !has_vertex(face, contact.found.contact.vertices[corner + 1])) return false;
  }
  return true;
}

}  // namespace

/// Computes the nearest point if weights are below 0. Such contacts are those of ContactRule::slab in the deformable
/// world: the node's projection onto the face's plane lies beside the face, and the contact's distance is that from the
/// plane.
NodeContact node_contact(const MemberContact& found, bool is_turned, bool is_tangled) {
  const Contact& contact = found.contact;
  const float(&w)[4] = contact.weights;
  if (!(w[1] < 0 || w[2] < 0 || w[3] < 0)) {
    return {found, is_turned, is_tangled, double(contact.distance), {w[1] > 0, w[2] > 0, w[3] > 0}};
  }
  const auto x = [&](int vertex) { return to_doubles(found.node(vertex).m_x); };
  const ClosestPoints<double> closest = closest_points_vertex_triangle(x(0), x(1), x(2), x(3));
  const double(&u)[4] = closest.weights;
  return {found, is_turned, is_tangled, closest.distance(), {u[1] > 0, u[2] > 0, u[3] > 0}};
}

ContactEconomy::ContactEconomy(const ContactsOfKind& kind, const Settings& settings)
    : kind_(kind),
      settings_(settings),
      wants_closest_(wants_closest(kind, settings)),
      chooses_edges_(wants_closest_ && settings.edge_contacts == EdgeContacts::respond &&
                     kind.options(settings).contact_rule != ContactRule::slab) {}

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
  const std::array<bool, 3>& has_corner = contacts[i].has_corner;
  if (!wants_closest_ || (has_corner[0] && has_corner[1] && has_corner[2])) return i;
  for (std::size_t nearer = 0; nearer < place; ++nearer) {
    const NodeContact& other = contacts[nearest_first[nearer]];
    if (!has_feature(other, contacts[i])) continue;
    if (are_on_one_side(contacts[other.owner].found.contact, contacts[i].found.contact)) return other.owner;
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
