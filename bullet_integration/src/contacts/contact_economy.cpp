#include "contacts/contact_economy.hpp"

#include <algorithm>
#include <string>

#include "bodies/vectors.hpp"
#include "contacts/contact_walks.hpp"
#include "contacts/edge_economy.hpp"
#include "softcd/core/parallel.hpp"
#include "softcd/math/closest_point.hpp"
#include "softcd/mesh/features.hpp"

namespace softcd::bullet {
namespace {

using Nearest = ContactEconomy::Nearest;

/// Returns whether a node gets one contact for each place where the surface is nearest. Bullet's solver of classic
/// worlds treats contacts in turn: with `dcd`, several contacts with one normal would each push by Bullet's growing
/// margin.
bool wants_closest(const ContactsOfKind& kind, const Settings& settings) {
  if (settings.contacts != Contacts::automatic) return settings.contacts == Contacts::closest_feature;
  return kind.solves_in_turns && settings.detection == Detection::dcd;
}

constexpr std::size_t kContactsAtOnce = 1024;

Vec3d position_of(const WorldMirror::Member& member, std::uint32_t node) {
  return to_doubles(member.body->m_nodes[static_cast<int>(node)].m_x);
}

/// Computes the nearest point if weights are below 0. Such contacts are those of ContactRule::slab in the deformable
/// world: the node's projection onto the face's plane lies beside the face, and the contact's distance is that from the
/// plane.
Nearest nearest_of(const MemberContact& found, bool is_used, bool is_turned) {
  const Contact& contact = found.contact;
  const float(&w)[4] = contact.weights;
  if (!(w[1] < 0 || w[2] < 0 || w[3] < 0)) {
    return {double(contact.distance), contact.time_of_impact, {w[1] > 0, w[2] > 0, w[3] > 0}, is_used, is_turned};
  }
  const std::uint32_t(&v)[4] = contact.vertices;
  const ClosestPoints<double> closest = closest_points_vertex_triangle(
      position_of(found.a, v[0]), position_of(found.b, v[1]), position_of(found.b, v[2]), position_of(found.b, v[3]));
  const double(&u)[4] = closest.weights;
  return {closest.distance(), contact.time_of_impact, {u[1] > 0, u[2] > 0, u[3] > 0}, is_used, is_turned};
}

bool are_of_one_node_and_body(const Contact& a, const Contact& b) {
  return a.feature_a == b.feature_a && a.body_a == b.body_a && a.body_b == b.body_b;
}

/// Returns whether a push along the one contact's normal also moves out of the other contact.
bool are_on_one_side(const Contact& a, const Contact& b) {
  return dot(a.normal, b.normal) > 0;
}

/// Chooses among one node's contacts with one body; each array has `count` elements. A contact's owner is the contact
/// that carries its push, possibly itself.
class NodeChoice {
 public:
  NodeChoice(const ContactsOfKind& kind, const WorldMirror& mirror, const Settings& settings)
      : kind_(kind), mirror_(mirror), settings_(settings), wants_closest_(wants_closest(kind, settings)) {}

  void choose(std::size_t count, const Contact* contacts, const Nearest* nearest, ContactShare* shares) {
    contacts_ = contacts;
    nearest_ = nearest;
    shares_ = shares;
    put_nearest_first(count);
    find_owners(count);
    if (settings_.contacts_per_node > 0) drop_all_but_nearest();
    for (const std::uint32_t i : order_) {
      if (shares_[i].count > 1) cut_margin(i, count);
    }
  }

 private:
  void put_nearest_first(std::size_t count) {
    order_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      if (nearest_[i].is_used) order_.push_back(i);
    }
    std::sort(order_.begin(), order_.end(), [this](std::uint32_t i, std::uint32_t j) {
      const Nearest& a = nearest_[i];
      const Nearest& b = nearest_[j];
      if (a.time != b.time) return a.time < b.time;
      return a.distance != b.distance ? a.distance < b.distance : i < j;
    });
  }

  void find_owners(std::size_t count) {
    owners_.resize(count);
    for (std::size_t place = 0; place < order_.size(); ++place) {
      const std::uint32_t i = order_[place];
      owners_[i] = wants_closest_ ? owner_of(place) : i;
      ContactShare& share = shares_[owners_[i]];
      ++share.count;
      share.is_turned |= nearest_[i].is_turned;
    }
  }

  /// Returns the owner of the nearest contact whose face has the edge or corner at which contact `order_[place]` lies,
  /// if that owner is on the same side. A point of a feature is a point of all its faces, so their nearest points are
  /// no farther away. From face to face this leads to a minimum of the distance.
  std::uint32_t owner_of(std::size_t place) const {
    const std::uint32_t i = order_[place];
    const std::array<bool, 3>& has_corner = nearest_[i].has_corner;
    if (has_corner[0] && has_corner[1] && has_corner[2]) return i;
    for (std::size_t nearer = 0; nearer < place; ++nearer) {
      const std::uint32_t owner = owners_[order_[nearer]];
      if (has_feature(order_[nearer], i) && are_on_one_side(contacts_[owner], contacts_[i])) return owner;
    }
    return i;
  }

