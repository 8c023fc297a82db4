#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "BulletCollision/CollisionShapes/btCompoundShape.h"
#include "bodies/vectors.hpp"
#include "bodies/world_mirror.hpp"
#include "rigid/rigid_placement.hpp"
#include "rigid/rigid_touches.hpp"

namespace softcd::bullet {

/// Calls visit(shape, place) for the shape, or for all simple shapes of its compound in order, until one call returns
/// true. Returns whether one did. `place` is the shape's transform.
template <class Visit>
bool any_simple_shape(const btCollisionShape& shape, const btTransform& place, Visit&& visit) {
  if (!shape.isCompound()) return visit(shape, place);
  const auto& compound = static_cast<const btCompoundShape&>(shape);
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    if (any_simple_shape(*compound.getChildShape(i), place * compound.getChildTransform(i), visit)) return true;
  }
  return false;
}

/// A part of RigidParts that a soft body may touch in a step.
struct NearRigidPart {
  btSoftBody* soft;
  BodyId part;
  const btCollisionObject* object;
  const RigidShape* shape;  ///< valid until the part leaves the scene
  btScalar margin;
};

/// A contact between a soft body and a part of RigidParts.
template <class Part>
struct RigidContact {
  const Contact& contact;
  const Part& part;
  const WorldMirror::Member& soft;
  bool is_part_a;  ///< whether side a of the contact is the part

  int first_of_part() const { return is_part_a ? 0 : count_a(); }
  int first_of_soft() const { return is_part_a ? count_a() : 0; }
  int count_of_soft() const { return is_part_a ? 4 - count_a() : count_a(); }

  /// Returns the contact as a touch of the part by the soft body within `margin`.
  RigidTouch touch(btScalar margin) const {
    const int first = first_of_part();
    const int count = is_part_a ? count_a() : 4 - count_a();
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
  btScalar margin() const { return soft.body->getCollisionShape()->getMargin() + part.margin; }

 private:
  int count_a() const { return contact.kind == ContactKind::edge_edge ? 2 : 1; }
};

/// The triangles of rigid shapes in the scene of a world's soft bodies. A part stays as long as pairs require it in
/// every step. `Shape` is a RigidMesh or a ConvexCore.
template <class Key, class Shape>
class RigidParts {
 public:
  struct Part {
    BodyId id;
    Shape shape;
    const btCollisionObject* object = nullptr;
    btScalar margin = 0;
    bool is_required = false;  ///< in this step
  };

  explicit RigidParts(WorldMirror& mirror) : mirror_(mirror) {}
  ~RigidParts() {
    for (const auto& [key, part] : parts_) {
      if (mirror_.scene().has_body(part.id)) mirror_.scene().remove_body(part.id);
    }
  }
  RigidParts(const RigidParts&) = delete;
  RigidParts& operator=(const RigidParts&) = delete;

  /// Begins a step. Call it before require() and want().
  void begin_step() { wanted_.clear(); }
  /// Brings the part up to date at the first call in a step: its triangles, its margin, and its poses at both ends.
  /// `read` reads the triangles into a Shape& and returns whether they have changed.
  template <class Read>
  Part& require(const Key& key, const btCollisionObject& object, btScalar margin, bool has_edges,
                const RigidPoses& poses, Read read) {
    const auto [entry, is_new] = parts_.try_emplace(key);
    Part& part = entry->second;
    if (std::exchange(part.is_required, true)) return part;
    part.object = &object;
    part.margin = margin;
    const bool has_changed = read(part.shape);
    put_in_scene(part, has_edges, is_new, has_changed);
    if (part.shape.place(poses)) {
      mirror_.scene().set_positions(part.id, part.shape.x_t0(), part.shape.x_t1());
    }
    return part;
  }
  /// Returns null for a key that the last step did not require.
  const Part* find(const Key& key) const {
    const auto known = parts_.find(key);
    return known == parts_.end() ? nullptr : &known->second;
  }
  /// Makes the next query test this soft body against the part.
  void want(const Part& part, const btSoftBody& soft) {
    wanted_.emplace_back(std::minmax(part.id.value, mirror_.member(soft).id.value));
  }
  /// Removes parts that no pair required. Returns whether any pair is to be tested.
  bool end_step() {
    for (auto entry = parts_.begin(); entry != parts_.end();) {
      if (std::exchange(entry->second.is_required, false)) {
        ++entry;
        continue;
      }
      mirror_.scene().remove_body(entry->second.id);
      by_id_.erase(entry->second.id.value);
      entry = parts_.erase(entry);
    }
    std::sort(wanted_.begin(), wanted_.end());
    return !wanted_.empty();
  }

  /// Returns whether this pair of a soft body and a part is to be tested.
  bool wants(BodyId a, BodyId b) const {
    return std::binary_search(wanted_.begin(), wanted_.end(), std::pair(a.value, b.value));
  }
  /// Calls visit(RigidContact) for contacts between soft bodies and parts, in their order.
  template <class Visit>
  void for_each_contact(Span<const Contact> contacts, Visit visit) const {
    for (const Contact& contact : contacts) {
      const auto a = by_id_.find(contact.body_a.value);
      const bool is_part_a = a != by_id_.end();
      const Part& part = is_part_a ? *a->second : *by_id_.at(contact.body_b.value);
      const WorldMirror::Member& soft = mirror_.member(is_part_a ? contact.body_b : contact.body_a);
      visit(RigidContact<Part>{contact, part, soft, is_part_a});
    }
  }

 private:
  void put_in_scene(Part& part, bool has_edges, bool is_new, bool has_changed) {
    BodySettings settings;
    settings.margin = std::max(0.0F, static_cast<float>(part.margin));
    settings.self_collision = false;
    settings.features = {/*vertex_triangle=*/true, has_edges};
    const BodyDesc desc = {part.shape.triangles(), part.shape.vertex_count(), settings};
    if (is_new) {
      part.id = mirror_.scene().add_body(desc);
      by_id_[part.id.value] = &part;
    } else if (has_changed) {
      mirror_.scene().update_body(part.id, desc);
    } else {
      mirror_.scene().set_settings(part.id, settings);
    }
  }

  WorldMirror& mirror_;
  std::map<Key, Part> parts_;
  std::unordered_map<std::uint32_t, const Part*> by_id_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> wanted_;  ///< ids of pairs, smaller id first, ascending
};

}  // namespace softcd::bullet
