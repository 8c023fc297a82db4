#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include "bodies/query_options.hpp"
#include "bodies/vectors.hpp"
#include "bodies/world_mirror.hpp"
#include "contacts/tangles.hpp"
#include "rigid/rigid_pairs.hpp"
#include "rigid/rigid_touches.hpp"

namespace softcd::bullet {

/// Returns whether the soft body needs the whole shape of this part of the last step.
using ReadsWhole = std::function<bool(const btSoftBody&, BodyId part)>;

/// A contact between a soft body and a rigid part.
template <class Shape>
struct RigidContact {
  const Contact& contact;
  const RigidPart<Shape>& part;
  const WorldMirror::Member& soft;
  bool is_part_a;  ///< whether side a of the contact is the part

  int first_of_part() const { return is_part_a ? 0 : vertices_of_a(contact); }
  int first_of_soft() const { return is_part_a ? vertices_of_a(contact) : 0; }
  int count_of_soft() const { return is_part_a ? 4 - vertices_of_a(contact) : vertices_of_a(contact); }

  /// Returns the contact as a touch of the part by the soft body within `margin`.
  RigidTouch touch(btScalar margin) const {
    const int first = first_of_part();
    const int count = 4 - count_of_soft();
    const btVector3 normal = to_bullet(contact.normal);
    const auto point = [&](const std::vector<Vec3d>& x) {
      return weighted_point(x, contact.vertices + first, contact.weights + first, count);
    };
    return {
        part.object,           is_part_a ? -normal : normal, margin, point(part.shape.x_t0()), point(part.shape.x_t1()),
        contact.time_of_impact};
  }
  /// Returns whether the points of a contact of two edges are inside both edges. Contacts at an end belong to the
  /// vertex there.
  bool is_inside_edges() const {
    return std::all_of(contact.weights, contact.weights + 4, [](float weight) { return weight > float(kLeastWeight); });
  }
  /// Returns the sum of both margins.
  btScalar margin() const { return margin_of(*soft.body) + part.margin; }
};

/// Finds the contacts of soft bodies with rigid shapes along the paths of a step, whatever Settings::detection is.
/// `Policy` is a MeshPolicy or a ConvexPolicy, which say what a part is and which contacts count. Parts of the shapes
/// are in the mirror. WorldQueries owns one for each policy, and calls read() and find_contacts().
template <class Policy>
class RigidDetection {
 public:
  using Kind = ContactsOfKind;
  using Shape = typename Policy::Shape;

  /// `kind`, `mirror` and `settings` must outlive it.
  RigidDetection(const ContactsOfKind& kind, WorldMirror& mirror, const Settings& settings)
      : kind_(kind),
        mirror_(mirror),
        settings_(settings),
        query_(mirror.scene(), Policy::options(kind, settings)),
        parts_(Policy::parts(mirror.rigid())),
        policy_(kind, mirror, settings, touches_) {
    query_.set_pair_filter([this](BodyId a, BodyId b) { return parts_.wants(a, b); });
  }
  ~RigidDetection() { parts_.clear(); }
  RigidDetection(const RigidDetection&) = delete;
  RigidDetection& operator=(const RigidDetection&) = delete;

  void follow_settings() {
    query_.set_options(Policy::options(kind_, settings_));
    touches_.forget_notes();
    if (!Policy::is_on(settings_)) parts_.clear();
  }
  const Query& query() const { return query_; }
  std::vector<StageReport> explain() const { return query_.explain(); }
  const Policy& policy() const { return policy_; }
  /// Returns notes on the contacts that the last find_contacts() wrote, if Settings::read_out is on.
  const ContactNotes& notes() const { return touches_.notes(); }

  /// Reads the shapes of these pairs near their soft bodies.
  void read(std::vector<RigidPair> pairs, btScalar time_step, const ReadsWhole& reads_whole = {}) {
    // Skips sleeping bodies: Bullet neither solves nor clears their contacts, which would pile up.
    std::erase_if(pairs, [](const RigidPair& pair) { return !pair.soft->isActive() || !Policy::takes(*pair.soft); });
    for (const RigidPair& pair : pairs) mirror_.require(*pair.soft, /*needs_way=*/true);
    parts_.begin_step();
    // Takes shapes in the order in which Bullet dispatched them. Addresses, which make the key, differ from run to run.
    for (auto begin = pairs.begin(); begin != pairs.end();) {
      const RigidKey key = Policy::key_of(*begin);
      const auto end =
          std::stable_partition(begin, pairs.end(), [&](const RigidPair& pair) { return Policy::key_of(pair) == key; });
      policy_.require(key, {&*begin, static_cast<std::size_t>(end - begin)}, time_step, reads_whole, parts_);
      begin = end;
    }
    parts_.end_step();
  }
  /// Returns the parts of the last read() with the soft bodies that may touch them.
  Span<const NearRigidPart> near_parts() const { return parts_.near_parts(); }

  /// Appends the contacts of these parts to the bodies' m_rcontacts (with SDF_RS), or to m_nodeRigidContacts and
  /// m_faceRigidContacts (with SDF_RD). Leaves out `released` nodes; null if there are none.
  void find_contacts(const TangledNodes* released) {
    touches_.forget_notes();
    touches_.clear();
    policy_.begin_contacts(parts_.near_parts(), released);
    if (parts_.near_parts().size() == 0) return;
    for (const Contact& contact : query_.detect()) {
      const auto* const part_a = parts_.find(contact.body_a);
      const auto& part = part_a != nullptr ? *part_a : *parts_.find(contact.body_b);
      const WorldMirror::Member& soft = mirror_.member(part_a != nullptr ? contact.body_b : contact.body_a);
      policy_.take(RigidContact<Shape>{contact, part, soft, part_a != nullptr});
    }
    policy_.end_contacts();
    touches_.prepare_to_write(settings_.read_out != ReadOut::off);
    policy_.before_writing();
    touches_.write();
  }

 private:
  const ContactsOfKind& kind_;
  WorldMirror& mirror_;
  const Settings& settings_;
  Query query_;
  RigidParts<Shape>& parts_;
  RigidTouches touches_;
  Policy policy_;
};

}  // namespace softcd::bullet