  /// Returns whether the face of contact `other` has the feature of contact `i`.
  bool has_feature(std::uint32_t other, std::uint32_t i) const {
    const std::uint32_t(&v)[4] = contacts_[other].vertices;
    const Triangle face{{v[1], v[2], v[3]}};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      if (nearest_[i].has_corner[corner] && !has_vertex(face, contacts_[i].vertices[corner + 1])) return false;
    }
    return true;
  }

  void drop_all_but_nearest() {
    for (std::size_t place = 0; place < order_.size(); ++place) {
      const std::uint32_t i = order_[place];
      std::uint32_t kept = 0;
      for (std::size_t nearer = 0; nearer < place; ++nearer) {
        const std::uint32_t j = order_[nearer];
        if (shares_[j].count > 0 && are_on_one_side(contacts_[j], contacts_[i])) ++kept;
      }
      if (kept >= settings_.contacts_per_node) shares_[i].count = 0;
    }
  }

  /// Cuts the margin of an owner with contacts of several normals. Contacts of one normal are with one point of the
  /// body: the first one to be solved ends the approach for all.
  void cut_margin(std::uint32_t owner, std::size_t count) {
    const WorldMirror::Member& a = mirror_.member(contacts_[owner].body_a);
    const WorldMirror::Member& b = mirror_.member(contacts_[owner].body_b);
    answered_.clear();
    bool are_of_one_normal = true;
    for (std::size_t i = 0; i < count; ++i) {
      if (!nearest_[i].is_used || owners_[i] != owner) continue;
      answered_.push_back({contacts_[i], a, b});
      are_of_one_normal &= contacts_[i].normal == contacts_[owner].normal;
    }
    if (are_of_one_normal) return;
    shares_[owner].margin_cut = kind_.margin_cut({contacts_[owner], a, b}, answered_, settings_.detection);
  }

  const ContactsOfKind& kind_;
  const WorldMirror& mirror_;
  const Settings& settings_;
  bool wants_closest_;
  const Contact* contacts_ = nullptr;
  const Nearest* nearest_ = nullptr;
  ContactShare* shares_ = nullptr;
  std::vector<std::uint32_t> order_, owners_;
  std::vector<MemberContact> answered_;
};

}  // namespace

bool ContactEconomy::chooses() const {
  return wants_closest(kind_, settings_) || settings_.contacts_per_node > 0;
}

void ContactEconomy::choose(Span<const Contact> contacts, Span<const std::uint8_t> is_used) {
  shares_.clear();
  nearest_.clear();
  is_choosing_ = chooses();
  if (!is_choosing_) return;
  shares_.resize(contacts.size());
  choose_nodes(contacts, is_used);
  const bool chooses_edges = wants_closest(kind_, settings_) && settings_.edge_contacts == EdgeContacts::respond &&
                             kind_.options(settings_).contact_rule == ContactRule::distance;
  if (chooses_edges) choose_edges(contacts);
}

void ContactEconomy::choose_nodes(Span<const Contact> contacts, Span<const std::uint8_t> is_used) {
  const std::size_t count = contacts.size() - edge_contacts_in(contacts).size();
  std::fill_n(shares_.begin(), count, ContactShare{/*count=*/0});
  nearest_.resize(count);
  for_each_contact_in_parallel(mirror_, {contacts.begin(), count}, [&](std::size_t i, const MemberContact& found) {
    const bool is_turned = is_used[i] != 0 && kind_.is_turned(found, settings_.detection);
    nearest_[i] = nearest_of(found, is_used[i] != 0, is_turned);
  });
  parallel::for_ranges(count, kContactsAtOnce, [&](std::size_t range_begin, std::size_t range_end) {
    NodeChoice node(kind_, mirror_, settings_);
    for (std::size_t i = range_begin; i < range_end; ++i) {
      if (i > 0 && are_of_one_node_and_body(contacts[i - 1], contacts[i])) continue;
      std::size_t end = i + 1;
      while (end < count && are_of_one_node_and_body(contacts[i], contacts[end])) ++end;
      node.choose(end - i, &contacts[i], &nearest_[i], &shares_[i]);
    }
  });
}

void ContactEconomy::choose_edges(Span<const Contact> contacts) {
  ContactShare* const shares = shares_.data() + nearest_.size();
  for_each_contact_in_parallel(mirror_, edge_contacts_in(contacts), [&](std::size_t i, const MemberContact& found) {
    shares[i].count = has_nearer_contact(found, kind_.ends) ? 0 : 1;
  });
}

StageReport ContactEconomy::report() const {
  constexpr DetectionStage stage = DetectionStage::contact_economy;
  if (!is_choosing_) return {stage, false, "Bullet's solver gets all contacts"};
  const auto given_of = [](auto begin, auto end) {
    const auto given = std::count_if(begin, end, [](const ContactShare& share) { return share.count > 0; });
    return std::to_string(given) + " of " + std::to_string(end - begin);
  };
  const auto edges = shares_.begin() + static_cast<std::ptrdiff_t>(nearest_.size());
  return {stage, true,
          "Bullet's solver gets " + given_of(shares_.begin(), edges) + " contacts of nodes with faces, and " +
              given_of(edges, shares_.end()) + " of edges"};
}

}  // namespace softcd::bullet
