#pragma once

#include <unordered_map>

#include "native_trees.hpp"
#include "snapshot_reader.hpp"

namespace softcd::bullet {

/// The soft bodies that a pipeline knows. What an app may do to them between two detections (adding, removing, deleting
/// them, new faces, flags, margins) is noticed in synchronize() and remove_absent().
class SoftBodyRegistry {
 public:
  struct Member {
    btSoftBody* body = nullptr;
    BodyId id;
    BodyMesh mesh;
    BodySettings settings;
    FaceTreeWatch face_tree;
    bool topology_changed = false;    ///< since the detection before
    std::uint64_t last_compared = 0;  ///< round
    std::uint64_t last_round = 0;
  };

  /// `pipeline` outlives the registry.
  explicit SoftBodyRegistry(CollisionPipeline& pipeline) : pipeline_(pipeline) {}

  /// What takes longest in synchronize(), for all of them in parallel: to compare topologies.
  void compare(Span<btSoftBody* const> bodies);
  /// Makes the pipeline's body agree with Bullet's, adding it where it is new.
  Member& synchronize(btSoftBody& body, const BodySettings& settings);
  void set_settings(Member& member, const BodySettings& settings);
  /// Removes the bodies that were not synchronized since the last call.
  void remove_absent();

  Member& member(BodyId id) const { return *members_by_id_.at(id.value); }
  BodyId id_of(const btSoftBody& body) const { return members_.at(&body).id; }

  /// Calls visit(const MemberContact&) for the pipeline's contacts, in their order.
  template <class Visit>
  void for_each_contact(Span<const Contact> contacts, Visit visit) const;

  template <class Visit>
  void for_each(Visit visit) {
    for (auto& [body, member] : members_) visit(member);
  }

 private:
  Member& add(btSoftBody& body, const BodySettings& settings);
  void compare(Member& member) const;
  void update(Member& member, const BodySettings& settings);

  CollisionPipeline& pipeline_;
  std::unordered_map<const btSoftBody*, Member> members_;
  std::unordered_map<std::uint32_t, Member*> members_by_id_;
  std::uint64_t round_ = 1;
};

/// A contact whose sides are looked up.
struct MemberContact {
  const Contact& contact;
  const SoftBodyRegistry::Member& a;
  const SoftBodyRegistry::Member& b;
};

/// Triangles behind a body's faces stand for single nodes, which Bullet has no contacts with.
inline bool is_with_face(const MemberContact& found) {
  return found.contact.feature_b < found.b.mesh.face_count;
}

template <class Visit>
void SoftBodyRegistry::for_each_contact(Span<const Contact> contacts, Visit visit) const {
  const Member* a = nullptr;
  const Member* b = nullptr;
  for (const Contact& contact : contacts) {
    if (a == nullptr || a->id != contact.body_a) a = &member(contact.body_a);
    if (b == nullptr || b->id != contact.body_b) b = &member(contact.body_b);
    visit(MemberContact{contact, *a, *b});
  }
}

}  // namespace softcd::bullet
