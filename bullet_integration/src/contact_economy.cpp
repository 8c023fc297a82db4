#include "contact_economy.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <string>

#include "softcd/math/closest_point.hpp"

namespace softcd::bullet {
namespace {

using Nearest = ContactEconomy::Nearest;
using ContactRange = tbb::blocked_range<std::size_t>;

constexpr std::size_t kContactsAtOnce = 1024;

Vec3d position_of(const WorldMirror::Member& member, std::uint32_t node) {
  const btVector3& x = member.body->m_nodes[static_cast<int>(node)].m_x;
  return {double(x.x()), double(x.y()), double(x.z())};
}

/// Weights below 0 are of ContactRule::slab, in the deformable world: the node's foot in the face's plane lies beside
/// the face, and the contact's distance is the one from the plane.
Nearest nearest_of(const MemberContact& found, ContactUse use) {
  const Contact& contact = found.contact;
  const float(&w)[4] = contact.weights;
  if (!(w[1] < 0 || w[2] < 0 || w[3] < 0)) {
    return {double(contact.distance), contact.time_of_impact, {w[1] > 0, w[2] > 0, w[3] > 0}, use};
  }
  const std::uint32_t(&v)[4] = contact.vertices;
  const ClosestPoints<double> closest = closest_points_vertex_triangle(
      position_of(found.a, v[0]), position_of(found.b, v[1]), position_of(found.b, v[2]), position_of(found.b, v[3]));
  const double(&u)[4] = closest.weights;
  return {closest.distance(), contact.time_of_impact, {u[1] > 0, u[2] > 0, u[3] > 0}, use};
}

bool are_of_one_node_and_body(const Contact& a, const Contact& b) {
  return a.feature_a == b.feature_a && a.body_a == b.body_a && a.body_b == b.body_b;
}

/// Whether a push along the one normal moves out of the other contact, too.
bool are_on_one_side(const Contact& a, const Contact& b) {
  return dot(a.normal, b.normal) > 0;
}

/// Chooses among one node's contacts with one body, of which each array has `count`. A contact's owner is the one that
/// stands for it, maybe itself.
class NodeChoice {
 public:
  explicit NodeChoice(const Settings& settings) : settings_(settings) {}

  void choose(std::size_t count, const Contact* contacts, const Nearest* nearest, std::uint32_t* stands_for) {
    contacts_ = contacts;
    nearest_ = nearest;
    stands_for_ = stands_for;
    put_nearest_first(count);
    find_owners(count);
    if (settings_.contacts == Contacts::closest_feature) drop_those_that_cannot_close(count);
    if (settings_.contacts_per_node > 0) drop_all_but_nearest();
  }

 private:
  void put_nearest_first(std::size_t count) {
    order_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      if (nearest_[i].use != ContactUse::none) order_.push_back(i);
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
      owners_[i] = settings_.contacts == Contacts::closest_feature ? owner_of(place) : i;
      ++stands_for_[owners_[i]];
    }
  }

  /// That of the nearest of the nearer faces that have the edge or corner at which the contact is, with an owner on the
  /// contact's side. A point at a feature is a point of all its faces, so that their nearest points are no farther:
  /// from face to face this leads to where the distance has a minimum.
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

  /// Whether the face of contact `other` has the feature of contact `i`.
  bool has_feature(std::uint32_t other, std::uint32_t i) const {
    const std::uint32_t(&v)[4] = contacts_[other].vertices;
    const Triangle face{{v[1], v[2], v[3]}};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      if (nearest_[i].has_corner[corner] && !has_vertex(face, contacts_[i].vertices[corner + 1])) return false;
    }
    return true;
  }

  /// A contact may close where one of those that it stands for may.
  void drop_those_that_cannot_close(std::size_t count) {
    may_close_.assign(count, 0);
    for (const std::uint32_t i : order_) {
      if (nearest_[i].use == ContactUse::may_close) may_close_[owners_[i]] = 1;
    }
    for (std::size_t i = 0; i < count; ++i) stands_for_[i] *= may_close_[i];
  }

  void drop_all_but_nearest() {
    for (std::size_t place = 0; place < order_.size(); ++place) {
      const std::uint32_t i = order_[place];
      std::uint32_t kept = 0;
      for (std::size_t nearer = 0; nearer < place; ++nearer) {
        const std::uint32_t j = order_[nearer];
        if (stands_for_[j] > 0 && are_on_one_side(contacts_[j], contacts_[i])) ++kept;
      }
      if (kept >= settings_.contacts_per_node) stands_for_[i] = 0;
    }
  }

  const Settings& settings_;
  const Contact* contacts_ = nullptr;
  const Nearest* nearest_ = nullptr;
  std::uint32_t* stands_for_ = nullptr;
  std::vector<std::uint32_t> order_, owners_, may_close_;
};

}  // namespace

void ContactEconomy::choose(const WorldMirror& mirror, Span<const Contact> contacts, const Settings& settings,
                            const Rule& rule) {
  stands_for_.clear();
  is_choosing_ = settings.contacts != Contacts::all || settings.contacts_per_node > 0;
  if (!is_choosing_) return;
  const auto* const edges = std::partition_point(
      contacts.begin(), contacts.end(), [](const Contact& c) { return c.kind == ContactKind::vertex_triangle; });
  const auto count = static_cast<std::size_t>(edges - contacts.begin());
  stands_for_.assign(count, 0);
  nearest_.resize(count);
  const ContactRange all(0, count, kContactsAtOnce);
  tbb::parallel_for(all, [&](const ContactRange& range) {
    Nearest* next = &nearest_[range.begin()];
    mirror.for_each_contact(Span<const Contact>(&contacts[range.begin()], range.size()),
                            [&](const MemberContact& found) { *next++ = nearest_of(found, rule(found)); });
  });
  tbb::parallel_for(all, [&](const ContactRange& range) {
    NodeChoice node(settings);
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      if (i > 0 && are_of_one_node_and_body(contacts[i - 1], contacts[i])) continue;
      std::size_t end = i + 1;
      while (end < count && are_of_one_node_and_body(contacts[i], contacts[end])) ++end;
      node.choose(end - i, &contacts[i], &nearest_[i], &stands_for_[i]);
    }
  });
}

StageReport ContactEconomy::report() const {
  const char* const stage = "contact economy";
  if (!is_choosing_) return {stage, false, "Bullet's solver is given all contacts"};
  const auto dropped = std::count(stands_for_.begin(), stands_for_.end(), 0U);
  const auto count = static_cast<std::ptrdiff_t>(stands_for_.size());
  return {stage, true,
          "Bullet's solver is given " + std::to_string(count - dropped) + " of " + std::to_string(count) +
              " contacts of nodes with faces"};
}

}  // namespace softcd::bullet
