#pragma once

#include <unordered_map>
#include <vector>

#include "bodies/body_mesh.hpp"
#include "bodies/node_ends.hpp"
#include "native/native_trees.hpp"
#include "native/pair_gate.hpp"
#include "softcd/bullet/body_filters.hpp"
#include "softcd/bullet/settings.hpp"

namespace softcd::bullet {

/// A world's soft bodies as a scene that all of the world's queries look at. What an app may do to them between two
/// steps (adding, removing, deleting them, new faces, flags, margins) is noticed once a step. Bodies that no query asks
/// for are not in it.
class WorldMirror {
 public:
  struct Member {
    btSoftBody* body = nullptr;
    BodyId id;
    BodyMesh mesh;
    BodySettings settings;
    std::uint64_t filters = 0;  ///< the number of those that the scene has; 0 where it has none
    FaceTreeWatch face_tree;
    bool is_outdated = false;         ///< the mesh, when it was compared
    bool topology_changed = false;    ///< since the step before
    std::uint64_t last_compared = 0;  ///< step; 0 where it is to be compared again
    std::uint64_t last_step = 0;      ///< in which a query asked for it
    bool has_way = false;             ///< the scene has both ends of this step's
    bool is_in_world = false;

    /// The face at an edge, which is numbered as in Contact and joins two nodes, for a contact of Bullet's: one of the
    /// body's, or one that stands for a link.
    btSoftBody::Face& face_at_edge(std::uint32_t edge, const std::uint32_t* nodes) const {
      if (!mesh.link_faces.empty()) return link_face(edge);
      return body->m_faces[static_cast<int>(bullet::face_at_edge(mesh, nodes[0], nodes[1]))];
    }
    btSoftBody::Face& link_face(std::uint32_t edge) const {
      return const_cast<btSoftBody::Face&>(mesh.link_faces[edge]);
    }
  };

  /// `ends` and `settings`, the world's, outlive it. Throws as Scene's constructor.
  WorldMirror(const NodeEnds& ends, const Settings& settings);
  WorldMirror(const WorldMirror&) = delete;
  WorldMirror& operator=(const WorldMirror&) = delete;

  /// The settings have changed. Throws as Scene::set_options.
  void follow_settings();
  /// Throws InvalidInput; see WorldDetection.
  void set_filters(const btSoftBody& body, BodyFilters filters);
  Scene& scene() { return scene_; }

  /// Before anything is asked for in a step: these are the world's soft bodies now. Stand-ins are bodies of ours that
  /// may be asked for, too, and are in no world.
  void begin_step(Span<btSoftBody* const> bodies, Span<btSoftBody* const> stand_ins = {}) noexcept;
  /// The app has had the world since begin_step(): these bodies are still there, and may have other faces and settings.
  void resume_step(Span<btSoftBody* const> bodies, Span<btSoftBody* const> stand_ins = {}) noexcept;
  /// What takes longest in require(), for all of them in parallel: to compare topologies.
  void compare(Span<btSoftBody* const> bodies);
  /// Sees to it that the body is in the scene as it is in this step, with where it is at the step's start, and, when
  /// `needs_way`, at its end.
  Member& require(btSoftBody& body, bool needs_way);
  /// Whether it was asked for in this step.
  bool has(const btSoftBody& body) const;
  /// Where the nodes of a body that is there go in this step has changed.
  void update_way(Member& member);

  /// A query has failed, perhaps before positions that it had set were read: all bodies are new in the next step.
  void forget_all() { forgets_all_ = true; }

  /// Null where the id is none of a soft body.
  const Member* find(BodyId id) const;
  Member& member(BodyId id) const { return *members_by_id_.at(id.value); }
  Member& member(const btSoftBody& body) { return members_.at(&body); }

  /// Calls visit(const MemberContact&) for contacts between soft bodies, in their order.
  template <class Visit>
  void for_each_contact(Span<const Contact> contacts, Visit visit) const;

 private:
  /// A body's filters, and where its nodes were when they were set.
  struct KeptFilters {
    BodyFilters filters;
    std::vector<Vec3d> x_rest;
    std::uint64_t number = 0;
    bool is_in_world = false;
  };

  void keep_filters_of(Span<btSoftBody* const> bodies) noexcept;
  void drop_unfit_filters(const btSoftBody& body);
  BodySettings settings_of(const btSoftBody& body) const;
  void pass_on_filters(Member& member);
  Member& add(btSoftBody& body, const BodySettings& settings);
  void update(Member& member, const BodySettings& settings);
  void update_mesh(Member& member, const BodySettings& settings);
  void compare(Member& member) const;
  void set_positions(Member& member, bool needs_way);
  template <class Predicate>
  void keep(Span<btSoftBody* const> bodies, Span<btSoftBody* const> stand_ins, Predicate is_kept) noexcept;

  const NodeEnds& ends_;
  const Settings& settings_;
  Scene scene_;
  std::unordered_map<const btSoftBody*, Member> members_;
  std::unordered_map<std::uint32_t, Member*> members_by_id_;
  std::unordered_map<const btSoftBody*, KeptFilters> filters_;
  std::uint64_t last_filters_ = 0;
  std::uint64_t step_ = 1;
  bool forgets_all_ = false;
};

/// A contact whose sides are looked up.
struct MemberContact {
  const Contact& contact;
  const WorldMirror::Member& a;
  const WorldMirror::Member& b;
};

/// Triangles behind a body's faces stand for single nodes, which Bullet has no contacts with.
inline bool is_with_face(const MemberContact& found) {
  return found.contact.feature_b < found.b.mesh.face_count;
}

/// Returns what a query of the mirror's scene asks, whose rule this is. `mirror` and `rule` outlive the filter. A body
/// may touch itself where its settings say so.
inline PairFilter pair_filter(const WorldMirror& mirror, const PairRule& rule) {
  return [&](BodyId a, BodyId b) {
    if (a == b) return true;
    const WorldMirror::Member* const member_a = mirror.find(a);
    const WorldMirror::Member* const member_b = mirror.find(b);
    return member_a != nullptr && member_b != nullptr && rule(*member_a->body, *member_b->body);
  };
}

template <class Visit>
void WorldMirror::for_each_contact(Span<const Contact> contacts, Visit visit) const {
  const Member* a = nullptr;
  const Member* b = nullptr;
  for (const Contact& contact : contacts) {
    if (a == nullptr || a->id != contact.body_a) a = &member(contact.body_a);
    if (b == nullptr || b->id != contact.body_b) b = &member(contact.body_b);
    visit(MemberContact{contact, *a, *b});
  }
}

}  // namespace softcd::bullet
